//! The operator as a sparse matrix over the free axes: prescribed axes drop out, the others are numbered in an order of
//! elimination that keeps a factor sparse.
//!
//! Layout: the upper triangle by columns. A vertex has one column per free axis; the rows of each are the free axes of its
//! neighbours that come earlier in the order, then its own down to the diagonal. The order is found on the graph of vertices,
//! not of axes: the same quality from a graph of a quarter to a ninth of the size.

use super::dissect;
use super::operator_copy::OperatorCopy;
use crate::components::FreeAxes;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef, linalg::amd};
use glam::{DMat3, DVec3};

/// The diagonal is raised by this fraction of its vertex' trace, so that a part that nothing holds (a fragment torn free, a slack flap
/// out of its plane) has a factor. Conjugate gradients take the error out again: softer than this over its stiffest direction
/// no usable body is.
const FACTOR_SHIFT: f64 = 1e-10;

/// Where the entries of the matrix stand, for one set of triangles and free axes.
#[derive(Debug)]
pub(super) struct AxisPattern {
    corners: Vec<[u32; 3]>,
    folded: Vec<[u32; 4]>,
    free: FreeAxes,
    incident: Incident,
    hinges: Hinges,
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
    /// Where in [`order`](Self::order) the second of two independent subdomains begins, and the separator that needs both.
    subdomains: Option<[usize; 2]>,
}

/// The free axes of a vertex.
fn axes(free: DVec3) -> impl Iterator<Item = usize> + Clone {
    (0..3).filter(move |&axis| free[axis] != 0.0)
}

impl AxisPattern {
    /// The pattern of an operator on these triangles, with bending about the edges of these dihedrals; `None` where there is no
    /// free axis, or no memory.
    pub(super) fn new(corners: &[[u32; 3]], folded: &[[u32; 4]], free: &FreeAxes) -> Option<Self> {
        let incident = Incident::new(corners, free.len());
        let hinges = Hinges::new(folded, free.len());
        let mut order = elimination_order(corners, folded, (&incident, &hinges), free)?;
        let mut place = vec![u32::MAX; free.len()];
        let subdomains = {
            let before = order.clone();
            before.iter().enumerate().for_each(|(p, &v)| place[v as usize] = p as u32);
            dissect::dissect(&mut order, |p, list| {
                let v = before[p] as usize;
                let has_come = |w: &u32| place[*w as usize] < p as u32;
                neighbours(corners, incident.of(v), hinges.far(v), has_come, list);
                list.iter_mut().for_each(|w| *w = place[*w as usize]);
            })
        };
        let mut first = vec![0; free.len()];
        let mut column_count = 0;
        for (p, &v) in order.iter().enumerate() {
            place[v as usize] = p as u32;
            first[v as usize] = column_count;
            column_count += axes(free[v as usize]).count() as u32;
        }
        let (links, width) =
            (most_links(corners, folded, free.len()), column_count.div_ceil(order.len() as u32) as usize);
        let (mut earlier_start, mut earlier) = (Vec::with_capacity(order.len() + 1), Vec::with_capacity(links));
        let mut column_start = Vec::with_capacity(column_count as usize + 1);
        let mut row = Vec::with_capacity(width * width * links + width * (width + 1) / 2 * order.len());
        earlier_start.push(0);
        column_start.push(0);
        for &v in &order {
            let begin = earlier.len();
            // Those that have no place have no free axis.
            let has_come = |w: &u32| place[*w as usize] < place[v as usize];
            neighbours(corners, incident.of(v as usize), hinges.far(v as usize), has_come, &mut earlier);
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
        let (corners, folded, free) = (corners.to_vec(), folded.to_vec(), free.clone());
        Some(Self {
            corners,
            folded,
            free,
            incident,
            hinges,
            order,
            first,
            earlier_start,
            earlier,
            column_start,
            row,
            subdomains,
        })
    }

    /// Whether this is the pattern for these triangles and free axes.
    pub(super) fn fits(&self, corners: &[[u32; 3]], free: &FreeAxes) -> bool {
        self.corners == corners && self.free == *free
    }

    /// The columns at which the second of two independent subdomains begins, and the separator that needs both.
    pub(super) fn subdomains(&self) -> Option<[u32; 2]> {
        let column = |p: usize| self.order.get(p).map_or(self.column_count() as u32, |&v| self.first[v as usize]);
        self.subdomains.map(|starts| starts.map(column))
    }

    /// The vertices of the dihedrals.
    pub(super) fn folded(&self) -> &[[u32; 4]] {
        &self.folded
    }

    /// The free axes, 1 or 0.
    pub(super) fn free(&self) -> &FreeAxes {
        &self.free
    }

    /// The triangles.
    pub(super) fn corners(&self) -> &[[u32; 3]] {
        &self.corners
    }

    /// Number of entries of the matrix.
    pub(super) fn entry_count(&self) -> usize {
        self.row.len()
    }

    /// Number of free axes.
    pub(super) fn column_count(&self) -> usize {
        self.column_start.len() - 1
    }

    /// The pattern for the solver.
    pub(super) fn symbolic(&self) -> SymbolicSparseColMatRef<'_, u32> {
        let n = self.column_count();
        SymbolicSparseColMatRef::new_checked(n, n, &self.column_start, None, &self.row)
    }

