//! Gmsh MSH 4.1, text and binary, by `mshio`.
//!
//! `mshio` trusts three things that a file can get wrong, so they are settled before it is called: the format line (other
//! number sizes make it panic), and the counts and tag ranges that head the node and element sections (a zero underflows, and
//! where the range looks dense it forgets the node tags, whatever their order). The heads are overwritten with constants
//! that are never used for anything but to make it keep the tags.

use mshio::error::MshParserErrorKind;
use mshio::{ElementType, MshParserError};

use super::fault::{Fault, line_of};
use super::surface::{Shape, push_cell};
use crate::storage::TriangleMesh;

/// A count all of whose bytes are set, so that no overlap of two heads in a broken file can make it zero.
const COUNT: u64 = 0x0101_0101_0101_0101;

/// Reads the triangles and quads of all surfaces; points and curves are ignored.
pub fn parse(bytes: Vec<u8>) -> Result<TriangleMesh, Fault> {
    let number_format = check_format(&bytes)?;
    let bytes = neutral_head(bytes, b"$Nodes", [COUNT, 1, u64::MAX], number_format);
    let bytes = neutral_head(bytes, b"$Elements", [COUNT, 1, 1], number_format);
    let file = mshio::parse_msh_bytes(&bytes).map_err(|error| refused(&bytes, error, number_format))?;

    let mut mesh = TriangleMesh::default();
    let mut tags: Vec<(u64, u32)> = Vec::new();
    for block in file.data.nodes.iter().flat_map(|nodes| &nodes.node_blocks) {
        let first = mesh.positions.len();
        mesh.positions.extend(block.nodes.iter().map(|node| glam::dvec3(node.x, node.y, node.z)));
        tags.extend(block.node_tags.iter().flatten().map(|(&tag, &row)| (tag, (first + row) as u32)));
    }
    // Also makes the order independent of the hash map's.
    tags.sort_unstable();
    // A tag given twice in one block is in its map once.
    let twice = tags.windows(2).any(|pair| pair[0].0 == pair[1].0) || tags.len() != mesh.positions.len();
    if twice {
        return Err(Fault::new("two nodes have the same tag; renumber the mesh in Gmsh (Mesh.Renumber)"));
    }
    for block in file.data.elements.iter().flat_map(|elements| &elements.element_blocks) {
        match block.element_type {
            _ if block.entity_dim < 2 => continue,
            ElementType::Tri3 | ElementType::Qua4 => {}
            other => {
                return Err(Fault::new(format!(
                    "elements of type {other:?} are curved or solid; mesh the surface only (gmsh -2 -order 1)"
                )));
            }
        }
        for element in &block.elements {
            let corner = |tag: &u64| {
                let place = tags.binary_search_by_key(tag, |(tag, _)| *tag).map_err(|_| {
                    Fault::new(format!(
                        "element {} names node {tag}, which does not exist; save all nodes",
                        element.element_tag
                    ))
                })?;
                Ok(tags[place].1)
            };
            let corners = element.nodes.iter().map(corner).collect::<Result<Vec<_>, Fault>>()?;
            push_cell(&mut mesh, Shape::Polygon, &corners, None)
                .map_err(|what| Fault::new(format!("element {}: {what}", element.element_tag)))?;
        }
    }
    Ok(mesh)
}

#[derive(Clone, Copy, PartialEq)]
enum NumberFormat {
    Text,
    LittleEndian,
    BigEndian,
}

/// The three words of the format line, and the byte order of a binary file.
fn check_format(bytes: &[u8]) -> Result<NumberFormat, Fault> {
    let not_gmsh = || Fault::at(1, "not a Gmsh file: it must begin with $MeshFormat");
    let rest = bytes.strip_prefix(b"$MeshFormat").ok_or_else(not_gmsh)?;
    let rest = rest.strip_prefix(b"\n").or_else(|| rest.strip_prefix(b"\r\n")).ok_or_else(not_gmsh)?;
    let end = rest.iter().position(|byte| *byte == b'\n').ok_or_else(not_gmsh)?;
    let line = String::from_utf8_lossy(&rest[..end]);
    let how = "export version 4.1 (gmsh -format msh41, or `Mesh.MshFileVersion = 4.1;`)";
    match line.split_ascii_whitespace().collect::<Vec<_>>().as_slice() {
        ["4.1", "0", "8"] => Ok(NumberFormat::Text),
        ["4.1", "1", "8"] => match rest.get(end + 1..end + 5) {
            Some([1, 0, 0, 0]) => Ok(NumberFormat::LittleEndian),
            Some([0, 0, 0, 1]) => Ok(NumberFormat::BigEndian),
            _ => Err(Fault::new("the binary file does not tell its byte order; export it again")),
        },
        ["4.1", ..] => Err(Fault::at(2, format!("unknown number format {line:?}; export it again with 8-byte sizes"))),
        [version, ..] => Err(Fault::at(2, format!("MSH version {version} is not read; {how}"))),
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
