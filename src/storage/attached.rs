//! Values attached to vertices (springs, prescriptions, sensors) that follow edits.
//!
//! The rule: both copies of a duplicated member carry its value. A vertex put on a *boundary* edge between two members
//! becomes a member with the interpolated value, so that a grip along a rim has no gap. No other new vertex becomes one:
//! an edge inside the surface between two members says nothing about the points between, unless the members
//! [fill an area](Attached::fill_in). A member that is moved keeps its value; one that is collapsed is gone with its value, and
//! the vertex it went into stays as it was.
//!
//! Values are therefore per vertex (a position, a curve) or per unit of tributary mass or area (a stiffness density), never
//! totals: a total would double where a vertex is duplicated.

use super::order::sort;
use super::{EditRecord, Follow, Tables, VertexKey};

/// A value that can be attached to vertices.
pub trait Attachment: Copy {
    /// The value `weight` of the way from `a` to `b`.
    fn between(a: Self, b: Self, weight: f64) -> Self;
}

impl Attachment for () {
    fn between((): Self, (): Self, _: f64) -> Self {}
}

impl Attachment for f64 {
    fn between(a: Self, b: Self, weight: f64) -> Self {
        a * (1.0 - weight) + b * weight
    }
}

impl Attachment for glam::DVec3 {
    fn between(a: Self, b: Self, weight: f64) -> Self {
        a * (1.0 - weight) + b * weight
    }
}

/// A set of vertices with a value each. Rows ascend.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize))]
pub struct Attached<T> {
    rows: Vec<u32>,
    values: Vec<T>,
    /// Members that were collapsed, the last one last: kept for the undo.
    buried: Vec<(VertexKey, T)>,
}

impl<T: Attachment> Attached<T> {
    /// The set with these members; of several entries for one row the last holds.
    pub fn new(members: impl IntoIterator<Item = (u32, T)>) -> Self {
        let mut members: Vec<(u32, T)> = members.into_iter().collect();
        members.sort_by_key(|&(row, _)| row);
        let mut set = Self { rows: Vec::new(), values: Vec::new(), buried: Vec::new() };
        set.replace(members);
        set
    }

    /// Replaces the members in the allocated room, for few members or ascending rows.
    pub fn replace(&mut self, members: impl IntoIterator<Item = (u32, T)>) {
        self.clear();
        self.buried.clear();
        for (row, value) in members {
            match self.rows.binary_search(&row) {
                Ok(place) => self.values[place] = value,
                Err(place) => {
                    self.rows.insert(place, row);
                    self.values.insert(place, value);
                }
            }
        }
    }

    /// Rows of the members, ascending.
    pub fn rows(&self) -> &[u32] {
        &self.rows
    }

    /// Values of the members, in the order of [`rows`](Self::rows).
    pub fn values(&self) -> &[T] {
        &self.values
    }

    /// The members with their values, to be rewritten.
    ///
    /// # Examples
    /// ```
    /// use rhexis::prelude::*;
    ///
    /// let mut weights = Attached::new([(3, 1.0), (5, 2.0)]);
    /// weights.entries_mut().filter(|(row, _)| *row == 5).for_each(|(_, weight)| *weight = 0.0);
    /// assert_eq!(weights.values(), [1.0, 0.0]);
    /// ```
    pub fn entries_mut(&mut self) -> impl Iterator<Item = (u32, &mut T)> {
        self.rows.iter().copied().zip(&mut self.values)
    }

    /// The value at a vertex, if it is a member.
    pub fn value(&self, row: u32) -> Option<T> {
        self.rows.binary_search(&row).ok().map(|place| self.values[place])
    }

    /// Makes room for `additional` members.
    pub fn reserve(&mut self, additional: usize) {
        self.rows.reserve(additional);
        self.values.reserve(additional);
    }

