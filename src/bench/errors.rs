//! How far a run is from a reference.

use super::trace::{State, Trace};
use crate::math::Sym2;
use crate::verify::tear::hausdorff::farthest;
use std::collections::HashMap;

/// Errors of a run; NaN where there is nothing to compare.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Stress at interior vertices: rms of the differences over rms of the reference, of the worst state.
    pub stress: f64,
    /// The same, rms over all states.
    pub mean_stress: f64,
    /// Largest distance of a vertex \[mm\].
    pub position: f64,
    /// Largest difference of the forces of holds and forceps over the largest force of the reference.
    pub force: f64,
    /// How far the tear runs from that of the reference \[mm\].
    pub path: f64,
    /// Part of the states in which the two have the same triangles, or common vertices, and were compared.
    pub compared: f64,
}

impl Errors {
    /// Against a run of the same mesh, vertex by vertex, in those states in which tears have left both with the same triangles.
    pub fn against(found: &Trace, exact: &Trace) -> Self {
        let pair = |found: &State, exact: &State| {
            (found.corners == exact.corners).then(|| (0..exact.rest.len()).map(|v| (v, v)).collect())
        };
        Self::with_pairs(found, exact, pair)
    }

    /// Against a run of a finer mesh, at the vertices that both have. A tear leaves hardly any: then only forces and paths.
    pub fn against_finer(found: &Trace, exact: &Trace) -> Self {
        let pair = |found: &State, exact: &State| {
            // Vertices on both lips of a tear have one rest position: those are left out.
            if !found.is_untorn() || !exact.is_untorn() {
                return None;
            }
            let key = |p: &glam::DVec3| (*p * 1e6).round().as_i64vec3();
            let rows: HashMap<_, usize> = exact.rest.iter().enumerate().map(|(row, p)| (key(p), row)).collect();
            let pairs = found.rest.iter().enumerate().filter_map(|(v, p)| rows.get(&key(p)).map(|&row| (v, row)));
            Some(pairs.collect())
        };
        Self::with_pairs(found, exact, pair)
    }

    fn with_pairs(found: &Trace, exact: &Trace, pair: impl Fn(&State, &State) -> Option<Vec<(usize, usize)>>) -> Self {
        let of_force = |state: &State| state.forces.iter().map(|f| f.length_squared()).sum::<f64>().sqrt();
        let largest_force = exact.states.iter().map(of_force).fold(0.0, f64::max);
        let (mut stress, mut squares, mut position, mut force) = (0.0_f64, 0.0, 0.0_f64, 0.0_f64);
        let (mut common, mut compared) = (0, 0);
        let mut exact_states = exact.states.iter().peekable();
        for state in &found.states {
            while exact_states.next_if(|other| other.time < state.time - 1e-6).is_some() {}
            let Some(other) = exact_states.peek().filter(|other| other.time < state.time + 1e-6) else { continue };
            common += 1;
            let forces = state.forces.iter().zip(&other.forces).map(|(a, b)| (*a - *b).length_squared());
            force = force.max(forces.sum::<f64>().sqrt() / largest_force);
            let Some(pairs) = pair(state, other).filter(|pairs| !pairs.is_empty()) else { continue };
            compared += 1;
            let error = stress_error(state, other, &pairs);
            stress = stress.max(error);
            squares += error * error;
            let distance = pairs.iter().map(|&(v, w)| state.positions[v].distance(other.positions[w]));
            position = distance.fold(position, f64::max);
        }
        let known = |value: f64, count: i32| if count > 0 { value } else { f64::NAN };
        Self {
            stress: known(stress, compared),
            mean_stress: (squares / f64::from(compared)).sqrt(),
            position: known(position, compared),
            force: if largest_force > 0.0 { known(force, common) } else { f64::NAN },
            path: path(found, exact),
            compared: f64::from(compared) / f64::from(common),
        }
    }
}

impl State {
    /// Whether no two vertices have the same rest position.
    fn is_untorn(&self) -> bool {
        let mut keys: Vec<_> = self.rest.iter().map(|p| (*p * 1e6).round().as_i64vec3().to_array()).collect();
        keys.sort_unstable();
        keys.windows(2).all(|pair| pair[0] != pair[1])
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
pub fn norm_sq(s: Sym2) -> f64 {
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
        let (found, exact) = (trace(1.1), trace(1.0));
        for errors in [Errors::against(&found, &exact), Errors::against_finer(&found, &exact)] {
            assert!((errors.stress - 0.1).abs() < 1e-12 && (errors.force - 0.1).abs() < 1e-12, "{errors:?}");
            assert!(
                (errors.position - 0.2).abs() < 1e-12 && errors.compared == 1.0 && errors.path == 0.0,
                "{errors:?}"
            );
        }
    }

    #[test]
    fn other_triangles_are_not_compared() {
        let mut found = trace(1.1);
        found.states[0].corners = vec![[0, 2, 1]];
        let errors = Errors::against(&found, &trace(1.0));
        assert!(errors.stress.is_nan() && errors.compared == 0.0 && errors.force > 0.0);
        found.paths.clear();
        assert_eq!(Errors::against(&found, &trace(1.0)).path, f64::INFINITY);
    }
}
