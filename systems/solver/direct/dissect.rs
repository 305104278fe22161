//! Nested dissection of an order of elimination into two subdomains and their separator, for two threads to sweep side by side.
//!
//! Eliminating a column changes the columns above it in the elimination tree and no others (Liu 1990, "The role of elimination trees
//! in sparse factorization"). Cut in two where it is cheapest, an order falls into the part before the cut, the part after it
//! that has nothing from before under it, and the separator. Moved to the end, the separator still comes after all that is under it:
//! the factor has as many entries as before.

/// Vertices from which on an order is dissected: those of some 8,000 triangles, under which no second thread is kept awake for
/// loops so short.
const LEAST_DISSECTED: usize = 4096;

/// Two subdomains have to save so much of a sweep's time to be worth while.
const LEAST_SAVED: f64 = 0.2;

/// No place.
const NO_PLACE: u32 = u32::MAX;

/// Sorts an order of elimination into two subdomains and their separator, in each of which it stays as it is. Returns where the
/// second subdomain and the separator begin. `None` where the order is better left in one. `earlier(p, list)` appends the places of
/// the neighbours of the vertex in place `p` that come before it.
pub(super) fn dissect(order: &mut [u32], earlier: impl FnMut(usize, &mut Vec<u32>)) -> Option<[usize; 2]> {
    if order.len() < LEAST_DISSECTED {
        return None;
    }
    let (first_under, entries) = tree(order.len(), earlier);
    let (cut, saved) = cheapest_cut(&first_under, &entries);
    let all: u64 = entries.iter().sum();
    if (saved as f64) < LEAST_SAVED * all as f64 {
        return None;
    }
    let (second, separator): (Vec<usize>, Vec<usize>) =
        (cut..order.len()).partition(|&p| first_under[p] as usize >= cut);
    let sorted: Vec<u32> = second.iter().chain(&separator).map(|&p| order[p]).collect();
    order[cut..].copy_from_slice(&sorted);
    Some([cut, cut + second.len()])
}

/// The first place under every place of the elimination tree, itself counted, and the entries of its column of the factor.
fn tree(count: usize, mut earlier: impl FnMut(usize, &mut Vec<u32>)) -> (Vec<u32>, Vec<u64>) {
    let (mut parent, mut seen_from) = (vec![NO_PLACE; count], vec![NO_PLACE; count]);
    let (mut entries, mut list) = (vec![1; count], Vec::new());
    for p in 0..count {
        list.clear();
        earlier(p, &mut list);
        seen_from[p] = p as u32;
        // A row of the factor has an entry wherever one passes on the way up from the row's neighbours.
        for &neighbour in &list {
            let mut below = neighbour as usize;
            while seen_from[below] != p as u32 {
                seen_from[below] = p as u32;
                entries[below] += 1;
                if parent[below] == NO_PLACE {
                    parent[below] = p as u32;
                }
                below = parent[below] as usize;
            }
        }
    }
    let mut first_under: Vec<u32> = (0..count as u32).collect();
    for p in 0..count {
        if let Some(&above) = first_under.get(parent[p] as usize) {
            first_under[parent[p] as usize] = above.min(first_under[p]);
        }
    }
    (first_under, entries)
}

/// The cut that saves two threads the most, and how many of the entries that saves them to wait for.
fn cheapest_cut(first_under: &[u32], entries: &[u64]) -> (usize, u64) {
    // By how much the entries of the separator change from one cut to the next.
    let (mut begins, mut ends) = (vec![0; entries.len() + 1], vec![0; entries.len() + 1]);
    for (p, (&first, &entries)) in first_under.iter().zip(entries).enumerate() {
        begins[first as usize + 1] += entries;
        ends[p + 1] += entries;
    }
    let all: u64 = entries.iter().sum();
    let (mut best, mut before, mut separator) = ((0, 0), 0, 0);
    for cut in 1..entries.len() {
        before += entries[cut - 1];
        separator = separator + begins[cut] - ends[cut];
        let saved = before.min(all - before - separator);
        if saved > best.1 {
            best = (cut, saved);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Neighbours in a square of `side` by `side`, by vertex.
    fn neighbours(side: usize, v: usize) -> impl Iterator<Item = usize> {
        let (x, y) = ((v % side) as i64, (v / side) as i64);
        let beside = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, 1)].map(|(dx, dy)| (x + dx, y + dy));
        let is_inside = move |c: &i64| (0..side as i64).contains(c);
        beside
            .into_iter()
            .filter(move |(x, y)| is_inside(x) && is_inside(y))
            .map(move |(x, y)| y as usize * side + x as usize)
    }

    /// Entries of the factor in this order, found by elimination; and whether any in the second subdomain is in a row of the first.
    fn eliminate(side: usize, order: &[u32], starts: [usize; 2]) -> (usize, bool) {
        let mut place = vec![0; order.len()];
        order.iter().enumerate().for_each(|(p, &v)| place[v as usize] = p);
        let mut later = vec![std::collections::BTreeSet::new(); order.len()];
        for (p, &v) in order.iter().enumerate() {
            later[p].extend(neighbours(side, v as usize).map(|w| place[w]).filter(|&q| q > p));
        }
        let (mut count, mut is_apart) = (0, true);
        for p in 0..order.len() {
            count += later[p].len();
            is_apart &= p >= starts[0] || later[p].iter().all(|q| !(starts[0]..starts[1]).contains(q));
            let above = std::mem::take(&mut later[p]);
            if let Some(&next) = above.first() {
                later[next].extend(above.into_iter().filter(|&q| q > next));
            }
        }
        (count, is_apart)
    }

    #[test]
    fn two_parts_do_not_need_each_other_and_the_factor_has_as_many_entries() {
        let side = 65;
        // Column by column: as bad an order as there is, but that the middle column comes last.
        let middle = (0..side * side).filter(|v| v % side == side / 2);
        let mut order: Vec<u32> = (0..side * side).filter(|v| v % side < side / 2).map(|v| v as u32).collect();
        order.extend((0..side * side).filter(|v| v % side > side / 2).map(|v| v as u32));
        order.extend(middle.map(|v| v as u32));
        let before = order.clone();
        let mut place = vec![0; order.len()];
        before.iter().enumerate().for_each(|(p, &v)| place[v as usize] = p);
        let earlier = |p: usize, list: &mut Vec<u32>| {
            let of_vertex = neighbours(side, before[p] as usize).map(|w| place[w]).filter(|&q| q < p);
            list.extend(of_vertex.map(|q| q as u32));
        };
        let starts = dissect(&mut order, earlier).unwrap();
        assert_eq!(starts[0], side * (side / 2));
        // The middle column, and next to nothing beside it.
        assert!(order.len() - starts[1] <= 2 * side, "{starts:?}");
        let (count, is_apart) = eliminate(side, &order, starts);
        assert!(is_apart);
        assert_eq!(count, eliminate(side, &before, starts).0);
    }

    #[test]
    fn a_chain_stays_in_one() {
        let mut order: Vec<u32> = (0..5000).collect();
        // Each needs the one before it.
        let earlier = |p: usize, list: &mut Vec<u32>| list.extend(p.checked_sub(1).map(|q| q as u32));
        assert_eq!(dissect(&mut order, earlier), None);
        let mut few = vec![0, 1];
        assert_eq!(dissect(&mut few, |_, _| ()), None);
    }
}
