//! Result of the last solve and account of the guard among the bytes of a snapshot: one block, as version 14 had it.

use crate::components::{GuardLedger, SolveResult};
use crate::settings::Tangent;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The block. Temporaries of a step, kept by version 14, are written as none and skipped on reading.
#[derive(Serialize, Deserialize)]
struct Block {
    stored: f64,
    is_audited: bool,
    iterations: u32,
    newton_iterations: u32,
    linear_residual: f64,
    stress_error: f64,
    is_late: bool,
    imbalance: f64,
    is_converged: bool,
    fell_back: bool,
    tangent: Tangent,
    spurious_energy: f64,
    /// Negative pace of holds \[mm\]; zero for no limit, as are positive bounds, which version 14 had here.
    hold_pace: f64,
    start_spurious_energy: [f64; 2],
    creates_energy: bool,
    is_step_limited: bool,
    fallback_shortenings: u32,
    relaxing: u32,
    position_error: f64,
    line_search: Option<[f64; 3]>,
}

pub(super) fn serialize<S: Serializer>(
    solve: &Option<(SolveResult, GuardLedger)>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let block = solve.as_ref().map(|(result, ledger)| Block {
        stored: 0.0,
        is_audited: false,
        iterations: result.iterations,
        newton_iterations: result.newton_iterations,
        linear_residual: result.linear_residual,
        stress_error: result.stress_error,
        is_late: result.is_late,
        imbalance: result.imbalance,
        is_converged: result.has_converged,
        fell_back: result.fell_back,
        tangent: result.tangent,
        spurious_energy: ledger.spurious_energy,
        hold_pace: 0.0 - ledger.hold_pace,
        start_spurious_energy: [ledger.start_spurious_energy, 0.0],
        creates_energy: ledger.creates_energy,
        is_step_limited: ledger.is_step_limited,
        fallback_shortenings: 0,
        relaxing: ledger.relaxing,
        position_error: result.position_error,
        line_search: None,
    });
    block.serialize(serializer)
}

pub(super) fn deserialize<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<(SolveResult, GuardLedger)>, D::Error> {
    let block = Option::<Block>::deserialize(deserializer)?;
    Ok(block.map(|block| {
        let result = SolveResult {
            iterations: block.iterations,
            newton_iterations: block.newton_iterations,
            linear_residual: block.linear_residual,
            stress_error: block.stress_error,
            position_error: block.position_error,
            is_late: block.is_late,
            imbalance: block.imbalance,
            // Of a phase: set when the next step begins.
            is_in_step: false,
            is_active: false,
            has_converged: block.is_converged,
            fell_back: block.fell_back,
            fallback_factors: 0,
            tangent: block.tangent,
            work: 0,
            work_of_advance: 0,
            is_tear_undecided: false,
            is_release_unsettled: false,
            is_traction_unsettled: false,
            is_cut_short: false,
            has_gliding_tips: false,
            follows_glide: false,
            fault: None,
        };
        let ledger = GuardLedger {
            spurious_energy: block.spurious_energy,
            start_spurious_energy: block.start_spurious_energy[0],
            creates_energy: block.creates_energy,
            is_step_limited: block.is_step_limited,
            hold_pace: (-block.hold_pace).max(0.0),
            start_hold_pace: 0.0,
            relaxing: block.relaxing,
        };
        (result, ledger)
    }))
}
