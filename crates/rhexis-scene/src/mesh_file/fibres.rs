//! Fibre directions as text, one line per triangle.

use glam::DVec3;

use super::encoding;
use super::fault::Fault;

/// Directions in the order of the lines that hold any.
pub(super) fn parse(bytes: Vec<u8>) -> Result<Vec<DVec3>, Fault> {
    let text = encoding::text(bytes);
    let mut fibres = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let mut words = line.split([' ', '\t', '\r', ',', ';']).filter(|word| !word.is_empty()).peekable();
        if words.peek().is_none() {
            continue;
        }
        let fault = |what: String| Fault::at(number + 1, format!("{what}; give three finite numbers, not all zero"));
        let values = words
            .map(|word| word.parse().map_err(|_| fault(format!("{word:?} is not a number"))))
            .collect::<Result<Vec<f64>, _>>()?;
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
