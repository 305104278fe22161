//! Gmsh MSH 4.1, text and binary, by `mshio`.
//!
//! `mshio` trusts three things that a file can get wrong: the format line, and the counts and tag ranges that head the node and
//! element sections. Other number sizes make it panic, and a zero underflows. Where the range looks dense it forgets the node tags,
//! whatever their order. So all three are settled before it is called. The heads are overwritten with constants that are never used
//! for anything but to make it keep the tags.

use mshio::error::MshParserErrorKind;
use mshio::{ElementType, MshParserError};

use super::draft::{Draft, Origin, Shape, Wanted};
use super::encoding;
use super::fault::{Fault, line_of};
use super::gmsh_old;
use super::gmsh_scan::{Groups, NumberFormat, Scanner, Tags, arrays, named};
use std::collections::BTreeMap;

/// A count all of whose bytes are set, so that no overlap of two heads in a broken file can make it zero.
const COUNT: u64 = 0x0101_0101_0101_0101;

/// Reads the triangles and quads of all surfaces; points and curves are ignored. Versions 1 and 2 are read elsewhere.
pub(super) fn parse(bytes: Vec<u8>, wanted: &Wanted) -> Result<Draft, Fault> {
    let head = encoding::first_lines(&bytes, 2);
    let is_text = !matches!(head.get(1).map(|line| line.split_whitespace().nth(1)), Some(Some("1")));
    let mut bytes = if is_text { encoding::line_feeds(bytes) } else { bytes };
    let blank = bytes.len() - bytes.trim_ascii_start().len();
    bytes.drain(..blank);
    if bytes.starts_with(b"$NOD") {
        return gmsh_old::parse(&bytes, true, NumberFormat::Text, wanted);
    }
    let (version, number_format) = check_format(&bytes)?;
    if version == Version::Two {
        return gmsh_old::parse(&bytes, false, number_format, wanted);
    }
    let bytes = neutral_head(bytes, b"$Nodes", [COUNT, 1, u64::MAX], number_format);
    let bytes = neutral_head(bytes, b"$Elements", [COUNT, 1, 1], number_format);
    let file = mshio::parse_msh_bytes(&bytes).map_err(|error| refused(&bytes, error, number_format))?;

    let mut draft = Draft { origin: Origin::Number("element"), ..Draft::default() };
    let mut tags: Vec<(u64, u32)> = Vec::new();
    for block in file.data.nodes.iter().flat_map(|nodes| &nodes.node_blocks) {
        let first = draft.positions.len();
        draft.positions.extend(block.nodes.iter().map(|node| glam::dvec3(node.x, node.y, node.z)));
        tags.extend(block.node_tags.iter().flatten().map(|(&tag, &row)| (tag, (first + row) as u32)));
    }
    // Also makes the order independent of the hash map's.
    let tags = Tags::new(tags);
    // A tag given twice in one block is in its map once.
    if tags.has_twice() || tags.len() != draft.positions.len() {
        return Err(Fault::new("two nodes have the same tag; renumber the mesh in Gmsh (Mesh.Renumber)"));
    }
    let physical = physical_tags(&file);
    let mut groups = Groups::new();
    let mut elements = Vec::new();
    for block in file.data.elements.iter().flat_map(|elements| &elements.element_blocks) {
        let is_thin = block.entity_dim < 2;
        match block.element_type {
            _ if is_thin => {}
            ElementType::Tri3 | ElementType::Qua4 => {}
            other => {
                return Err(Fault::new(format!(
                    "elements of type {other:?} are curved or solid; mesh the surface only (gmsh -2 -order 1)"
                )));
            }
        }
        let entity = (i64::from(block.entity_dim), i64::from(block.entity_tag));
        for element in &block.elements {
            let corner = |tag: &u64| {
                tags.row(*tag).ok_or_else(|| {
                    Fault::new(format!(
                        "element {} names node {tag}, which does not exist; save all nodes",
                        element.element_tag
                    ))
                })
            };
            let corners = element.nodes.iter().map(corner).collect::<Result<Vec<_>, Fault>>();
            // Points and curves may be saved without their nodes.
            let corners = if is_thin { corners.unwrap_or_default() } else { corners? };
            for &group in physical.get(&entity).into_iter().flatten() {
                groups.entry((entity.0.unsigned_abs(), group)).or_default().extend(&corners);
            }
            if is_thin {
                continue;
            }
            let cell = elements.len();
            elements.push((element.element_tag, cell as u32));
            draft
                .push_cell(Shape::Polygon, &corners, cell, element.element_tag as usize)
                .map_err(|what| Fault::new(format!("element {}: {what}", element.element_tag)))?;
        }
    }
    let mut scanner = Scanner { bytes: &bytes, at: 0, format: number_format };
    draft.groups = named(groups, &mut scanner)?;
    arrays(&mut scanner, (&tags, &Tags::new(elements)), wanted, &mut draft)?;
    Ok(draft)
}

/// The most physical groups of an entity that are kept: each of its elements goes into all of them.
const MOST_GROUPS: usize = 8;