    /// The matrix with the entries that [`assemble`](Self::assemble) has written.
    pub(super) fn matrix<'a>(&'a self, value: &'a [f64]) -> SparseColMatRef<'a, u32, f64> {
        SparseColMatRef::new(self.symbolic(), value)
    }

    /// Writes the entries \[N/mm\].
    pub(super) fn assemble(&self, operator_copy: &OperatorCopy, value: &mut Vec<f64>) {
        value.clear();
        value.resize(self.row.len(), 0.0);
        // Offset of a neighbour's rows in the columns of the vertex at hand, for its earlier neighbours and itself.
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
            let columns = self.first[v] as usize;
            let mut add = |w: usize, block: DMat3| {
                for (k, axis) in axes(self.free[v]).enumerate() {
                    let column = &mut value[self.column_start[columns + k] as usize..][offset[w] as usize..];
                    // Of its own rows a column holds those down to the diagonal.
                    let rows = axes(self.free[w]).take(if w == v { k + 1 } else { 3 });
                    column.iter_mut().zip(rows).for_each(|(entry, b)| *entry += block.col(axis)[b]);
                }
            };
            let mut own = operator_copy.own[v];
            for &entry in self.incident.of(v) {
                let (t, corner) = (entry as usize / 3, entry as usize % 3);
                for (i, &w) in self.corners[t].iter().enumerate() {
                    if w as usize == v {
                        own += operator_copy.block(t, i, corner);
                    } else if offset[w as usize] != u32::MAX {
                        add(w as usize, operator_copy.block(t, i, corner));
                    }
                }
            }
            for &(hinge, place) in self.hinges.of(v) {
                // A dihedral of another kind of bending than the pattern's has no place for all of it.
                let Some(hinge) = operator_copy.hinges.get(hinge as usize) else { continue };
                let g = hinge.gradient[place as usize] * hinge.stiffness;
                for (&w, other) in hinge.vertices.iter().zip(hinge.gradient) {
                    // Row w, column v.
                    let block = DMat3::from_cols(other * g.x, other * g.y, other * g.z);
                    if w as usize == v {
                        own += block;
                    } else if offset[w as usize] != u32::MAX {
                        add(w as usize, block);
                    }
                }
            }
            let shift = FACTOR_SHIFT * axes(self.free[v]).map(|axis| own.col(axis)[axis].abs()).sum::<f64>();
            add(v, own + DMat3::from_diagonal(DVec3::splat(shift)));
            earlier.iter().for_each(|&w| offset[w as usize] = u32::MAX);
            offset[v] = u32::MAX;
        }
    }

    /// Calls `f` with the columns of a vertex' free axes, each with its axis: one call for each, so that an axis is no index that is
    /// looked up.
    #[inline(always)]
    pub(super) fn for_columns(&self, v: usize, mut f: impl FnMut(usize, usize)) {
        let (mut column, free) = (self.first[v] as usize, self.free[v]);
        if free.x != 0.0 {
            f(column, 0);
            column += 1;
        }
        if free.y != 0.0 {
            f(column, 1);
            column += 1;
        }
        if free.z != 0.0 {
            f(column, 2);
        }
    }
}

/// The triangles around every vertex, in ascending order: three times the triangle plus the corner.
#[derive(Debug)]
struct Incident {
    start: Vec<u32>,
    entry: Vec<u32>,
}

