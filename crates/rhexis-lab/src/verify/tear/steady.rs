//! What is read off tears that go on evenly.

/// The middle one of some values; no number where there are none.
pub(super) fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Without the first fifth, in which a sheet is drawn taut, and the last, which the rim is near.
pub(super) fn steady<T>(all: &[T]) -> &[T] {
    let part = all.len() / 5;
    &all[part..all.len() - part]
}