/// The physical groups of each entity by its dimension and tag.
fn physical_tags(file: &mshio::MshFile<u64, i32, f64>) -> BTreeMap<(i64, i64), Vec<u64>> {
    let mut of = BTreeMap::new();
    let mut add = |dimension: i64, tag: i32, groups: &[i32]| {
        let groups = groups.iter().take(MOST_GROUPS).map(|group| u64::from(group.unsigned_abs())).collect();
        of.insert((dimension, i64::from(tag)), groups);
    };
    if let Some(entities) = &file.data.entities {
        entities.points.iter().for_each(|point| add(0, point.tag, &point.physical_tags));
        entities.curves.iter().for_each(|curve| add(1, curve.tag, &curve.physical_tags));
        entities.surfaces.iter().for_each(|surface| add(2, surface.tag, &surface.physical_tags));
    }
    of
}

#[derive(Clone, Copy, PartialEq)]
enum Version {
    Two,
    Four,
}

/// The version, and the byte order of a binary file.
fn check_format(bytes: &[u8]) -> Result<(Version, NumberFormat), Fault> {
    let not_gmsh = || Fault::at(1, "not a Gmsh file: it must begin with $MeshFormat");
    let rest = bytes.strip_prefix(b"$MeshFormat").ok_or_else(not_gmsh)?;
    let rest = rest.strip_prefix(b"\n").or_else(|| rest.strip_prefix(b"\r\n")).ok_or_else(not_gmsh)?;
    let end = rest.iter().position(|byte| *byte == b'\n').ok_or_else(not_gmsh)?;
    let line = String::from_utf8_lossy(&rest[..end]);
    let order = || match rest.get(end + 1..end + 5) {
        Some([1, 0, 0, 0]) => Ok(NumberFormat::LittleEndian),
        Some([0, 0, 0, 1]) => Ok(NumberFormat::BigEndian),
        _ => Err(Fault::new("the binary file does not tell its byte order; export it again")),
    };
    let how = "export version 4.1 or 2.2 (gmsh -format msh41, or `Mesh.MshFileVersion = 4.1;`)";
    let number = |version: &str| match version {
        "4.1" => Some(Version::Four),
        "2" | "2.0" | "2.1" | "2.2" => Some(Version::Two),
        _ => None,
    };
    match line.split_ascii_whitespace().collect::<Vec<_>>().as_slice() {
        [version, ..] if number(version).is_none() => {
            Err(Fault::at(2, format!("MSH version {version} is not read; {how}")))
        }
        [version, "0", "8"] => Ok((number(version).unwrap_or(Version::Four), NumberFormat::Text)),
        [version, "1", "8"] => Ok((number(version).unwrap_or(Version::Four), order()?)),
        [_, ..] => Err(Fault::at(2, format!("unknown number format {line:?}; export it again with 8-byte sizes"))),
        [] => Err(Fault::at(2, format!("the format line is empty; {how}"))),
    }
}

/// Overwrites the last three of the four numbers after every `tag` that ends its line. Line breaks stay where they are.
fn neutral_head(bytes: Vec<u8>, tag: &[u8], numbers: [u64; 3], format: NumberFormat) -> Vec<u8> {
    let mut out = Vec::with_capacity(bytes.len());
    let mut rest = bytes.as_slice();
    while let Some(at) = rest.windows(tag.len()).position(|window| window == tag) {
        let (before, after) = rest.split_at(at + tag.len());
        out.extend_from_slice(before);
        rest = after;
        let line_break = if rest.starts_with(b"\n") { 1 } else { 2 * usize::from(rest.starts_with(b"\r\n")) };
        if line_break == 0 {
            continue;
        }
        match format {
            NumberFormat::Text => {
                for place in 0..4 {
                    let (blank, word) = rest.split_at(rest.iter().take_while(|byte| b" \t\r\n".contains(byte)).count());
                    let (number, after) = word.split_at(word.iter().take_while(|byte| byte.is_ascii_digit()).count());
                    if number.is_empty() {
                        break;
                    }
                    out.extend_from_slice(blank);
                    match place {
                        0 => out.extend_from_slice(number),
                        _ => out.extend_from_slice(numbers[place - 1].to_string().as_bytes()),
                    }
                    rest = after;
                }
            }
            NumberFormat::LittleEndian | NumberFormat::BigEndian => {
                let head = line_break + 8;
                if let (Some(kept), Some(after)) = (rest.get(..head), rest.get(head + 24..)) {
                    out.extend_from_slice(kept);
                    for number in numbers {
                        let little = format == NumberFormat::LittleEndian;
                        out.extend(if little { number.to_le_bytes() } else { number.to_be_bytes() });
                    }
                    rest = after;
                }
            }
        }
    }
    out.extend_from_slice(rest);
    out
}

fn refused(bytes: &[u8], error: MshParserError<&[u8]>, format: NumberFormat) -> Fault {
    let (mut faults, mut places): (Vec<String>, Vec<String>) = (Vec::new(), Vec::new());
    for (_, kind) in error.filter_msh_errors() {
        match kind {
            MshParserErrorKind::Context(context) => places.push(format!("in the {context}")),
            kind => faults.push(kind.to_string().trim_end_matches('.').into()),
        }
    }
    faults.extend(places);
    // The innermost slice begins where parsing stopped.
    let at = error.backtrace.first().map(|(slice, _)| (slice.as_ptr() as usize).wrapping_sub(bytes.as_ptr() as usize));
    let line = at.filter(|at| format == NumberFormat::Text && *at <= bytes.len()).map(|at| line_of(bytes, at));
    let what = if faults.is_empty() { "the section is broken".into() } else { faults.join(", ") };
    Fault { line, what: format!("{what}; the file may be cut off: export it again from Gmsh") }
}
