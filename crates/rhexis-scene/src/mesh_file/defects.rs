//! What makes a surface no surface: all of it is counted, and mended where the scene asks for that.

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;

use super::draft::{Draft, Origin};
use super::hanging::{self, Hanging};
use rhexis::internal::{THINNEST, by_corners, slenderness};

/// The most places of each kind that a message names.
const NAMED: usize = 4;

/// Triangles and vertices that cannot be used.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Defects {
    /// Polygons that cross themselves, are folded or overlap: filled by the triangles of the least area, a quad by its better diagonal.
    pub folded: usize,
    /// Triangles without area: dropped.
    pub empty: usize,
    /// Triangles whose corners another one has: dropped.
    pub double: usize,
    /// Edges with more than two triangles.
    pub crowded_edges: usize,
    /// Triangles beyond the second at such an edge: dropped.
    pub third: usize,
    /// Vertices that join triangles without a common edge there: each fan gets its own.
    pub bowties: usize,
    /// Vertices on the edge of a triangle that does not have them: split in. Without `repair` they are told and left.
    pub hanging: usize,
    /// Where: a few of each.
    named: Vec<(&'static str, Vec<String>)>,
}

impl Defects {
    /// Whether there are none.
    pub fn is_none(&self) -> bool {
        let Self { folded, empty, double, crowded_edges, bowties, hanging, .. } = self;
        [folded, empty, double, crowded_edges, bowties, hanging].iter().all(|count| **count == 0)
    }

    fn note(&mut self, kind: &'static str, place: impl FnOnce() -> String) {
        let at = self.named.iter().position(|(known, _)| *known == kind).unwrap_or(self.named.len());
        if at == self.named.len() {
            self.named.push((kind, Vec::new()));
        }
        if self.named[at].1.len() < NAMED {
            self.named[at].1.push(place());
        }
    }

    /// All of them in words, each kind with its first places.
    pub fn text(&self) -> String {
        let kinds = [
            (self.folded, FOLDED, "polygon(s) that cross themselves, are folded or overlap"),
            (self.hanging, HANGING, "vertices on the edge of a triangle that does not have them"),
            (self.empty, EMPTY, "triangle(s) without area"),
            (self.double, DOUBLE, "double triangle(s)"),
            (self.crowded_edges, CROWDED, "edge(s) of more than two triangles"),
            (self.bowties, BOWTIE, "bowtie(s): vertices that join triangles without a common edge"),
        ];
        let told = kinds.iter().filter(|(count, ..)| *count > 0).map(|(count, kind, words)| {
            let places = self.named.iter().find(|(known, _)| known == kind).map_or(&[][..], |(_, places)| places);
            let more =
                if *count > places.len() { format!(" and {} more", count - places.len()) } else { String::new() };
            format!("{count} {words} ({}{more})", places.join(", "))
        });
        told.collect::<Vec<_>>().join(", ")
    }
}

const FOLDED: &str = "folded";
const HANGING: &str = "hanging";
const EMPTY: &str = "empty";
const DOUBLE: &str = "double";
const CROWDED: &str = "crowded";
const BOWTIE: &str = "bowtie";

/// The words for a triangle of the file.
fn place(draft: &Draft, triangle: usize) -> String {
    match draft.origin {
        Origin::Line => format!("line {}", draft.places[triangle]),
        Origin::Number(word) => format!("{word} {}", draft.places[triangle]),
        Origin::Triangle => format!("triangle {triangle}"),
    }
}

fn at(position: DVec3) -> String {
    let DVec3 { x, y, z } = position;
    format!("at ({x:.6}, {y:.6}, {z:.6})")
}

/// Drops and splits what cannot be used and counts it. `sources` are the rows of the vertices in the file, for those that are copied.
/// Vertices that hang on an edge, or lie within `weld` of it, are split in by `repair`; else they are counted beside other defects.
pub(super) fn mend(draft: &mut Draft, sources: &mut Vec<u32>, repair: bool, weld: f64) -> Defects {
    let mut defects = Defects::default();
    for &triangle in &draft.folded {
        defects.folded += 1;
        defects.note(FOLDED, || place(draft, triangle as usize));
    }
    drop_empty(draft, &mut defects);
    drop_double(draft, &mut defects);
    let found = match repair {
        true => hanging::split(draft, sources, weld),
        false => hanging::hanging(&draft.positions, &draft.triangles, weld),
    };
    let mut hanging = Defects::default();
    note_hanging(draft, &found, &mut hanging);
    if repair && !found.is_empty() {
        drop_empty(draft, &mut defects);
        drop_double(draft, &mut defects);
    }
    drop_third(draft, &mut defects);
    split_bowties(draft, sources, &mut defects);
    if repair || !defects.is_none() {
        defects.hanging = hanging.hanging;
        defects.named.append(&mut hanging.named);
    }
    defects
}

fn note_hanging(draft: &Draft, places: &[Hanging], defects: &mut Defects) {
    let mut vertices: Vec<u32> = places.iter().map(|place| place.vertex).collect();
    vertices.sort_unstable();
    vertices.dedup();
    defects.hanging = vertices.len();
    for hanging in places {
        defects.note(HANGING, || {
            format!("{} {}", at(draft.positions[hanging.vertex as usize]), place(draft, hanging.triangle))
        });
    }
}

fn keep(draft: &mut Draft, is_kept: &[bool]) {
    if is_kept.iter().all(|kept| *kept) {
        return;
    }
    fn retain<T: Copy>(list: &mut Vec<T>, is_kept: &[bool]) {
        let mut kept = is_kept.iter();
        list.retain(|_| kept.next().is_some_and(|kept| *kept));
    }
    retain(&mut draft.triangles, is_kept);
    retain(&mut draft.cells, is_kept);
    retain(&mut draft.places, is_kept);
    retain(&mut draft.rows, is_kept);
    retain(&mut draft.textured, is_kept);
}

