//! Springs that break where their traction is too large.

use super::error::{Fault, positive};
use super::schema::BodySpec;
use rhexis::components::{Anchor, Springs};
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, BodyId, Vertices};

/// Traction \[MPa\] at which the springs of a body break; none where they hold for ever.
pub(super) fn limit(spec: &BodySpec, key: &str) -> Result<Option<f64>, Fault> {
    let mut all: Option<Option<f64>> = None;
    for (i, group) in spec.springs.iter().enumerate() {
        let key = format!("{key}.springs.{i}.break_traction");
        let own = group.break_traction.map(|traction| positive(key.clone(), traction, "MPa")).transpose()?;
        if *all.get_or_insert(own) != own {
            let what = "springs of one body break at one traction, where two groups meet too";
            return Err(Fault::new(key, what, "give all groups the same, or none to any"));
        }
    }
    Ok(all.flatten())
}

/// Takes away the springs of a body whose traction is above a limit \[MPa\]. Returns their number.
pub(super) fn part(simulation: &mut Simulation, body: BodyId, limit: f64) -> usize {
    let (kept, broken) = {
        let mut query = simulation.world().query_one::<(&Vertices, &Springs)>(body.entity());
        let Ok((vertices, Springs { anchors })) = query.get() else { return 0 };
        let all = anchors.rows().iter().copied().zip(anchors.values().iter().copied());
        let holds = |(row, Anchor { point, stiffness, .. }): &(u32, Anchor)| {
            stiffness * vertices.position[*row as usize].distance(*point) <= limit
        };
        let kept = Attached::new(all.filter(holds));
        let broken = anchors.rows().len() - kept.rows().len();
        (kept, broken)
    };
    // Fewer springs of a body that has them are never refused.
    let is_done = broken > 0 && simulation.set(body, Springs { anchors: kept }).is_ok();
    if is_done { broken } else { 0 }
}
