//! The operator as a sparse matrix over the free axes: prescribed axes drop out, the others are numbered in an order of
//! elimination that keeps a factor sparse.
//!
//! Layout: the upper triangle by columns. A vertex has one column per free axis; the rows of each are the free axes of its
//! neighbours that come earlier in the order, then its own down to the diagonal. The order is found on the graph of vertices,
//! not of axes: the same quality from a graph of a quarter to a ninth of the size.

use super::Operator;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef, linalg::amd};
use glam::DVec3;

/// The diagonal is raised by this fraction of its vertex' trace, so that what nothing holds (a piece torn free, a slack flap
/// out of its plane) has a factor. Conjugate gradients take the error out again: softer than this over its stiffest direction
/// no usable body is.
const SHIFT: f64 = 1e-10;

/// Where the entries of the matrix stand, for one set of triangles and free axes.
#[derive(Debug)]
pub struct Pattern {
    corners: Vec<[u32; 3]>,
    free: Vec<DVec3>,
    /// Vertices that have a free axis, in the order of elimination.
    order: Vec<u32>,
    /// First column of each vertex.
    first: Vec<u32>,
    /// Per vertex in order, where its list in `earlier` begins; one more entry at the end.
    earlier_start: Vec<u32>,
    /// Neighbours that come earlier, in order, as vertices.
    earlier: Vec<u32>,
    column_start: Vec<u32>,
    row: Vec<u32>,
}

/// The free axes of a vertex.
fn axes(free: DVec3) -> impl Iterator<Item = usize> + Clone {
    (0..3).filter(move |&axis| free[axis] != 0.0)
}

impl Pattern {
    /// The pattern of an operator; `None` where there is no free axis, or no memory.
    pub fn new(operator: &Operator, free: &[DVec3]) -> Option<Self> {
        let order = elimination_order(operator, free)?;
        let mut place = vec![u32::MAX; free.len()];
        let mut first = vec![0; free.len()];
        let mut column_count = 0;
        for (p, &v) in order.iter().enumerate() {
            place[v as usize] = p as u32;
            first[v as usize] = column_count;
            column_count += axes(free[v as usize]).count() as u32;
        }
        let (mut earlier_start, mut earlier) = (vec![0], Vec::new());
        let (mut column_start, mut row) = (vec![0], Vec::new());
        for &v in &order {
            let begin = earlier.len();
            let has_come = |w: &u32| place[*w as usize] < place[v as usize];
            neighbours(operator, v as usize, has_come, &mut earlier);
            earlier[begin..].sort_unstable_by_key(|&w| place[w as usize]);
            earlier_start.push(earlier.len() as u32);
            for own in 0..axes(free[v as usize]).count() as u32 {
                for &w in &earlier[begin..] {
                    row.extend((first[w as usize]..).take(axes(free[w as usize]).count()));
                }
                row.extend((first[v as usize]..).take(own as usize + 1));
                column_start.push(u32::try_from(row.len()).ok()?);
            }
        }
        let corners = operator.triangles.corners.clone();
        Some(Self { corners, free: free.to_vec(), order, first, earlier_start, earlier, column_start, row })
    }

    /// Whether this is the pattern for these triangles and free axes.
    pub fn fits(&self, corners: &[[u32; 3]], free: &[DVec3]) -> bool {
        self.corners == corners && self.free == free
    }

    /// Number of free axes.
    pub fn column_count(&self) -> usize {
        self.column_start.len() - 1
    }