impl Incident {
    fn new(corners: &[[u32; 3]], vertex_count: usize) -> Self {
        let mut start = vec![0; vertex_count + 1];
        corners.iter().flatten().for_each(|&v| start[v as usize + 1] += 1);
        (0..vertex_count).for_each(|v| start[v + 1] += start[v]);
        let mut next = start.clone();
        let mut entry = vec![0; 3 * corners.len()];
        for (place, &v) in corners.as_flattened().iter().enumerate() {
            entry[next[v as usize] as usize] = place as u32;
            next[v as usize] += 1;
        }
        Self { start, entry }
    }

    fn of(&self, v: usize) -> &[u32] {
        &self.entry[self.start[v] as usize..self.start[v + 1] as usize]
    }
}

/// The dihedrals at every vertex, each with the vertex' place in it.
#[derive(Debug, Default)]
struct Hinges {
    start: Vec<u32>,
    entry: Vec<(u32, u8)>,
    /// The vertices across, in the order of `entry`; the vertex itself where it is on the dihedral's edge.
    far: Vec<u32>,
}

impl Hinges {
    fn new(hinges: &[[u32; 4]], vertex_count: usize) -> Self {
        if hinges.is_empty() {
            return Self::default();
        }
        let mut start = vec![0; vertex_count + 1];
        hinges.iter().flatten().for_each(|&v| start[v as usize + 1] += 1);
        (0..vertex_count).for_each(|v| start[v + 1] += start[v]);
        let mut next = start.clone();
        let mut entry = vec![(0, 0); 4 * hinges.len()];
        let mut far = vec![0; 4 * hinges.len()];
        for (i, hinge) in hinges.iter().enumerate() {
            for (place, &v) in hinge.iter().enumerate() {
                let at = next[v as usize] as usize;
                entry[at] = (i as u32, place as u8);
                far[at] = hinge[[0, 1, 3, 2][place]];
                next[v as usize] += 1;
            }
        }
        Self { start, entry, far }
    }

    fn range(&self, v: usize) -> std::ops::Range<usize> {
        if self.start.is_empty() { 0..0 } else { self.start[v] as usize..self.start[v + 1] as usize }
    }

    fn of(&self, v: usize) -> &[(u32, u8)] {
        &self.entry[self.range(v)]
    }

    fn far(&self, v: usize) -> &[u32] {
        &self.far[self.range(v)]
    }
}

/// Pairs of vertices that hang together through an edge or a dihedral. There are at most so many on a surface without handles
/// (Euler), and some to spare for the list of one vertex before each stands in it once.
fn most_links(corners: &[[u32; 3]], folded: &[[u32; 4]], vertex_count: usize) -> usize {
    corners.len() + vertex_count + folded.len() + 64
}

/// Appends the neighbours that pass, each once, ascending, of the vertex with these entries of [`Incident`] and of
/// [`Hinges`].
fn neighbours(corners: &[[u32; 3]], incident: &[u32], far: &[u32], passes: impl Fn(&u32) -> bool, list: &mut Vec<u32>) {
    let begin = list.len();
    for &entry in incident {
        let (t, corner) = (entry as usize / 3, entry as usize % 3);
        let others = [corners[t][(corner + 1) % 3], corners[t][(corner + 2) % 3]];
        list.extend(others.into_iter().filter(&passes));
    }
    list.extend(far.iter().copied().filter(&passes));
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
fn elimination_order(
    corners: &[[u32; 3]],
    folded: &[[u32; 4]],
    (incident, hinges): (&Incident, &Hinges),
    free: &FreeAxes,
) -> Option<Vec<u32>> {
    let mut active: Vec<u32> = Vec::with_capacity(free.len());
    active.extend((0..free.len() as u32).filter(|&v| free[v as usize] != DVec3::ZERO));
    if active.is_empty() {
        return None;
    }
    let mut number = vec![u32::MAX; free.len()];
    for (i, &v) in active.iter().enumerate() {
        number[v as usize] = i as u32;
    }
    let mut start: Vec<u32> = Vec::with_capacity(active.len() + 1);
    let mut row = Vec::with_capacity(most_links(corners, folded, free.len()));
    start.push(0);
    for &v in &active {
        let far = hinges.far(v as usize);
        neighbours(corners, incident.of(v as usize), far, |w| number[*w as usize] < number[v as usize], &mut row);
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
