//! Content of a closed volume: its pressure, its energy and its flow through an orifice.
//!
//! The content C is measured by the volume that it takes at ambient pressure. With the exponent γ and the stiffness K the pressure beyond the ambient one
//! is p = K·((C/V)^γ − 1): a gas with K the ambient pressure, a liquid with γ = 1 and K the bulk modulus. Through an orifice flows
//! Q = c·A·√(2·Δp/ρ), by which p at the end of a span is that of C − span·Q(p).

use super::elementary::{ln, pow};

/// Relative compression up to which powers are expanded.
const SMALL: f64 = 1e-3;

/// Smallest part of the content to which it may be compressed.
const LEAST_VOLUME: f64 = 1e-6;

/// Flow in a span, as a part of the volume, below which the resistance of an orifice counts as constant in the tangent.
const LEAST_FLOW: f64 = 1e-6;

/// Maximum iterations for the flow: halving alone reaches rounding in fewer.
const FLOW_ITERATIONS: u32 = 100;

/// Liquid or gas that fills a compartment: beyond the ambient pressure it has K·((C/V)^γ − 1) at the volume V, C being that of the content at ambient pressure.
///
/// # Examples
/// ```
/// use rhexis::components::Content;
///
/// let soft = Content { stiffness: 2.0, ..Content::default() };
/// let air = Content { stiffness: 0.101325, exponent: 1.4, density: 1.2e-6 };
/// assert!(air.density < soft.density);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Content {
    /// K \[MPa\]: bulk modulus of a liquid, ambient pressure of a gas beyond zero.
    pub stiffness: f64,
    /// γ, from 1 to 3: 1 for a liquid or a gas at constant temperature, 1.4 for air in a fast change.
    pub exponent: f64,
    /// Density at ambient pressure \[g/mm³\].
    pub density: f64,
}

impl Default for Content {
    /// Water.
    fn default() -> Self {
        Self { stiffness: 2200.0, exponent: 1.0, density: 1e-3 }
    }
}

/// Flow out of a volume over a span of time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Outflow {
    /// Length of the span \[ms\].
    pub span: f64,
    /// Coefficient of discharge times the area of the opening \[mm²\].
    pub area: f64,
    /// Pressure outside \[MPa\].
    pub outside: f64,
}

/// Pressure at a volume, with the derivatives along the volume.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Filled {
    /// \[MPa\]
    pub pressure: f64,
    /// −dp/dV \[MPa/mm³\], ≥ 0.
    pub stiffness: f64,
    /// Flow out \[mm³/ms\].
    pub flow: f64,
    /// Derivative of the flow along the volume \[1/ms\], ≤ 0.
    pub flow_slope: f64,
}

impl Content {
    /// Relative compression (C − V)/V, of a volume that is not below its bound.
    fn compression(&self, volume: f64, content: f64) -> (f64, f64) {
        let volume = volume.max(LEAST_VOLUME * content);
        ((content - volume) / volume, volume)
    }

    /// (1 + x)^e − 1.
    fn power(x: f64, e: f64) -> f64 {
        if x.abs() < SMALL {
            let third = e * (e - 1.0) * (e - 2.0) / 6.0;
            let fourth = third * (e - 3.0) / 4.0;
            return x * (e + x * (0.5 * e * (e - 1.0) + x * (third + x * fourth)));
        }
        if e == 1.0 { x } else { pow(1.0 + x, e) - 1.0 }
    }

    /// Pressure \[MPa\] beyond the ambient one.
    pub(crate) fn pressure(&self, volume: f64, content: f64) -> f64 {
        self.stiffness * Self::power(self.compression(volume, content).0, self.exponent)
    }

    /// Volume \[mm³\] at which the content has a pressure.
    pub(crate) fn volume(&self, pressure: f64, content: f64) -> f64 {
        let x = (pressure / self.stiffness).max(LEAST_VOLUME - 1.0);
        content / if self.exponent == 1.0 { 1.0 + x } else { pow(1.0 + x, 1.0 / self.exponent) }
    }

    /// Content \[mm³\] that has a pressure at a volume.
    pub(crate) fn content(&self, pressure: f64, volume: f64) -> f64 {
        volume * volume / self.volume(pressure, volume)
    }

    /// −∂p/∂V and ∂p/∂C \[MPa/mm³\].
    fn slopes(&self, volume: f64, content: f64) -> [f64; 2] {
        let (x, volume) = self.compression(volume, content);
        let slope = self.exponent * self.stiffness * (1.0 + Self::power(x, self.exponent));
        [slope / volume, slope / content]
    }

    /// Energy \[mJ\] that the content stores beyond that at ambient pressure: −∫ p dV from C on.
    pub(crate) fn energy(&self, volume: f64, content: f64) -> f64 {
        let (x, volume) = self.compression(volume, content);
        let e = self.exponent;
        let per_volume = if x.abs() < SMALL {
            let third = e * (e - 2.0) / 6.0;
            let fourth = third * (e - 3.0) / 4.0;
            let fifth = fourth * (e - 4.0) / 5.0;
            x * x * (0.5 * e + x * (third + x * (fourth + x * fifth)))
        } else if e == 1.0 {
            (1.0 + x) * ln(1.0 + x) - x
        } else {
            (Self::power(x, e) - x) / (e - 1.0) - x
        };
        self.stiffness * volume * per_volume
    }

