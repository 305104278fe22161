//! Columns of PLY elements beside positions and corners: what a scene asks for, and what vertices are given.

use super::draft::{Array, Draft, On, Wanted};
use super::ply::{Element, Number, Property};
use rhexis::components::Channel;

/// Where texture coordinates, normals and colours stand among the properties of vertices, and what colours are divided by.
pub(super) struct Decorated(Vec<(Channel, Vec<usize>, f64)>);

impl Decorated {
    pub(super) fn of(element: &Element) -> Self {
        let place = |name: &&str| {
            let is_it = |property: &Property| property.count.is_none() && property.name.eq_ignore_ascii_case(name);
            element.properties.iter().position(is_it)
        };
        let known: [(Channel, &[&str]); 7] = [
            (Channel::TextureCoordinates, &["u", "v"]),
            (Channel::TextureCoordinates, &["s", "t"]),
            (Channel::TextureCoordinates, &["texture_u", "texture_v"]),
            (Channel::Normal, &["nx", "ny", "nz"]),
            (Channel::Colour, &["red", "green", "blue", "alpha"]),
            (Channel::Colour, &["red", "green", "blue"]),
            (Channel::Colour, &["r", "g", "b"]),
        ];
        let mut found: Vec<(Channel, Vec<usize>, f64)> = Vec::new();
        for (channel, names) in known {
            let places: Option<Vec<usize>> = names.iter().map(place).collect();
            if let Some(places) = places.filter(|_| found.iter().all(|(kind, ..)| *kind != channel)) {
                let full = match element.properties[places[0]].number {
                    _ if channel != Channel::Colour => 1.0,
                    Number::U8 => 255.0,
                    Number::U16 => 65535.0,
                    _ => 1.0,
                };
                found.push((channel, places, full));
            }
        }
        Self(found)
    }

    pub(super) fn give(&self, row: u32, numbers: &[f64], draft: &mut Draft) {
        for (channel, places, full) in &self.0 {
            let mut own: Vec<f64> = places.iter().map(|&place| numbers[place] / full).collect();
            // A colour without an opacity is opaque.
            own.resize(channel.width(), 1.0);
            draft.decoration.give(*channel, row, &own);
        }
    }

    pub(super) fn names<'a>(&'a self, element: &'a Element) -> impl Iterator<Item = &'a str> {
        self.0.iter().flat_map(|(_, places, _)| places).map(|&place| element.properties[place].name.as_str())
    }
}

/// The scalars of an element that a scene asks for: by their own names, or as a vector by the stem of `stem_x`, `stem_y`, `stem_z`.
pub(super) struct Arrays {
    /// For each property: which of `arrays`.
    of: Vec<Option<usize>>,
    arrays: Vec<Array>,
}

impl Arrays {
    pub(super) fn new(element: &Element, on: On, wanted: &Wanted, draft: &mut Draft) -> Self {
        let mut arrays: Vec<Array> = Vec::new();
        let stem =
            |name: &str| name.strip_suffix(['x', 'y', 'z']).map(|stem| stem.trim_end_matches(['_', '.']).to_owned());
        let mut of = Vec::new();
        for property in &element.properties {
            let name = &property.name;
            let by_stem = stem(name).filter(|stem| wanted.has(stem));
            let kept = if wanted.has(name) { Some(name.clone()) } else { by_stem };
            let place = kept.filter(|_| property.count.is_none()).map(|kept| {
                let place = arrays.iter().position(|array| array.name == kept).unwrap_or(arrays.len());
                match arrays.get_mut(place) {
                    Some(array) => array.components += 1,
                    None => arrays.push(Array { name: kept, on, components: 1, values: Vec::new() }),
                }
                place
            });
            if place.is_none() && !["x", "y", "z"].contains(&name.to_lowercase().as_str()) && property.count.is_none() {
                draft.passed_over.insert(name.clone());
            }
            of.push(place);
        }
        Self { of, arrays }
    }

    pub(super) fn keep(&mut self, property: usize, value: f64, is_list: bool) {
        if let (Some(place), false) = (self.of[property], is_list) {
            self.arrays[place].values.push(value);
        }
    }

    pub(super) fn give(self, draft: &mut Draft) {
        self.arrays.into_iter().for_each(|array| draft.arrays.push(array));
    }
}
