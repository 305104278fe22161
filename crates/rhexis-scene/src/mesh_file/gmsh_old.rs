//! Gmsh MSH 1 and 2, text and binary.

use super::draft::{Draft, Origin, Shape, Wanted};
use super::fault::{Fault, line_of};
use super::gmsh_scan::{Groups, NumberFormat, Scanner, Tags, arrays, named};
use glam::DVec3;

/// Reads the triangles and quads; points and curves are ignored.
pub(super) fn parse(
    bytes: &[u8],
    is_first_version: bool,
    format: NumberFormat,
    wanted: &Wanted,
) -> Result<Draft, Fault> {
    let mut scanner = Scanner { bytes, at: 0, format };
    let [nodes, elements]: [&[u8]; 2] = if is_first_version { [b"$NOD", b"$ELM"] } else { [b"$Nodes", b"$Elements"] };
    let is_text = format == NumberFormat::Text;
    let mut draft =
        Draft { origin: if is_text { Origin::Line } else { Origin::Number("element") }, ..Draft::default() };
    let missing = |what: &str| Fault::new(format!("the file has no {what}; save the mesh with all its elements"));
    if !scanner.section(nodes) {
        return Err(missing("nodes"));
    }
    let mut tags = Vec::new();
    for row in 0..scanner.count(if is_text { 8 } else { 28 })? {
        let tag = scanner.integer()?;
        draft.positions.push(DVec3::new(scanner.real()?, scanner.real()?, scanner.real()?));
        tags.push((tag, row as u32));
    }
    let tags = Tags::new(tags);
    if tags.has_twice() {
        return Err(Fault::new("two nodes have the same tag; renumber the mesh in Gmsh (Mesh.Renumber)"));
    }
    scanner.at = 0;
    if !scanner.section(elements) {
        return Err(missing("elements"));
    }
    let mut cells = Cells { draft, tags, groups: Groups::new(), elements: Vec::new(), line: 0 };
    let count = scanner.count(if is_text { 6 } else { 4 })?;
    match (is_text, is_first_version) {
        (true, _) => {
            cells.line = line_of(bytes, scanner.at);
            for _ in 0..count {
                let line = scanner.line()?;
                let words = line.split_whitespace().map(str::parse).collect::<Result<Vec<u64>, _>>();
                let words = words.map_err(|_| scanner.fault(format!("{line:?} is not an element")))?;
                let parts = match (is_first_version, words.as_slice()) {
                    (true, [tag, kind, physical, _, count, nodes @ ..]) if nodes.len() as u64 == *count => {
                        Some((*tag, *kind, Some(*physical), nodes))
                    }
                    (false, [tag, kind, count, rest @ ..]) => {
                        let split = usize::try_from(*count).ok().and_then(|count| rest.split_at_checked(count));
                        split.map(|(marks, nodes)| (*tag, *kind, marks.first().copied(), nodes))
                    }
                    _ => None,
                };
                let (tag, kind, physical, nodes) =
                    parts.ok_or_else(|| scanner.fault(format!("{line:?} is not an element")))?;
                cells.element(tag, kind, physical, nodes)?;
                cells.line += 1;
            }
        }
        (false, _) => {
            let mut read = 0;
            while read < count {
                let (kind, block, marks) = (scanner.integer()?, scanner.integer()?, scanner.integer()?);
                let size = node_count(kind)?;
                if block == 0 || marks > 100 {
                    return Err(scanner.fault("a block of elements has none, or too many marks"));
                }
                for _ in 0..block {
                    let tag = scanner.integer()?;
                    let marks = (0..marks).map(|_| scanner.integer()).collect::<Result<Vec<_>, _>>()?;
                    let nodes = (0..size).map(|_| scanner.integer()).collect::<Result<Vec<_>, _>>()?;
                    cells.element(tag, kind, marks.first().copied(), &nodes)?;
                    read += 1;
                }
            }
        }
    }
    let Cells { mut draft, tags, groups, elements, .. } = cells;
    draft.groups = named(groups, &mut scanner)?;
    arrays(&mut scanner, (&tags, &Tags::new(elements)), wanted, &mut draft)?;
    Ok(draft)
}

/// Nodes of an element that is a point, a line, a triangle or a quad.
fn node_count(kind: u64) -> Result<usize, Fault> {
    match kind {
        15 => Ok(1),
        1 => Ok(2),
        2 | 8 => Ok(3),
        3 | 26 => Ok(4),
        27 => Ok(5),
        28 => Ok(6),
        other => {
            let what =
                format!("elements of type {other} are curved or solid; mesh the surface only (gmsh -2 -order 1)");
            Err(Fault::new(what))
        }
    }
}

struct Cells {
    draft: Draft,
    tags: Tags,
    groups: Groups,
    elements: Vec<(u64, u32)>,
    /// Of the element, in text.
    line: usize,
}

impl Cells {
    fn element(&mut self, tag: u64, kind: u64, physical: Option<u64>, nodes: &[u64]) -> Result<(), Fault> {
        let line = (self.line > 0).then_some(self.line);
        let fault = |what: String| Fault { line, what: format!("element {tag}: {what}") };
        let count = node_count(kind).map_err(|fault| Fault { line, ..fault })?;
        if nodes.len() != count {
            return Err(fault(format!("type {kind} has {count} nodes, the element {}; export it again", nodes.len())));
        }
        let row = |node: &u64| {
            let missing = || Fault {
                line,
                what: format!("element {tag} names node {node}, which does not exist; save all nodes"),
            };
            self.tags.row(*node).ok_or_else(missing)
        };
        let corners = nodes.iter().map(row).collect::<Result<Vec<u32>, Fault>>()?;
        let dimension = match kind {
            15 => 0,
            2 | 3 => 2,
            _ => 1,
        };
        if let Some(physical) = physical.filter(|physical| *physical > 0) {
            self.groups.entry((dimension, physical)).or_default().extend(&corners);
        }
        if dimension == 2 {
            let cell = self.elements.len();
            self.elements.push((tag, cell as u32));
            self.draft.push_cell(Shape::Polygon, &corners, cell, line.unwrap_or(tag as usize)).map_err(fault)?;
        }
        Ok(())
    }
}
