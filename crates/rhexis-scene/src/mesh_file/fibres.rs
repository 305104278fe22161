//! Numbers as text, one line per triangle: fibre directions, thicknesses, strengths.

use glam::DVec3;

use super::encoding;
use super::fault::Fault;

/// Directions in the order of the lines that hold any.
pub(super) fn parse(bytes: Vec<u8>) -> Result<Vec<DVec3>, Fault> {
    let must = "give three finite numbers, not all zero";
    let mut fibres = Vec::new();
    for (line, values) in rows(bytes, must)? {
        let fault = |what: String| Fault::at(line, format!("{what}; {must}"));
        let &[x, y, z] = values.as_slice() else {
            return Err(fault(format!("{} numbers on the line", values.len())));
        };
        let fibre = DVec3::new(x, y, z);
        if !fibre.is_finite() || fibre == DVec3::ZERO {
            return Err(fault(format!("the fibre {fibre} has no direction")));
        }
        fibres.push(fibre);
    }
    Ok(fibres)
}

/// The numbers of every line that holds any, with the line's own; `must` says what there has to be.
pub(super) fn rows(bytes: Vec<u8>, must: &str) -> Result<Vec<(usize, Vec<f64>)>, Fault> {
    let text = encoding::text(bytes);
    let mut rows = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let words = line.split([' ', '\t', '\r', ',', ';']).filter(|word| !word.is_empty());
        let value =
            |word: &str| word.parse().map_err(|_| Fault::at(number + 1, format!("{word:?} is not a number; {must}")));
        let values = words.map(value).collect::<Result<Vec<f64>, _>>()?;
        if !values.is_empty() {
            rows.push((number + 1, values));
        }
    }
    Ok(rows)
}