    /// After [`apply`](Follow::apply), for values that fill areas (prescriptions, foundations, pinches): a vertex put into a
    /// triangle with members at all corners, or on its edge, becomes a member with the interpolated value.
    pub(crate) fn fill_in(&mut self, record: &EditRecord) {
        for (row, parents) in record.created().filter(|_| !record.has_split_boundary()) {
            let is_member = |corner: u32| self.value(corner).is_some();
            let mut triangles = record.changed_triangles.iter();
            let value = match (parents.rows(), parents.weights()) {
                (&[from, to], &[_, weight]) if triangles.any(|t| t.before.corners.into_iter().all(is_member)) => {
                    self.value(from).zip(self.value(to)).map(|(a, b)| T::between(a, b, weight))
                }
                (&[a, b, c], &[u, v, w]) => self.value(a).zip(self.value(b)).zip(self.value(c)).map(|((a, b), c)| {
                    // Along the edge first, then from there to the third corner.
                    T::between(T::between(a, b, v / (u + v)), c, w)
                }),
                _ => None,
            };
            if let Some(value) = value {
                self.insert(row, value);
            }
        }
    }

    /// Gives the members the rows that they have after a new order; returns the old place of every new one.
    pub fn renumber(&mut self, row: impl Fn(u32) -> u32) -> Vec<u32> {
        self.rows.iter_mut().for_each(|member| *member = row(*member));
        let mut places: Vec<u32> = (0..self.rows.len() as u32).collect();
        places.sort_unstable_by_key(|&place| self.rows[place as usize]);
        sort(&places, &mut self.rows);
        sort(&places, &mut self.values);
        places
    }

    /// Lets every member go.
    pub fn clear(&mut self) {
        self.rows.clear();
        self.values.clear();
    }

    /// Rewrites every value, given its row.
    pub fn update(&mut self, value: impl Fn(u32, T) -> T) {
        self.rows.iter().zip(&mut self.values).for_each(|(&row, old)| *old = value(row, *old));
    }

    /// Makes a vertex a member; one that is keeps its value.
    pub fn insert(&mut self, row: u32, value: T) {
        if let Err(place) = self.rows.binary_search(&row) {
            self.rows.insert(place, row);
            self.values.insert(place, value);
        }
    }

    /// Lets a member go and gives its value.
    pub fn remove(&mut self, row: u32) -> Option<T> {
        let place = self.rows.binary_search(&row).ok()?;
        self.rows.remove(place);
        Some(self.values.remove(place))
    }
}

impl<T: Attachment> Follow for Attached<T> {
    fn apply(&mut self, record: &EditRecord, _: Tables<'_>) {
        for (row, parents) in record.created() {
            let value = match *parents.rows() {
                [one] => self.value(one),
                [from, to] if record.has_split_boundary() => {
                    self.value(from).zip(self.value(to)).map(|(a, b)| T::between(a, b, parents.weights()[1]))
                }
                _ => None,
            };
            if let Some(value) = value {
                self.rows.push(row);
                self.values.push(value);
            }
        }
        if let Some(removed) = &record.removed {
            let gone = self.remove(removed.vertex);
            self.buried.extend(gone.map(|value| (removed.vertex_key, value)));
            if let Some(value) = self.remove(record.first_vertex - 1) {
                self.insert(removed.vertex, value);
            }
        }
    }

    fn undo(&mut self, record: &EditRecord, _: Tables<'_>) {
        let kept = self.rows.partition_point(|&row| row < record.first_vertex);
        self.rows.truncate(kept);
        self.values.truncate(kept);
        if let Some(removed) = &record.removed {
            if let Some(value) = self.remove(removed.vertex) {
                self.insert(record.first_vertex - 1, value);
            }
            if let Some((_, value)) = self.buried.pop_if(|(key, _)| *key == removed.vertex_key) {
                self.insert(removed.vertex, value);
            }
        }
    }

    fn release(&mut self) {
        self.buried.clear();
    }
}

#[cfg(feature = "snapshot")]
mod serial {
    //! Bytes form a set only if it has a value for every row, and the rows ascend.

    use super::{Attached, VertexKey};
    use serde::{Deserialize, Deserializer, de::Error};

    #[derive(Deserialize)]
    struct Parts<T> {
        rows: Vec<u32>,
        values: Vec<T>,
        buried: Vec<(VertexKey, T)>,
    }

    impl<'de, T: Deserialize<'de>> Deserialize<'de> for Attached<T> {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            let Parts { rows, values, buried } = Parts::deserialize(deserializer)?;
            if rows.len() != values.len() || rows.windows(2).any(|pair| pair[0] >= pair[1]) {
                return Err(D::Error::custom("attached values out of step with their rows"));
            }
            Ok(Self { rows, values, buried })
        }
    }
}
