//! Coverage and errors of a campaign, kind by kind.

use std::fmt::{self, Display, Formatter};

use serde::Serialize;

use crate::table::ResultTable;

use super::campaign::DriftOutcome;
use super::room::RoomDrift;

/// Figures of one kind of drift.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DriftFigures {
    /// How the room moved.
    pub room: String,
    /// Records.
    pub records: usize,
    /// Share of records whose gain lies within two stated standard errors, %.
    pub within_2_se_percent: f64,
    /// Median error of the gain, K/W.
    pub median_error_k_per_w: f64,
    /// Median stated standard error, K/W.
    pub median_se_k_per_w: f64,
    /// Median error of a fit that knows what drift there is, K/W.
    pub median_known_error_k_per_w: Option<f64>,
    /// Share of records in which a drift was found, %.
    pub found_percent: f64,
    /// Share of models that their records support, %.
    pub supported_percent: f64,
}

/// What a campaign found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DriftReport {
    /// Kind by kind.
    pub kinds: Vec<DriftFigures>,
}

impl DriftFigures {
    /// Of the records of one kind.
    pub fn of(room: RoomDrift, outcomes: &[DriftOutcome]) -> Self {
        let share = |is: &dyn Fn(&DriftOutcome) -> bool| {
            100.0 * outcomes.iter().filter(|outcome| is(outcome)).count() as f64 / outcomes.len().max(1) as f64
        };
        let median = |of: &dyn Fn(&DriftOutcome) -> f64| {
            let mut values: Vec<f64> = outcomes.iter().map(of).collect();
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
        };
        let known = median(&|outcome| outcome.known_error_k_per_w.abs());
        Self {
            room: room.name(),
            records: outcomes.len(),
            within_2_se_percent: share(&|outcome| outcome.error_k_per_w.abs() <= 2.0 * outcome.se_k_per_w),
            median_error_k_per_w: median(&|outcome| outcome.error_k_per_w.abs()),
            median_se_k_per_w: median(&|outcome| outcome.se_k_per_w),
            median_known_error_k_per_w: known.is_finite().then_some(known),
            found_percent: share(&|outcome| outcome.has_drift),
            supported_percent: share(&|outcome| outcome.is_supported),
        }
    }
}

impl DriftReport {
    /// As a page of the book. `day` is when it was measured.
    pub fn page(&self, day: &str, records: u64) -> String {
        format!(
            "# Identification in a room that drifts\n\n\
             A heater of {:.0} K/W on three relaxations (0.8, 14 and 240 s), 90 min of pseudo-random power at 20 Hz after one quiet \
             minute, 8 mK of noise, in a room that moves by 0.15 K. {records} records of each kind, identified without options. \
             \u{201c}Known drift\u{201d} is a fit that is told its kind. Measured on {day} by\n\n\
             ```\ncargo run --release -p studies -- benchmark drift --records {records}\n```\n\n{self}",
            super::room::true_gain_k_per_w()
        )
    }
}

impl Display for DriftReport {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let row = |of: &DriftFigures| {
            let known = of.median_known_error_k_per_w.map_or("–".to_owned(), |known| format!("{known:.3}"));
            vec![
                of.room.to_string(),
                of.records.to_string(),
                format!("{:.0}", of.within_2_se_percent),
                format!("{:.3}", of.median_error_k_per_w),
                known,
                format!("{:.3}", of.median_se_k_per_w),
                format!("{:.0}", of.found_percent),
                format!("{:.0}", of.supported_percent),
            ]
        };
        let head = "room | records | within 2 se, % | median error, K/W | known drift | stated se | drift found, % | supported, %";
        f.write_str(&ResultTable::new(head, self.kinds.iter().map(row)).markdown())
    }
}