    /// Energy \[MPa\] by which content that is added at ambient pressure adds to that stored, per volume.
    pub(crate) fn potential(&self, volume: f64, content: f64) -> f64 {
        let (x, _) = self.compression(volume, content);
        let e = self.exponent;
        self.stiffness
            * if e == 1.0 {
                if x.abs() < SMALL { x * (1.0 - x * (0.5 - x * (1.0 / 3.0 - 0.25 * x))) } else { ln(1.0 + x) }
            } else {
                e / (e - 1.0) * Self::power(x, e - 1.0)
            }
    }

    /// Pressure at a volume \[mm³\] of a content that flows out over a span.
    pub(crate) fn filled(&self, volume: f64, content: f64, out: &Outflow) -> Filled {
        let closed = self.pressure(volume, content);
        let Outflow { span, area, outside } = *out;
        if !(span > 0.0 && area > 0.0) {
            return Filled { pressure: closed, stiffness: self.slopes(volume, content)[0], ..Filled::default() };
        }
        // Δp = resistance·Q·|Q|/2.
        let resistance = self.density / (area * area);
        let flow = self.flow(volume, content, closed, (resistance, out));
        let left = content - span * flow;
        let [along, of_content] = self.slopes(volume, left);
        let opposed = resistance * flow.abs().max(LEAST_FLOW * volume / span);
        let flow_slope = -along / (opposed + span * of_content);
        let pressure = outside + 0.5 * resistance * flow * flow.abs();
        Filled { pressure, stiffness: -flow_slope * opposed, flow, flow_slope }
    }

    /// The flow by which the pressure drop over the orifice is that of the content that is left: the only root of an ascending function.
    fn flow(&self, volume: f64, content: f64, closed: f64, (resistance, out): (f64, &Outflow)) -> f64 {
        let Outflow { span, outside, .. } = *out;
        let drop = closed - outside;
        let full = drop.signum() * (2.0 * drop.abs() / resistance).sqrt();
        let most = (1.0 - LEAST_VOLUME) * content / span;
        let [mut low, mut high] = if drop < 0.0 { [full, 0.0] } else { [0.0, full.min(most)] };
        let mut flow = if drop < 0.0 { low } else { high };
        for _ in 0..FLOW_ITERATIONS {
            let left = content - span * flow;
            let excess = 0.5 * resistance * flow * flow.abs() + outside - self.pressure(volume, left);
            *(if excess > 0.0 { &mut high } else { &mut low }) = flow;
            let slope = resistance * flow.abs() + span * self.slopes(volume, left)[1];
            let next = flow - excess / slope;
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            if (next - flow).abs() <= f64::EPSILON * flow.abs() || excess == 0.0 {
                break;
            }
            flow = next;
        }
        flow
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAS: Content = Content { stiffness: 0.1, exponent: 1.4, density: 1.2e-6 };
    const LIQUID: Content = Content { stiffness: 2000.0, exponent: 1.0, density: 1e-3 };

    #[test]
    fn the_energy_is_what_the_pressure_does() {
        for (law, content) in [(GAS, 130.0), (GAS, 100.03), (LIQUID, 100.01), (LIQUID, 180.0)] {
            let h = 1e-3;
            let slope = (law.energy(100.0 + h, content) - law.energy(100.0 - h, content)) / (2.0 * h);
            let p = law.pressure(100.0, content);
            assert!((slope + p).abs() < 1e-6 * p.abs(), "{law:?} {slope} {p}");
            let slope = (law.energy(100.0, content + h) - law.energy(100.0, content - h)) / (2.0 * h);
            assert!((law.volume(p, content) - 100.0).abs() < 1e-9);
            assert!((law.content(p, 100.0) - content).abs() < 1e-9);
            let potential = law.potential(100.0, content);
            assert!((slope - potential).abs() < 1e-6 * potential.abs(), "{law:?} {slope} {potential}");
        }
    }

    #[test]
    fn flow_and_pressure_obey_the_orifice_and_the_content_that_is_left() {
        for (law, content) in [(GAS, 130.0), (GAS, 90.0), (LIQUID, 100.01), (LIQUID, 99.0), (LIQUID, 101.0)] {
            let out = Outflow { span: 2.0, area: 0.3, outside: 1e-3 };
            let at = |volume: f64| law.filled(volume, content, &out);
            let Filled { pressure, stiffness, flow, flow_slope } = at(100.0);
            let drop = 0.5 * law.density * flow * flow.abs() / (0.3 * 0.3);
            assert!((pressure - out.outside - drop).abs() < 1e-12);
            let left = law.pressure(100.0, content - 2.0 * flow);
            assert!((pressure - left).abs() < 1e-9 * law.stiffness, "{law:?} {pressure} {left}");
            let h = 1e-4;
            let slopes = [at(100.0 + h), at(100.0 - h)];
            let p = -(slopes[0].pressure - slopes[1].pressure) / (2.0 * h);
            let q = (slopes[0].flow - slopes[1].flow) / (2.0 * h);
            assert!((p - stiffness).abs() < 1e-3 * stiffness, "{law:?} {p} {stiffness}");
            assert!((q - flow_slope).abs() < 1e-3 * flow_slope.abs(), "{law:?} {q} {flow_slope}");
        }
    }
}