    /// The pattern for the solver.
    pub fn symbolic(&self) -> SymbolicSparseColMatRef<'_, u32> {
        let n = self.column_count();
        SymbolicSparseColMatRef::new_checked(n, n, &self.column_start, None, &self.row)
    }

    /// The matrix with the entries that [`assemble`](Self::assemble) has written.
    pub fn matrix<'a>(&'a self, value: &'a [f64]) -> SparseColMatRef<'a, u32, f64> {
        SparseColMatRef::new(self.symbolic(), value)
    }

    /// Writes the entries \[N/mm\] at the operator's state.
    pub fn assemble(&self, operator: &Operator, value: &mut Vec<f64>) {
        value.clear();
        value.resize(self.row.len(), 0.0);
        // Offset of a neighbour's rows in the columns of the vertex at hand; what is not among its earlier ones is stale.
        let mut offset = vec![u32::MAX; self.free.len()];
        for (p, &v) in self.order.iter().enumerate() {
            let v = v as usize;
            let earlier = &self.earlier[self.earlier_start[p] as usize..self.earlier_start[p + 1] as usize];
            let mut height = 0;
            for &w in earlier {
                offset[w as usize] = height;
                height += axes(self.free[w as usize]).count() as u32;
            }
            offset[v] = height;
            let own = operator.own_block(v);
            let mut trace = 0.0;
            for (k, axis) in axes(self.free[v]).enumerate() {
                let column = self.first[v] as usize + k;
                let start = self.column_start[column] as usize;
                let column = &mut value[start..self.column_start[column + 1] as usize];
                for (entry, b) in column[height as usize..].iter_mut().zip(axes(self.free[v])) {
                    *entry = own.col(axis)[b];
                }
                for &incident in &operator.topology.incident[v] {
                    let (t, corner) = (incident as usize / 3, incident as usize % 3);
                    let forces = operator.element_column(t, corner, axis);
                    for (&w, force) in operator.triangles.corners[t].iter().zip(forces) {
                        if w as usize == v || earlier.contains(&w) {
                            let rows = column[offset[w as usize] as usize..].iter_mut();
                            rows.zip(axes(self.free[w as usize])).for_each(|(entry, b)| *entry += force[b]);
                        }
                    }
                }
                trace += column[height as usize + k].abs();
            }
            for k in 0..axes(self.free[v]).count() {
                let end = self.column_start[self.first[v] as usize + k + 1] as usize;
                value[end - 1] += trace * SHIFT;
            }
        }
    }

    /// Takes the free axes of a field, times `scale`, into one number per column.
    pub fn gather(&self, field: &[DVec3], scale: f64, columns: &mut [f32]) {
        let values = self.order.iter().flat_map(|&v| axes(self.free[v as usize]).map(move |axis| (v, axis)));
        for (column, (v, axis)) in columns.iter_mut().zip(values) {
            *column = (field[v as usize][axis] * scale) as f32;
        }
    }

    /// The inverse of [`gather`](Self::gather) for one vertex; zero along prescribed axes.
    pub fn at(&self, columns: &[f32], v: usize) -> DVec3 {
        let mut value = DVec3::ZERO;
        for (k, axis) in axes(self.free[v]).enumerate() {
            value[axis] = f64::from(columns[self.first[v] as usize + k]);
        }
        value
    }
}

/// Appends the neighbours of a vertex that pass, each once, ascending.
fn neighbours(operator: &Operator, v: usize, passes: impl Fn(&u32) -> bool, list: &mut Vec<u32>) {
    let begin = list.len();
    for &incident in &operator.topology.incident[v] {
        let corners = operator.triangles.corners[incident as usize / 3];
        list.extend(corners.into_iter().filter(|w| *w as usize != v && passes(w)));
    }
    list[begin..].sort_unstable();
    let mut kept = begin;
    for i in begin..list.len() {
        if i == begin || list[i] != list[kept - 1] {
            list[kept] = list[i];
            kept += 1;
        }
    }
    list.truncate(kept);
}

/// The vertices with a free axis by approximate minimum degree (Amestoy, Davis, Duff 1996).
fn elimination_order(operator: &Operator, free: &[DVec3]) -> Option<Vec<u32>> {
    let active: Vec<u32> = (0..free.len() as u32).filter(|&v| free[v as usize] != DVec3::ZERO).collect();
    if active.is_empty() {
        return None;
    }
    let mut number = vec![u32::MAX; free.len()];
    for (i, &v) in active.iter().enumerate() {
        number[v as usize] = i as u32;
    }
    let (mut start, mut row) = (vec![0_u32], Vec::new());
    for &v in &active {
        neighbours(operator, v as usize, |w| number[*w as usize] < number[v as usize], &mut row);
        start.push(row.len() as u32);
    }
    row.iter_mut().for_each(|w| *w = number[*w as usize]);
    let n = active.len();
    let (mut order, mut inverse) = (vec![0; n], vec![0; n]);
    let mut memory = MemBuffer::try_new(amd::order_scratch::<u32>(n, row.len())).ok()?;
    let graph = SymbolicSparseColMatRef::new_checked(n, n, &start, None, &row);
    amd::order(&mut order, &mut inverse, graph, amd::Control::default(), MemStack::new(&mut memory)).ok()?;
    Some(order.into_iter().map(|i| active[i as usize]).collect())
}