fn drop_empty(draft: &mut Draft, defects: &mut Defects) {
    let mut is_kept = vec![true; draft.triangles.len()];
    for (triangle, &corners) in draft.triangles.iter().enumerate() {
        let [a, b, c] = corners;
        let points = corners.map(|corner| draft.positions[corner as usize]);
        let is_whole = a != b && b != c && c != a && slenderness(points) >= THINNEST;
        if !is_whole {
            is_kept[triangle] = false;
            defects.empty += 1;
            defects.note(EMPTY, || place(draft, triangle));
        }
    }
    keep(draft, &is_kept);
}

fn drop_double(draft: &mut Draft, defects: &mut Defects) {
    let mut is_kept = vec![true; draft.triangles.len()];
    for group in by_corners(&draft.triangles).chunk_by(|a, b| a.0 == b.0) {
        for &(_, triangle) in &group[1..] {
            is_kept[triangle] = false;
            defects.double += 1;
            defects.note(DOUBLE, || format!("{} as {}", place(draft, triangle), place(draft, group[0].1)));
        }
    }
    keep(draft, &is_kept);
}

fn drop_third(draft: &mut Draft, defects: &mut Defects) {
    let mut halves: Vec<([u32; 2], usize)> = Vec::with_capacity(3 * draft.triangles.len());
    for (triangle, &[a, b, c]) in draft.triangles.iter().enumerate() {
        halves.extend([[a, b], [b, c], [c, a]].map(|[from, to]| ([from.min(to), from.max(to)], triangle)));
    }
    halves.sort_unstable();
    // Triangles so far at each edge that has too many.
    let mut crowded: HashMap<[u32; 2], u32> = HashMap::new();
    for group in halves.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() > 2) {
        crowded.insert(group[0].0, 0);
        defects.crowded_edges += 1;
        defects.note(CROWDED, || {
            let few: Vec<String> = group.iter().take(3).map(|half| place(draft, half.1)).collect();
            let more = if group.len() > 3 { format!(" and {} more", group.len() - 3) } else { String::new() };
            format!("{}{more}", few.join(", "))
        });
    }
    if crowded.is_empty() {
        return;
    }
    let mut is_kept = vec![true; draft.triangles.len()];
    for (triangle, &[a, b, c]) in draft.triangles.iter().enumerate() {
        let edges = [[a, b], [b, c], [c, a]].map(|[from, to]| [from.min(to), from.max(to)]);
        if edges.iter().any(|edge| crowded.get(edge).is_some_and(|count| *count >= 2)) {
            is_kept[triangle] = false;
            defects.third += 1;
            continue;
        }
        for edge in edges {
            if let Some(count) = crowded.get_mut(&edge) {
                *count += 1;
            }
        }
    }
    keep(draft, &is_kept);
}

fn split_bowties(draft: &mut Draft, sources: &mut Vec<u32>, defects: &mut Defects) {
    let mut sets: Vec<usize> = (0..3 * draft.triangles.len()).collect();
    let mut halves: Vec<([u32; 2], usize)> = Vec::with_capacity(sets.len());
    for (triangle, &[a, b, c]) in draft.triangles.iter().enumerate() {
        halves.extend([[a, b], [b, c], [c, a]].map(|[from, to]| ([from.min(to), from.max(to)], triangle)));
    }
    halves.sort_unstable();
    for pair in halves.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() == 2) {
        for vertex in pair[0].0 {
            let corner = |triangle: usize| {
                let place = draft.triangles[triangle].iter().position(|&corner| corner == vertex);
                3 * triangle + place.unwrap_or(0)
            };
            let [a, b] = [corner(pair[0].1), corner(pair[1].1)].map(|corner| root(&mut sets, corner));
            sets[a.max(b)] = a.min(b);
        }
    }
    // The vertex of each fan: the first keeps the vertex, the others get copies.
    let mut fan_vertex: HashMap<usize, u32> = HashMap::new();
    let mut fans: Vec<u32> = vec![0; draft.positions.len()];
    let mut triangles_at: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for corner in 0..sets.len() {
        let fan = root(&mut sets, corner);
        let vertex = draft.triangles[corner / 3][corner % 3];
        if fan == corner {
            let count = &mut fans[vertex as usize];
            *count += 1;
            if *count > 1 {
                let copy = draft.positions.len() as u32;
                draft.positions.push(draft.positions[vertex as usize]);
                sources.push(sources[vertex as usize]);
                fan_vertex.insert(fan, copy);
                let seen = triangles_at.entry(vertex).or_default();
                if seen.len() < NAMED {
                    seen.push(corner / 3);
                }
            }
        }
    }
    for (&vertex, seen) in &triangles_at {
        defects.bowties += 1;
        let position = draft.positions[vertex as usize];
        defects.note(BOWTIE, || format!("{} {}", at(position), place(draft, seen[0])));
    }
    if fan_vertex.is_empty() {
        return;
    }
    for corner in 0..sets.len() {
        if let Some(&copy) = fan_vertex.get(&root(&mut sets, corner)) {
            draft.triangles[corner / 3][corner % 3] = copy;
        }
    }
}

/// The smallest member of the set `at` belongs to, shortening the way for the next caller.
fn root(sets: &mut [usize], mut at: usize) -> usize {
    while sets[at] != at {
        sets[at] = sets[sets[at]];
        at = sets[at];
    }
    at
}
