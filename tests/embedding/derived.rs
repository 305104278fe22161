//! What is derived can be thrown away at any moment: steps come to the same bits without it.

use crate::common::Square;
use rhexis::components::{ExternalStiffness, Forces, Frames, SolverScratch};
use rhexis::settings::{Advanced, Preconditioner, Settings};
use rhexis::systems::bending::{BendingPasses, DihedralAngles};
use rhexis::systems::fracture::{TearScratch, TipMemory};

/// Puts an empty component in the place of every derived one, where the body has it.
macro_rules! forget {
    ($world:expr, $body:expr, $($component:ty),*) => {
        $( if $world.get::<&$component>($body).is_ok() {
            $world.insert_one($body, <$component>::default()).unwrap();
        } )*
    };
}

#[test]
fn a_tear_goes_on_to_the_same_bits_without_what_is_derived() {
    let solvers = [Preconditioner::Auto, Preconditioner::BlockJacobi];
    for preconditioner in solvers {
        let settings = Settings {
            threads: 1,
            advanced: Advanced { preconditioner, ..Advanced::default() },
            ..Settings::default()
        };
        let hash = |forgets: bool| {
            let mut run = Square::new([20, 16], 60.0).spawn(settings);
            run.stretch_to(0.8);
            let mut lengths = vec![run.log().length];
            for step in 0..24 {
                // The world is lent either way: what is handed out is judged at the next step.
                let world = run.simulation.world_mut();
                if forgets && step % 3 == 0 {
                    let body = run.body;
                    forget!(world, body.entity(), Frames, Forces, ExternalStiffness, SolverScratch);
                    forget!(world, body.entity(), TearScratch, TipMemory, DihedralAngles, BendingPasses);
                }
                run.step();
                lengths.push(run.log().length);
            }
            assert!(lengths.windows(2).any(|pair| pair[1] > pair[0]), "nothing has torn: {lengths:?}");
            run.simulation.hash()
        };
        assert_eq!(hash(true), hash(false), "{preconditioner:?}");
    }
}
