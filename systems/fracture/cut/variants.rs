//! Other ends for a cut that finds no room at its own: along the line, then at vertices nearby.

use crate::systems::fracture::Cutter;
use crate::systems::fracture::cut::cut_line::distance_to_segment;
use glam::DVec3;
use smallvec::SmallVec;

/// Parts of the mean edge by which an end inside the body goes on along its line, or back, where it finds no room.
const SHIFTS: [f64; 5] = [0.0, 0.25, -0.25, 0.5, -0.5];
/// An end goes back by this part of the last segment at the most.
const FARTHEST_BACK: f64 = 0.5;
/// Number of vertices near an end that are tried in its place.
const PLACES: usize = 2;

/// Lines in place of those asked for, and the largest distance of an end \[mm\].
type Variant = (Vec<Vec<DVec3>>, f64);

impl Cutter<'_, '_> {
    /// Variants of the lines with their ends inside the body moved farther on or farther back, and the larger of those shifts
    /// \[mm\]; the smallest shift first.
    pub(super) fn shifted(&self, lines: &[Vec<DVec3>], edge: f64) -> Vec<Variant> {
        let shifts_at = |end: Option<&DVec3>| match end {
            Some(&end) if self.is_tissue(end) => SHIFTS.as_slice(),
            _ => &SHIFTS[..1],
        };
        let Some(line) = lines.first() else { return Vec::new() };
        let (of_first, of_last) = (shifts_at(line.first()), shifts_at(line.last()));
        let mut pairs: Vec<(f64, f64)> =
            of_first.iter().flat_map(|&a| of_last.iter().map(move |&b| (a, b))).skip(1).collect();
        pairs.sort_by(|a, b| (a.0.abs() + a.1.abs()).total_cmp(&(b.0.abs() + b.1.abs())));
        let both = |line: &Vec<DVec3>, (first, last): (f64, f64)| {
            let mut line = line.clone();
            move_first(&mut line, first * edge);
            line.reverse();
            move_first(&mut line, last * edge);
            line.reverse();
            line
        };
        let moved = |pair: (f64, f64)| lines.iter().map(|line| both(line, pair)).collect();
        pairs.into_iter().map(|pair| (moved(pair), edge * pair.0.abs().max(pair.1.abs()))).collect()
    }

    /// Variants of the lines with their ends inside the body at vertices nearby, and the larger distance to those \[mm\]; the smallest one first. Many
    /// cuts leave ends so close to lips that no vertex finds room between.
    pub(super) fn at_vertices(&self, lines: &[Vec<DVec3>], edge: f64) -> Vec<Variant> {
        let Some(line) = lines.first() else { return Vec::new() };
        let [of_first, of_last] = from_both_ends(line).map(|line| self.places_near(&line, edge));
        let mut pairs: Vec<[(f64, Option<DVec3>); 2]> =
            of_first.iter().flat_map(|&a| of_last.iter().map(move |&b| [a, b])).skip(1).collect();
        pairs.sort_by(|[a, b], [c, d]| (a.0 + b.0).total_cmp(&(c.0 + d.0)));
        let both = |line: &Vec<DVec3>, [(_, first), (_, last)]: [(f64, Option<DVec3>); 2]| {
            let mut line = line.clone();
            line.first_mut().into_iter().for_each(|end| *end = first.unwrap_or(*end));
            line.last_mut().into_iter().for_each(|end| *end = last.unwrap_or(*end));
            line
        };
        let moved = |pair: [(f64, Option<DVec3>); 2]| lines.iter().map(|line| both(line, pair)).collect();
        pairs.into_iter().map(|pair| (moved(pair), pair[0].0.max(pair[1].0))).collect()
    }

    /// Whether the tissue at both ends of a line is free, or outside the body.
    pub(super) fn has_free_ends(&self, line: &[DVec3], edge: f64) -> bool {
        let is_outside = |line: &[DVec3]| line.first().is_some_and(|&end| !self.is_tissue(end));
        from_both_ends(line).iter().all(|line| is_outside(line) || self.places_near(line, edge).len() > 1)
    }

    /// The first point of a line as it is, then inside the body the nearest free vertices within an edge, with their distances \[mm\].
    fn places_near(&self, line: &[DVec3], edge: f64) -> SmallVec<[(f64, Option<DVec3>); 4]> {
        let mut places: Vec<(f64, DVec3)> = match line.first() {
            Some(&end) if self.is_tissue(end) && !comes_back(line, edge) => {
                // Where holds keep the tissue, no place beside them is better.
                let of = |(row, x): (u32, &DVec3)| (self.is_movable)(row).then_some((x.distance(end), *x));
                let rest = &self.mesh.vertices.rest_position;
                (0..).zip(rest.iter()).filter_map(of).filter(|(way, _)| *way <= edge).collect()
            }
            _ => Vec::new(),
        };
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Two lips have vertices at one place.
        places.dedup_by(|a, b| a.1 == b.1);
        let near = places.into_iter().take(PLACES).map(|(way, place)| (way, Some(place)));
        std::iter::once((0.0, None)).chain(near).collect()
    }
}

/// A line from its first point on, and from its last.
fn from_both_ends(line: &[DVec3]) -> [Vec<DVec3>; 2] {
    [line.to_vec(), line.iter().rev().copied().collect()]
}

/// Whether a line comes back to within an edge of its first point: elsewhere that would end another cut.
fn comes_back(line: &[DVec3], edge: f64) -> bool {
    let Some(&end) = line.first() else { return false };
    let mut gone = 0.0;
    line.windows(2).any(|part| {
        let is_beyond = gone > 2.0 * edge;
        gone += part[0].distance(part[1]);
        is_beyond && distance_to_segment(end, part[0], part[1]) < edge
    })
}

/// Moves the first point of a line by a length \[mm\] along its first segment: away from the second one, or, below zero, towards it.
fn move_first(line: &mut [DVec3], by: f64) {
    if let [first, second, ..] = line {
        let along = *first - *second;
        *first += along.normalize_or_zero() * by.max(-FARTHEST_BACK * along.length());
    }
}
