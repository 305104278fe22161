//! The plugin: the simulation, and the systems that step and show it.

use crate::message::{Cause, RhexisError, TissueEvent, TissueGone};
use crate::space::Space;
use crate::world::RhexisWorld;
use crate::{forceps, obstacles, pins, step, tissue};
use bevy::app::{App, Plugin, PostUpdate};
use bevy::asset::AssetEventSystems;
use bevy::ecs::prelude::*;
use bevy::prelude::{Transform, TransformSystems};
use rhexis::settings::{Accuracy, Settings};
use rhexis::simulation::Simulation;

/// Steps of the plugin in `PostUpdate`, in this order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RhexisSystems {
    /// New tissues come into the engine and obstacles into the app, before transforms are propagated.
    Spawn,
    /// Tools follow their transforms, and the steps that are due are made, after transforms are propagated.
    Step,
    /// Events become messages, meshes are written and obstacles follow the engine's, before the changes of assets are told.
    Show,
}

/// Puts a simulation into the app, unless it has a [`RhexisWorld`], and steps and shows it.
#[derive(Clone, Copy, Debug)]
pub struct RhexisPlugin {
    /// Settings of the simulation.
    pub settings: Settings,
    /// Length of a step \[ms\].
    pub dt: f64,
    /// The most steps in a frame; what does not fit is lost, and the tissue goes slower.
    pub most_steps: u32,
    /// Where the engine's space lies in the world: at the origin, a unit per mm, by default.
    pub space: Transform,
    /// Whether meshes are shown between the last two steps.
    pub is_interpolated: bool,
}

impl Default for RhexisPlugin {
    /// Steps of 5 ms, at most 4 per frame, as precise as a game needs.
    fn default() -> Self {
        let settings = Settings::new(Accuracy::Game);
        Self { settings, dt: 5.0, most_steps: 4, space: Transform::IDENTITY, is_interpolated: true }
    }
}

impl Plugin for RhexisPlugin {
    fn build(&self, app: &mut App) {
        app.add_message::<TissueEvent>().add_message::<TissueGone>().add_message::<RhexisError>();
        if !app.world().contains_resource::<RhexisWorld>() {
            self.make_world(app);
        }
        let is_there = resource_exists::<RhexisWorld>;
        let order = (RhexisSystems::Spawn, RhexisSystems::Step, RhexisSystems::Show).chain();
        app.configure_sets(PostUpdate, order.run_if(is_there));
        app.configure_sets(PostUpdate, RhexisSystems::Spawn.before(TransformSystems::Propagate));
        app.configure_sets(PostUpdate, RhexisSystems::Step.after(TransformSystems::Propagate));
        app.configure_sets(PostUpdate, RhexisSystems::Show.before(AssetEventSystems));
        let spawn = (tissue::spawn, obstacles::refuse, obstacles::spawn).chain();
        app.add_systems(PostUpdate, spawn.in_set(RhexisSystems::Spawn));
        app.add_systems(PostUpdate, step::advance.in_set(RhexisSystems::Step));
        let show = (step::tell, tissue::see_gone, tissue::update_meshes, obstacles::follow).chain();
        app.add_systems(PostUpdate, show.in_set(RhexisSystems::Show));
        app.add_observer(tissue::on_removed_tissue).add_observer(tissue::on_removed_body);
        app.add_observer(forceps::on_removed).add_observer(pins::on_removed);
        app.add_observer(obstacles::on_removed_list);
    }

    /// Adds the lines where the app draws any.
    #[cfg(feature = "gizmos")]
    fn finish(&self, app: &mut App) {
        use bevy::gizmos::{AppGizmoBuilder, GizmoPlugin};
        if app.is_plugin_added::<GizmoPlugin>() {
            app.init_resource::<crate::RhexisGizmos>().init_gizmo_group::<crate::RhexisGizmoGroup>();
            app.add_systems(PostUpdate, crate::gizmos::draw.in_set(RhexisSystems::Show));
        }
    }
}

impl RhexisPlugin {
    fn make_world(&self, app: &mut App) {
        let space = Space::new(self.space).unwrap_or_else(|| {
            app.world_mut().write_message(RhexisError::of_world(Cause::BadSpace));
            Space::default()
        });
        let made = Simulation::new(self.settings).and_then(|made| RhexisWorld::new(made, self.dt, self.most_steps));
        match made {
            Ok(made) => {
                app.insert_resource(made.within(space).interpolated(self.is_interpolated));
            }
            // Without a simulation the systems do nothing.
            Err(error) => {
                app.world_mut().write_message(RhexisError::of_world(error));
            }
        }
    }
}
