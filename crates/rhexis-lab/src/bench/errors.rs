//! How far a run is from a reference.

use super::solve::StepError;
use super::trace::{State, Trace};
use crate::verify::tear::hausdorff::farthest;
use rhexis::math::Sym2;
use std::collections::BTreeMap;

/// Two meshes that have no more of their vertices in common than this part have them by chance.
const LEAST_COMMON: f64 = 0.05;

/// Errors of a run; NaN where there is nothing to compare.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Errors {
    /// Stress at interior vertices: rms of the differences over rms of the reference, of the worst state.
    pub stress: f64,
    /// Largest distance of a vertex \[mm\].
    pub position: f64,
    /// Largest difference of the forces of holds and forceps over the largest force of the reference.
    pub force: f64,
    /// How far the tear runs from that of the reference \[mm\].
    pub path: f64,
    /// Part of the vertices that were compared, the mean over the states.
    pub compared: f64,
}

impl Errors {
    /// Errors of `found`: of its single steps where it has them, otherwise of its states.
    pub(super) fn against(found: &Trace, exact: &Trace) -> Self {
        let of_states = Self::of_states(found, exact);
        let worst = |of: fn(&StepError) -> f64| found.step_errors.iter().map(of).fold(0.0, larger);
        match found.step_errors.is_empty() {
            true => of_states,
            false => Self { stress: worst(|step| step.stress), position: worst(|step| step.position), ..of_states },
        }
    }

    /// Errors at the vertices that the two have in common at the times that they have in common: all of them where
    /// they have the same triangles, otherwise those with the same rest position. A vertex of a tear's lips, where two have one
    /// rest position, is left out.
    pub(super) fn of_states(found: &Trace, exact: &Trace) -> Self {
        let of_force = |state: &State| state.forces.iter().map(|f| f.length_squared()).sum::<f64>().sqrt();
        let largest_force = exact.states.iter().map(of_force).fold(0.0, f64::max);
        let (mut stress, mut position, mut force, mut matched) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0);
        let (mut common, mut compared) = (0, 0);
        let mut exact_states = exact.states.iter().peekable();
        for state in &found.states {
            while exact_states.next_if(|other| other.time < state.time - 1e-6).is_some() {}
            let Some(other) = exact_states.peek().filter(|other| other.time < state.time + 1e-6) else { continue };
            common += 1;
            let forces = state.forces.iter().zip(&other.forces).map(|(a, b)| (*a - *b).length_squared());
            force = larger(force, forces.sum::<f64>().sqrt() / largest_force);
            let pairs = pairs(state, other);
            matched += pairs.len() as f64 / state.rest.len() as f64;
            if pairs.len() as f64 <= LEAST_COMMON * state.rest.len() as f64 {
                continue;
            }
            compared += 1;
            stress = larger(stress, stress_error(state, other, &pairs));
            let distance = pairs.iter().map(|&(v, w)| state.positions[v].distance(other.positions[w]));
            position = distance.fold(position, larger);
        }
        let known = |value: f64, count: u32| if count > 0 { value } else { f64::NAN };
        Self {
            stress: known(stress, compared),
            position: known(position, compared),
            force: if largest_force > 0.0 { known(force, common) } else { f64::NAN },
            path: path(found, exact),
            compared: matched / f64::from(common),
        }
    }
}

/// The larger; NaN if one is, so that it cannot hide.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// The vertices of the two that belong together.
fn pairs(found: &State, exact: &State) -> Vec<(usize, usize)> {
    if found.corners == exact.corners {
        return (0..exact.rest.len()).map(|v| (v, v)).collect();
    }
    let (found, exact) = (found.unique(), exact.unique());
    found.iter().filter_map(|(place, &v)| Some((v, *exact.get(place)?))).collect()
}

impl State {
    /// The vertices with a rest position of their own, by that position in nm.
    fn unique(&self) -> BTreeMap<[i64; 3], usize> {
        let mut rows = BTreeMap::new();
        let mut shared = Vec::new();
        for (v, p) in self.rest.iter().enumerate() {
            let place = (*p * 1e6).round().as_i64vec3().to_array();
            if rows.insert(place, v).is_some() {
                shared.push(place);
            }
        }
        shared.iter().for_each(|place| {
            rows.remove(place);
        });
        rows
    }
}

fn stress_error(found: &State, exact: &State, pairs: &[(usize, usize)]) -> f64 {
    let (mut off, mut size) = (0.0, 0.0);
    for &(v, w) in pairs.iter().filter(|&&(v, w)| found.is_inside[v] && exact.is_inside[w]) {
        off += norm_sq(found.stress[v] - exact.stress[w]);
        size += norm_sq(exact.stress[w]);
    }
    (off / size).sqrt()
}

/// Squared Frobenius norm.
pub(super) fn norm_sq(s: Sym2) -> f64 {
    s.contract(s)
}

/// The largest distance of a tip's way from that of the same tip of the reference. Where one has gone farther than the other,
/// the part that both have gone.
fn path(found: &Trace, exact: &Trace) -> f64 {
    if exact.paths.is_empty() && found.paths.is_empty() {
        return f64::NAN;
    }
    if exact.paths.len() != found.paths.len() {
        return f64::INFINITY;
    }
    let pairs = found.paths.iter().zip(&exact.paths);
    pairs.map(|(a, b)| farthest(a, b).min(farthest(b, a))).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, DVec3};

    fn trace(stretch: f64) -> Trace {
        let at = |x: f64| DVec3::new(x, 0.0, 0.0);
        let state = State {
            time: 1.0,
            corners: vec![[0, 1, 2]],
            rest: vec![at(0.0), at(1.0), at(2.0)],
            positions: vec![at(0.0), at(stretch), at(2.0 * stretch)],
            stress: vec![Sym2::new(stretch, 0.0, 0.0); 3],
            is_inside: vec![true; 3],
            forces: vec![at(stretch)],
        };
        let paths = vec![vec![DVec2::ZERO, DVec2::X]];
        Trace { states: vec![state], paths, ..Trace::default() }
    }

    #[test]
    fn errors_are_relative_to_the_reference() {
        let errors = Errors::against(&trace(1.1), &trace(1.0));
        assert!((errors.stress - 0.1).abs() < 1e-12 && (errors.force - 0.1).abs() < 1e-12, "{errors:?}");
        assert!((errors.position - 0.2).abs() < 1e-12 && errors.compared == 1.0 && errors.path == 0.0, "{errors:?}");
    }

    #[test]
    fn other_triangles_are_compared_where_vertices_have_one_rest_position() {
        let mut found = trace(1.1);
        let state = &mut found.states[0];
        state.corners = vec![[0, 2, 1]];
        // The first two now lie upon each other, as on the lips of a tear.
        state.rest[1] = state.rest[0];
        let errors = Errors::against(&found, &trace(1.0));
        assert!((errors.stress - 0.1).abs() < 1e-12 && (errors.compared - 1.0 / 3.0).abs() < 1e-12, "{errors:?}");
        found.paths.clear();
        assert_eq!(Errors::against(&found, &trace(1.0)).path, f64::INFINITY);
    }
}
