//! STL, text and binary, by `stl_io`. A triangle soup: vertices with exactly the same coordinates become one.

use std::collections::HashMap;
use std::io::Cursor;

use glam::DVec3;

use super::fault::Fault;
use crate::storage::TriangleMesh;

/// Header and count of a binary file, and one of its triangles \[bytes\].
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// Reads one solid. Coordinates have the 7 digits the format holds.
pub fn parse(mut bytes: Vec<u8>) -> Result<TriangleMesh, Fault> {
    let claimed = bytes.get(80..HEADER).and_then(|count| <[u8; 4]>::try_from(count).ok()).map(u32::from_le_bytes);
    let binary_length = claimed.map(|count| HEADER + TRIANGLE * count as usize);
    // Binary headers may start with "solid" too; only the length tells for sure.
    if binary_length == Some(bytes.len()) {
        bytes[..80].fill(0);
    } else if bytes.starts_with(b"solid") {
        one_named_solid(&mut bytes)?;
    } else {
        return Err(Fault::new(match claimed {
            Some(count) => format!(
                "neither STL text (\"solid …\") nor binary STL: {count} triangles would take {} bytes, the file has {}; \
                 export it again",
                HEADER + TRIANGLE * count as usize,
                bytes.len()
            ),
            None => "too short for an STL file; export it again".into(),
        }));
    }
    let mut reader = Cursor::new(bytes);
    let refused = |error| Fault::new(format!("{error}; export the STL file again"));
    let mut mesh = TriangleMesh::default();
    let mut rows: HashMap<[u32; 3], u32> = HashMap::new();
    for triangle in stl_io::create_stl_reader(&mut reader).map_err(refused)? {
        let corners = triangle.map_err(refused)?.vertices.map(|vertex| {
            // Adding zero makes −0 and +0 the same bits.
            let position = <[f32; 3]>::from(vertex).map(|x| x + 0.0);
            *rows.entry(position.map(f32::to_bits)).or_insert_with(|| {
                mesh.positions.push(DVec3::from(position.map(f64::from)));
                (mesh.positions.len() - 1) as u32
            })
        });
        mesh.triangles.push(corners);
    }
    Ok(mesh)
}

/// `stl_io` wants a name after "solid" and stops silently after the first solid.
fn one_named_solid(bytes: &mut Vec<u8>) -> Result<(), Fault> {
    if bytes.get(5).is_none_or(|byte| *byte != b' ') {
        bytes.splice(0..5, *b"solid ");
    }
    let ends: Vec<&[u8]> = bytes
        .split(|byte| *byte == b'\n')
        .map(|line| line.trim_ascii())
        .skip_while(|line| !line.starts_with(b"endsolid"))
        .collect();
    if ends.iter().skip(1).any(|line| !line.is_empty()) {
        return Err(Fault::new("there is more after the first solid; export the surface as a single solid"));
    }
    Ok(())
}
