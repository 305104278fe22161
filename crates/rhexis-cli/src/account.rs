//! The energy account of tears in the report, the summary and `events.jsonl`.

use rhexis_scene::measures::{AccountFigures, TearSpan};
use serde::Serialize;
use serde_json::{Value, json};

/// Figures as [`TearAccount`](rhexis_scene::measures::TearAccount) defines them.
#[derive(Serialize)]
pub(super) struct AccountReport {
    /// Torn by the criterion, without cuts.
    pub torn_area_mm2: f64,
    /// What the toughness claims for it; absent, as the next two, for a body without a toughness.
    pub surface_energy_mj: Option<f64>,
    /// G/G_c − 1 when tips advanced.
    pub overshoot_median: Option<f64>,
    pub overshoot_max: Option<f64>,
    /// Between the first and the last advance; absent where no balance of energy is kept (`output.energy`).
    pub between_advances: Option<SpanReport>,
}

/// A span of time.
#[derive(Serialize)]
pub(super) struct SpanReport {
    pub from_ms: f64,
    pub to_ms: f64,
    /// Torn from its beginning on, its last step's left out.
    pub torn_area_mm2: f64,
    /// Claimed for that area; part of what was released, wherever that went.
    pub surface_energy_mj: Option<f64>,
    pub work_mj: f64,
    pub edits_mj: f64,
    pub elastic_change_mj: f64,
    pub kinetic_change_mj: f64,
    /// Work and edits less the growth of the elastic energy; it went into motion and the next five.
    pub released_mj: f64,
    /// Taken by tips that glide, and by tears in static solves.
    pub torn_mj: f64,
    pub damping_mj: f64,
    pub drag_mj: f64,
    pub numerical_mj: f64,
    pub other_mj: f64,
    pub work_per_area_n_per_mm: f64,
    /// The same without what the load has gone on storing.
    pub released_per_area_n_per_mm: f64,
    /// What either is to be compared with.
    pub toughness_n_per_mm: Option<f64>,
}

impl SpanReport {
    fn of(span: &TearSpan) -> Self {
        let balance = &span.balance;
        Self {
            from_ms: span.time[0],
            to_ms: span.time[1],
            torn_area_mm2: span.area,
            surface_energy_mj: span.surface_energy,
            work_mj: balance.work(),
            edits_mj: balance.edits.elastic + balance.edits.kinetic,
            elastic_change_mj: balance.stored.elastic,
            kinetic_change_mj: balance.stored.kinetic,
            released_mj: span.released(),
            torn_mj: span.torn(),
            damping_mj: balance.damping,
            drag_mj: balance.drag,
            numerical_mj: balance.numerical(),
            other_mj: span.other(),
            work_per_area_n_per_mm: span.work_per_area(),
            released_per_area_n_per_mm: span.released_per_area(),
            toughness_n_per_mm: span.toughness(),
        }
    }
}

impl AccountReport {
    pub(crate) fn of(figures: &AccountFigures) -> Self {
        Self {
            torn_area_mm2: figures.area,
            surface_energy_mj: figures.surface_energy,
            overshoot_median: figures.overshoot.map(|overshoot| overshoot.median),
            overshoot_max: figures.overshoot.map(|overshoot| overshoot.max),
            between_advances: figures.span.as_ref().map(SpanReport::of),
        }
    }

    /// Its lines in the summary.
    pub(crate) fn summary(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if let (Some(median), Some(max)) = (self.overshoot_median, self.overshoot_max) {
            let (median, max) = (100.0 * median, 100.0 * max);
            lines.push(format!("    overshoot of the toughness: median {median:.1} %, largest {max:.1} %"));
        }
        if let Some(span) = &self.between_advances {
            let claimed = span.surface_energy_mj.map_or(String::new(), |energy| {
                let toughness = span.toughness_n_per_mm.unwrap_or(f64::NAN);
                format!(" of which the toughness claims {energy:.6} mJ ({toughness:.4} N/mm)")
            });
            lines.push(format!(
                "    between first and last advance: work {:.6} mJ ({:.4} N/mm of torn area), released {:.6} mJ ({:.4} N/mm){claimed}; \
                 it went into the tear {:.6}, damping {:.6}, drag {:.6}, the scheme {:.6}, motion {:.6}, other {:.6} mJ",
                span.work_mj,
                span.work_per_area_n_per_mm,
                span.released_mj,
                span.released_per_area_n_per_mm,
                span.torn_mj,
                span.damping_mj,
                span.drag_mj,
                span.numerical_mj,
                span.kinetic_change_mj,
                span.other_mj
            ));
        }
        lines
    }
}

/// A line of `events.jsonl`: where the energy of the advances at the beginning of a span has gone by its end.
pub(super) fn line(step: u64, body: &str, span: &TearSpan) -> Value {
    let mut line = json!({ "kind": "advances_paid", "step": step, "time_ms": span.time[1], "body": body });
    if let (Value::Object(fields), Ok(Value::Object(figures))) = (&mut line, serde_json::to_value(SpanReport::of(span)))
    {
        fields.extend(figures);
    }
    line
}
