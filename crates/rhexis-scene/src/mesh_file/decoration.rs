//! Texture coordinates, normals and colours that a file gives its vertices.
//!
//! A vertex of the engine has one of each, and more where a file gives several: of texture coordinates and colours the first stands, and
//! vertices with others are counted as seams; normals are averaged. What not every vertex has is left out.

use super::draft::Draft;
use glam::DVec3;
use rhexis::components::{Attributes, Channel};
use rhexis::storage::TriangleMesh;
use std::collections::BTreeSet;

/// The channels, in the order of [`Decoration::values`] and of the attributes made of them.
const CHANNELS: [Channel; 3] = [Channel::TextureCoordinates, Channel::Normal, Channel::Colour];

/// What a file gives its vertices beside their positions.
#[derive(Debug, Default)]
pub(super) struct Decoration {
    /// Numbers by vertex and channel; NaN for none.
    values: [Vec<f64>; 3],
    /// Vertices with more than one texture coordinate.
    seams: BTreeSet<u32>,
}

impl Decoration {
    /// Gives a vertex the numbers of a channel; what is not finite is none.
    pub(super) fn give(&mut self, channel: Channel, row: u32, numbers: &[f64]) {
        let (width, place) = (channel.width(), CHANNELS.iter().position(|kind| *kind == channel).unwrap_or(0));
        if numbers.len() != width || numbers.iter().any(|number| !number.is_finite()) {
            return;
        }
        let (values, start) = (&mut self.values[place], row as usize * width);
        if values.len() < start + width {
            values.resize(start + width, f64::NAN);
        }
        let own = &mut values[start..start + width];
        match channel {
            _ if own[0].is_nan() => own.copy_from_slice(numbers),
            Channel::Normal => own.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += number),
            Channel::TextureCoordinates if *own != *numbers => _ = self.seams.insert(row),
            _ => {}
        }
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
    decorated.attributes = Some(attributes);
    decorated
}

/// Unit normals of a surface by vertex, weighted by area.
fn normals(mesh: &TriangleMesh) -> Vec<DVec3> {
    let mut list = Vec::new();
    rhexis::simulation::normals(&mesh.positions, &mesh.triangles, &mut list);
    list
}
