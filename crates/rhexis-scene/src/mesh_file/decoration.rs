//! Texture coordinates, normals and colours that a file gives its vertices.
//!
//! A vertex of the engine has one of each: of texture coordinates and colours that a file gives it the first stands, and normals are
//! averaged. Vertices with several texture coordinates are a seam: corners of triangles keep theirs. Channels that some vertices lack are left out.

use super::draft::Draft;
use glam::{DVec2, DVec3};
use rhexis::components::{Attributes, Channel};
use rhexis::storage::TriangleMesh;
use std::collections::BTreeSet;

/// The channels, in the order of [`Decoration::values`] and of the attributes made of them.
const CHANNELS: [Channel; 3] = [Channel::TextureCoordinates, Channel::Normal, Channel::Colour];

/// The place of texture coordinates among the channels.
const TEXTURE: usize = 0;

/// Distance of texture coordinates, as a part of that along an edge, within which a vertex split in has those of the edge.
const SAME: f64 = 1e-3;

/// What a file gives its vertices beside their positions.
#[derive(Debug, Default)]
pub(super) struct Decoration {
    /// Numbers by vertex and channel; NaN for none.
    values: [Vec<f64>; 3],
    /// Vertices with more than one texture coordinate.
    seams: BTreeSet<u32>,
    /// Vertices of the file: rows from here on are of none.
    pub vertices: usize,
}

impl Decoration {
    /// Numbers of a channel for a vertex; those that are not finite are passed over. Whether it has no other texture coordinate.
    pub(super) fn give(&mut self, channel: Channel, row: u32, numbers: &[f64]) -> bool {
        let (width, place) = (channel.width(), CHANNELS.iter().position(|kind| *kind == channel).unwrap_or(0));
        if numbers.len() != width || numbers.iter().any(|number| !number.is_finite()) {
            return true;
        }
        let (values, start) = (&mut self.values[place], row as usize * width);
        if values.len() < start + width {
            values.resize(start + width, f64::NAN);
        }
        let own = &mut values[start..start + width];
        match channel {
            _ if own[0].is_nan() => own.copy_from_slice(numbers),
            Channel::Normal => own.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += number),
            Channel::TextureCoordinates if *own != *numbers => {
                self.seams.insert(row);
                return false;
            }
            _ => {}
        }
        true
    }

    /// The row of the texture coordinate at a place between two rows: `own` where it has that, or nothing is known; else a new one.
    pub(super) fn between(&mut self, [from, to]: [u32; 2], along: f64, own: u32) -> u32 {
        let at = |row| self.of(TEXTURE, row).map(DVec2::from_slice);
        let (Some(from), Some(to)) = (at(from), at(to)) else { return own };
        let between = from.lerp(to, along);
        if at(own).is_none_or(|own| own.distance(between) <= SAME * from.distance(to)) {
            return own;
        }
        self.add(between.to_array())
    }

    /// A new row with this texture coordinate, of no vertex.
    pub(super) fn add(&mut self, uv: [f64; 2]) -> u32 {
        let row = (self.values[TEXTURE].len() / 2).max(self.vertices) as u32;
        self.give(Channel::TextureCoordinates, row, &uv);
        row
    }

    fn of(&self, place: usize, row: u32) -> Option<&[f64]> {
        let width = CHANNELS[place].width();
        self.values[place].get(row as usize * width..(row as usize + 1) * width).filter(|own| !own[0].is_nan())
    }
}

/// What a surface has of it.
#[derive(Debug, Default)]
pub(super) struct Decorated {
    /// For every vertex.
    pub attributes: Option<Attributes>,
    /// Vertices with more than one texture coordinate in the file.
    pub seams: usize,
    /// The texture coordinates of the corners of triangles, where there is a seam.
    pub textured: Option<Vec<[[f64; 2]; 3]>>,
    /// Channels that only some of the vertices have, in words.
    pub left_out: Vec<String>,
}

/// The attributes of a surface whose vertices come from the rows `sources` of the draft; joined rows give theirs to the first.
pub(super) fn decorate(draft: &mut Draft, sources: &[u32], mesh: &TriangleMesh) -> Decorated {
    let mut all = std::mem::take(&mut draft.decoration);
    for &(from, to) in draft.joined.iter().filter(|(from, to)| from != to) {
        for (place, channel) in CHANNELS.into_iter().enumerate() {
            if let Some(own) = all.of(place, from).map(<[f64]>::to_vec) {
                all.give(channel, to, &own);
            }
        }
    }
    let mut decorated = Decorated::default();
    let (mut attributes, mut places) = (Attributes::default(), Vec::new());
    for (place, channel) in CHANNELS.into_iter().enumerate() {
        if sources.iter().all(|&row| all.of(place, row).is_some()) {
            attributes.channels.push((channel, attributes.stride));
            attributes.stride += channel.width();
            places.push(place);
        } else if !all.values[place].is_empty() {
            decorated.left_out.push(format!("{} (not at every vertex)", channel.name()));
        }
    }
    if places.is_empty() {
        return decorated;
    }
    let geometric = normals(mesh);
    for (&row, out) in sources.iter().zip(geometric) {
        for &place in &places {
            let own = all.of(place, row).unwrap_or_default();
            if CHANNELS[place] == Channel::Normal {
                // To the side that the triangles have been turned to.
                let normal = DVec3::from_slice(own).normalize_or(out);
                attributes.values.extend(if normal.dot(out) < 0.0 { -normal } else { normal }.to_array());
            } else {
                attributes.values.extend_from_slice(own);
            }
        }
    }
    let kept: BTreeSet<u32> = sources.iter().copied().collect();
    decorated.seams = all.seams.intersection(&kept).count();
    if decorated.seams > 0 && places.contains(&TEXTURE) {
        let uv = |row: u32| all.of(TEXTURE, row).and_then(|own| own.try_into().ok());
        let corner = |vertex: u32, row: u32| uv(row).or_else(|| uv(sources[vertex as usize])).unwrap_or_default();
        let corners = mesh.triangles.iter().zip(&draft.textured);
        let of_corners = corners.map(|(corners, rows)| [0, 1, 2].map(|i| corner(corners[i], rows[i])));
        decorated.textured = Some(of_corners.collect());
    }
    decorated.attributes = Some(attributes);
    decorated
}

/// Unit normals of a surface by vertex, weighted by area.
fn normals(mesh: &TriangleMesh) -> Vec<DVec3> {
    let mut list = Vec::new();
    rhexis::simulation::normals(&mesh.positions, &mesh.triangles, &mut list);
    list
}
