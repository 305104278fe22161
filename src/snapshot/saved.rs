//! One entity as a snapshot keeps it: the one list of what there is to keep.

use crate::components::*;
use crate::membrane::make_room;
use crate::storage::{Mesh, Tips, Topology, Triangles, Vertices};
use crate::systems::linear::{Factor, FactorState, Folds, InnerSolver, InnerState};
use crate::systems::tearing::{TearScratch, TipMemory};
use hecs::{Entity, EntityBuilder, EntityRef, World};
use std::any::TypeId;

/// Declares [`Saved`]. `kept` components are cloned; of `derived` ones it is kept whether they are there, and an empty one takes
/// their place: a step fills them.
macro_rules! saved {
    (kept { $($name:ident: $kept:ty,)* } derived { $($flag:ident: $derived:ty,)* }) => {
        /// A body, an obstacle or a tool with all its components.
        #[derive(Clone)]
        #[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
        pub(crate) struct Saved {
            #[cfg_attr(feature = "snapshot", serde(with = "super::handle"))]
            pub entity: Entity,
            $( pub $name: Option<$kept>, )*
            $( pub $flag: bool, )*
            /// Of a body: follows from its triangles.
            #[cfg_attr(feature = "snapshot", serde(skip))]
            pub topology: Option<Topology>,
            pub scratch: Option<SolverScratch>,
            pub factor: Option<FactorState>,
            pub inner: Option<InnerState>,
        }

        impl Saved {
            /// What there is to keep of an entity; `None` for one that is neither a body nor an obstacle nor a tool.
            pub fn of(entity: EntityRef<'_>) -> Option<Self> {
                if !is_ours(entity) {
                    return None;
                }
                let triangles = entity.get::<&Triangles>();
                Some(Self {
                    entity: entity.entity(),
                    $( $name: entity.get::<&$kept>().map(|component| (*component).clone()), )*
                    $( $flag: entity.has::<$derived>(), )*
                    topology: entity.get::<&Topology>().map(|topology| (*topology).clone()),
                    scratch: entity.get::<&SolverScratch>().map(|scratch| scratch.without_vectors()),
                    factor: entity.get::<&Factor>().map(|factor| factor.state()),
                    inner: entity.get::<&InnerSolver>().zip(triangles).map(|(inner, triangles)| inner.state(&triangles)),
                })
            }

            /// Its components, but for the solvers.
            pub fn into_components(mut self) -> EntityBuilder {
                if let Self {
                    tearing: Some(_), vertices: Some(vertices), triangles: Some(triangles), topology: Some(topology), ..
                } = &mut self
                {
                    make_room(Mesh { vertices, triangles, topology });
                }
                let mut builder = EntityBuilder::new();
                $( if let Some(component) = self.$name { builder.add(component); } )*
                $( if self.$flag { builder.add(<$derived>::default()); } )*
                if let Some(topology) = self.topology {
                    builder.add(topology);
                }
                if let Some(scratch) = self.scratch {
                    builder.add(scratch);
                }
                builder
            }
        }

        /// Whether components of this type belong to the engine.
        fn is_known(id: TypeId) -> bool {
            let known = [
                $( TypeId::of::<$kept>(), )*
                $( TypeId::of::<$derived>(), )*
                TypeId::of::<Topology>(), TypeId::of::<SolverScratch>(), TypeId::of::<Factor>(), TypeId::of::<InnerSolver>(),
            ];
            known.contains(&id)
        }

        /// Leaves an entity with those components that are not the engine's; whether there are any.
        pub(crate) fn strip(world: &mut World, entity: Entity) -> bool {
            let has_others = |entity: EntityRef<'_>| entity.component_types().any(|id| !is_known(id));
            if !world.entity(entity).is_ok_and(has_others) {
                return false;
            }
            $( let _ = world.remove_one::<$kept>(entity); )*
            $( let _ = world.remove_one::<$derived>(entity); )*
            let _ = world.remove_one::<Topology>(entity);
            let _ = world.remove_one::<SolverScratch>(entity);
            let _ = world.remove_one::<Factor>(entity);
            let _ = world.remove_one::<InnerSolver>(entity);
            true
        }
    };
}

/// Whether an entity is a body, an obstacle or a tool.
pub(crate) fn is_ours(entity: EntityRef<'_>) -> bool {
    entity.has::<Body>() || entity.has::<Obstacle>() || entity.has::<Forceps>() || entity.has::<Blade>()
}

// The order is that of the bytes: a change of it, or of what one of them holds, is a new version of the format.
saved! {
    kept {
        body: Body,
        planar: Planar,
        vertices: Vertices,
        triangles: Triangles,
        tips: Tips,
        increment: Increment,
        reactions: Reactions,
        holds: Holds,
        springs: Springs,
        grips: Grips,
        point_loads: PointLoads,
        edge_loads: EdgeLoads,
        damping: Damping,
        gravity: Gravity,
        pressure: Pressure,
        drag: Drag,
        pre_stretch: PreStretch,
        stiffening_fibres: StiffeningFibres,
        contact: Contact,
        bending: Bending,
        obstacle: Obstacle,
        obstacle_path: ObstaclePath,
        swept: Swept,
        forceps: Forceps,
        blade: Blade,
        tearing: Tearing,
        energy_criterion: EnergyCriterion,
        refinement: Refinement,
        refined: Refined,
        tear_decisions: TearDecisions,
        tear_log: TearLog,
        energy_audit: EnergyAudit,
        sleeping: Sleeping,
        holzapfel_gasser_ogden: HolzapfelGasserOgden,
    }
    derived {
        has_frames: Frames,
        has_forces: Forces,
        has_external_stiffness: ExternalStiffness,
        has_tear_scratch: TearScratch,
        has_tip_memory: TipMemory,
        has_folds: Folds,
        has_changes: Changes,
    }
}
