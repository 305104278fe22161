//! Numbers that belong to vertices and that no step reads: texture coordinates, normals, colours, whatever a host has.

use crate::components::BodyError;
use crate::components::check::{Check, Host};
use crate::storage::{EditRecord, Order, Parents};

/// Meaning of consecutive numbers of a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum Channel {
    /// Two texture coordinates (u, v); v points up, as in OBJ.
    TextureCoordinates,
    /// The three parts of a normal of the rest shape.
    Normal,
    /// Red, green, blue and opacity, each from 0 to 1.
    Colour,
}

impl Channel {
    /// Channel name in plural, for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::TextureCoordinates => "texture coordinates",
            Self::Normal => "normals",
            Self::Colour => "colours",
        }
    }

    /// Numbers that it takes.
    pub fn width(self) -> usize {
        match self {
            Self::TextureCoordinates => 2,
            Self::Normal => 3,
            Self::Colour => 4,
        }
    }
}

/// Numbers per vertex that follow every edit: a vertex put on an edge gets the linear interpolation of its ends, one of a parted
/// vertex a copy. *Parameter.* Snapshots keep them, [`Simulation::reorder`](crate::simulation::Simulation::reorder) sorts them, and
/// [`BodyView`](crate::simulation::BodyView) shows them, so that a host's texture coordinates cannot be lost.
///
/// ```
/// use glam::DVec3;
/// use rhexis::components::{Attributes, Material};
/// use rhexis::{membrane::Membrane, settings::Settings, simulation::Simulation, storage::TriangleMesh};
/// let positions = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
/// let uv = positions.iter().flat_map(|p| [p.x, p.y]).collect();
/// let mesh = TriangleMesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], ..TriangleMesh::default() };
/// let mut simulation = Simulation::new(Settings::default())?;
/// let sheet = Membrane::new("sheet", mesh, Material::allard_2009()).with(Attributes::new(2, uv));
/// let body = simulation.spawn(sheet)?;
/// simulation.cut(body, &[DVec3::new(0.5, 0.0, 0.0), DVec3::new(0.5, 0.5, 0.0)])?;
/// let view = simulation.view(body)?;
/// let uv = view.attributes.ok_or("it carries some")?;
/// let last = view.positions.len() - 1;
/// assert!(last > 3 && (uv.of(last as u32)[1] - view.rest_positions[last].y).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Attributes {
    /// Numbers per vertex, at least 1.
    pub stride: usize,
    /// The numbers, `stride` for each vertex by rows, finite.
    pub values: Vec<f64>,
    /// Where numbers with a meaning begin in a vertex' row; none need be named.
    pub channels: Vec<(Channel, usize)>,
}

impl Attributes {
    /// Numbers without a stated meaning, `stride` per vertex.
    pub fn new(stride: usize, values: Vec<f64>) -> Self {
        Self { stride, values, channels: Vec::new() }
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.values.len().checked_div(self.stride).unwrap_or(0)
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The numbers of the vertex in a row; none beyond the last.
    pub fn of(&self, row: u32) -> &[f64] {
        let start = row as usize * self.stride;
        self.values.get(start..start + self.stride).unwrap_or_default()
    }

    /// The numbers of a channel, vertex by vertex; `None` without it.
    pub fn channel(&self, channel: Channel) -> Option<impl Iterator<Item = &[f64]>> {
        let &(_, first) = self.channels.iter().find(|(kind, _)| *kind == channel)?;
        Some(
            self.values
                .chunks_exact(self.stride.max(1))
                .map(move |row| row.get(first..first + channel.width()).unwrap_or_default()),
        )
    }

    /// Follows an edit.
    pub(crate) fn follow(&mut self, record: &EditRecord) {
        let stride = self.stride;
        if self.values.len() != record.first_vertex as usize * stride {
            // Of another mesh: the next judgement says so.
            return;
        }
        for (_, parents) in record.created() {
            (0..stride).for_each(|i| self.values.push(blend(&self.values, stride, parents, i)));
        }
        if let Some((row, parents)) = record.moved() {
            for i in 0..stride {
                self.values[row as usize * stride + i] = blend(&self.values, stride, &parents, i);
            }
        }
        if let Some(removed) = &record.removed {
            let last = self.values.len() - stride;
            self.values.copy_within(last.., removed.vertex as usize * stride);
            self.values.truncate(last);
        }
    }

    /// Brings the rows into another order of the vertices.
    pub(crate) fn sort(&mut self, order: &Order) {
        let mut sorted = Vec::with_capacity(self.values.capacity());
        order.vertices.iter().for_each(|&old| sorted.extend_from_slice(self.of(old)));
        self.values = sorted;
    }
}

fn blend(values: &[f64], stride: usize, parents: &Parents, place: usize) -> f64 {
    parents.blend(|row| values[row as usize * stride + place])
}

impl Check for Attributes {
    fn check(&self, host: &Host<'_>) -> Result<(), BodyError> {
        let component = "Attributes";
        if self.stride == 0 || self.stride.checked_mul(host.count) != Some(self.values.len()) {
            let Self { stride, values, .. } = self;
            return Err(BodyError::AttributeCount { given: values.len(), stride: *stride, vertices: host.count });
        }
        if self.channels.iter().any(|(kind, first)| first.checked_add(kind.width()).is_none_or(|end| end > self.stride))
        {
            let what = "a channel reaches beyond the numbers of a vertex: raise `stride`, or let it begin earlier";
            return Err(BodyError::Contradiction { component, what });
        }
        let Some(place) = self.values.iter().position(|value| !value.is_finite()) else { return Ok(()) };
        let (row, value) = (Some((place / self.stride) as u32), self.values[place]);
        Err(BodyError::OutOfRange { component, what: "a number", row, value, must: "it must be finite" })
    }
}
