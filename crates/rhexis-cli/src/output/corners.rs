//! Rows of vertices for formats that know one texture coordinate a vertex: one that has several at its triangles has a row for each.

use rhexis::components::Channel;
use rhexis::frame::BodyFrame;

/// Texture coordinates of the corners of triangles.
pub(crate) type Textured = [[[f64; 2]; 3]];

/// Distance within which texture coordinates at a vertex are one.
const SAME: f64 = 1e-9;

/// A body's vertices and triangles by rows: those of its own vertices first, as they are.
pub(super) struct Rows {
    /// The vertex of each row.
    pub vertices: Vec<u32>,
    /// Rows of the corners.
    pub triangles: Vec<[u32; 3]>,
    /// The texture coordinates of the rows; none where vertices carry none.
    pub texture: Vec<[f64; 2]>,
}

impl Rows {
    /// The rows of a body; `textured` where its texture has seams.
    pub(super) fn of(body: &BodyFrame, textured: Option<&Textured>) -> Self {
        let rows = body.attributes.as_ref().and_then(|attributes| attributes.channel(Channel::TextureCoordinates));
        let texture = rows.into_iter().flatten().map(|row| [row[0], row[1]]).collect();
        let vertices = (0..body.positions.len() as u32).collect();
        let mut rows = Self { vertices, triangles: body.triangles.clone(), texture };
        let Some(textured) = textured.filter(|list| list.len() == body.triangles.len() && !rows.texture.is_empty())
        else {
            return rows;
        };
        // The rows of each vertex that has texture coordinates of its triangles already.
        let mut rows_of: Vec<Vec<u32>> = vec![Vec::new(); body.positions.len()];
        for (corners, uv) in rows.triangles.iter_mut().zip(textured) {
            for (corner, uv) in corners.iter_mut().zip(uv) {
                let vertex = *corner;
                let own = &mut rows_of[vertex as usize];
                let is_same = |row: &&u32| {
                    let [u, v] = rows.texture[**row as usize];
                    (u - uv[0]).abs() <= SAME && (v - uv[1]).abs() <= SAME
                };
                let found = own.iter().find(is_same).copied();
                *corner = found.unwrap_or_else(|| {
                    let row = if own.is_empty() { vertex } else { rows.vertices.len() as u32 };
                    own.push(row);
                    if row == vertex {
                        rows.texture[row as usize] = *uv;
                    } else {
                        rows.vertices.push(vertex);
                        rows.texture.push(*uv);
                    }
                    row
                });
            }
        }
        rows
    }

    /// The values of the rows, from those of the vertices.
    pub(super) fn spread<T: Copy>(&self, of_vertices: &[T]) -> Vec<T> {
        self.vertices.iter().map(|&vertex| of_vertices[vertex as usize]).collect()
    }
}
