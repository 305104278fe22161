//! Room in the lists that are as long as a table.

/// Makes a list fit for `count` entries, those of a table that has room for `room`. The first time it gets no more than it needs. A
/// list that has to grow since gets an eighth to spare, but no more than its table has. The next edits find it long enough, and it
/// never holds half as much again in vain, as one that doubles does.
pub(crate) fn grow<T>(list: &mut Vec<T>, count: usize, room: usize) {
    if list.capacity() == 0 {
        fit(list, count);
    } else if list.capacity() < count {
        fit(list, (count + count / 8).min(room).max(count));
    }
}

/// Makes a list a copy of another, of entries for the rows of a table that has room for `room`; it grows as [`grow`] says.
pub(crate) fn copy<T: Copy>(list: &mut Vec<T>, values: &[T], room: usize) {
    list.clear();
    grow(list, values.len(), room);
    list.extend_from_slice(values);
}

/// Makes a list fit for `room` entries and no more, where it is not.
pub(crate) fn fit<T>(list: &mut Vec<T>, room: usize) {
    if list.capacity() < room {
        list.reserve_exact(room - list.len());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_grows_by_an_eighth_to_where_its_table_has_room() {
        let mut list = Vec::new();
        grow(&mut list, 100, 150);
        assert_eq!(list.capacity(), 100);
        list.resize(100, 0_u64);
        grow(&mut list, 100, 150);
        assert_eq!(list.capacity(), 100);
        grow(&mut list, 101, 150);
        assert_eq!(list.capacity(), 113);
        grow(&mut list, 140, 150);
        assert_eq!(list.capacity(), 150);
        grow(&mut list, 151, 150);
        assert!(list.capacity() >= 151);
    }
}
