//! Other units than the engine's own mm, g, ms (hence N, MPa, mJ), as functions that convert into them.
//!
//! # Examples
//! ```
//! use rhexis::units;
//!
//! assert_eq!([units::micrometres(20.0), units::kilopascals(3.0)], [0.02, 0.003]);
//! assert_eq!(units::metres_per_second(2.0), 2.0);
//! let density = units::kilograms_per_cubic_metre(1000.0);
//! let gravity = units::metres_per_second_squared(9.81);
//! let toughness = units::joules_per_square_metre(100.0);
//! let pressure = units::millimetres_of_mercury(15.0);
//! let (grip, traction) = (units::millinewtons(50.0), units::newtons_per_metre(20.0));
//! assert!([density, gravity, toughness, pressure, grip, traction].iter().all(|value| *value > 0.0));
//! ```

/// Metres, as mm.
pub const fn metres(value: f64) -> f64 {
    value * 1e3
}

/// Micrometres, as mm.
pub const fn micrometres(value: f64) -> f64 {
    value * 1e-3
}

/// Seconds, as ms.
pub const fn seconds(value: f64) -> f64 {
    value * 1e3
}

/// Metres per second, as mm/ms: the same number.
pub const fn metres_per_second(value: f64) -> f64 {
    value
}

/// Kilograms per cubic metre, as g/mm³: water has 1000.
pub const fn kilograms_per_cubic_metre(value: f64) -> f64 {
    value * 1e-6
}

/// Pascals, as MPa.
pub const fn pascals(value: f64) -> f64 {
    value * 1e-6
}

/// Kilopascals, as MPa.
pub const fn kilopascals(value: f64) -> f64 {
    value * 1e-3
}

/// Millimetres of mercury, as MPa: 133.322387415 Pa (BIPM, conventional).
pub const fn millimetres_of_mercury(value: f64) -> f64 {
    value * 133.322_387_415e-6
}

/// Millinewtons, as N.
pub const fn millinewtons(value: f64) -> f64 {
    value * 1e-3
}

/// Newtons per metre, as N/mm: a spring's stiffness.
pub const fn newtons_per_metre(value: f64) -> f64 {
    value * 1e-3
}

/// Joules per square metre, as N/mm: a toughness.
pub const fn joules_per_square_metre(value: f64) -> f64 {
    value * 1e-3
}

/// Metres per second squared, as mm/ms²: 9.81 is the pull of the Earth.
pub const fn metres_per_second_squared(value: f64) -> f64 {
    value * 1e-3
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each product of units agrees with the product of its factors; 1e-12 is some roundings.
    #[test]
    fn units_agree_with_each_other() {
        let is = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12;
        assert!(is(metres_per_second(1.0), metres(1.0) / seconds(1.0)));
        assert!(is(metres_per_second_squared(1.0), metres(1.0) / seconds(1.0).powi(2)));
        // N = kg·m/s², with 1000 g in a kg.
        let newton = 1000.0 * metres_per_second_squared(1.0);
        assert!(is(newton, 1.0) && is(millinewtons(1000.0), newton));
        assert!(is(pascals(1.0), newton / metres(1.0).powi(2)) && is(kilopascals(1.0), pascals(1000.0)));
        assert!(is(millimetres_of_mercury(1.0), pascals(133.322_387_415)));
        assert!(is(newtons_per_metre(1.0), newton / metres(1.0)));
        assert!(is(joules_per_square_metre(1.0), newton * metres(1.0) / metres(1.0).powi(2)));
        assert!(is(kilograms_per_cubic_metre(1.0), 1000.0 / metres(1.0).powi(3)) && is(micrometres(1e6), metres(1.0)));
    }
}
