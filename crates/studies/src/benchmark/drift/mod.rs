//! A rig whose gain is known, in a room that drifts: is the identified gain right, and as sure as
//! its standard error says? `studies benchmark drift`.
//!
//! [`room`] holds records of a heated body in a room that moves.

pub mod room;
use crate::table::ResultTable;
use diffusive::identify::record::RecordError;
use diffusive::identify::{DriftGiven, IdentifyOptions, identify};
pub use room::RoomDrift;
use room::{record, true_gain_k_per_w};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// Finding on one record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriftOutcome {
    /// Error of the steady gain.
    pub error_k_per_w: f64,
    /// Its stated standard error.
    pub se_k_per_w: f64,
    /// Error of a fit that knows what drift there is; NaN where that is no process.
    pub known_error_k_per_w: f64,
    /// The record supports the model.
    pub is_supported: bool,
    /// The model has a drift.
    pub has_drift: bool,
}

/// Identifies records 1 … `count` of a room. `progress` hears of every one.
///
/// # Errors
/// If one of them cannot be identified.
pub fn campaign(
    room: RoomDrift,
    count: u64,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Vec<DriftOutcome>, RecordError> {
    let next = AtomicU64::new(1);
    let found = Mutex::new(Vec::new());
    let work = || -> Result<(), RecordError> {
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed > count {
                return Ok(());
            }
            let outcome = identified(room, seed)?;
            found.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push((seed, outcome));
            progress(seed);
        }
    };
    std::thread::scope(|scope| {
        let other = scope.spawn(work);
        let own = work();
        own.and(other.join().unwrap_or(Ok(())))
    })?;
    let mut found = found.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    found.sort_by_key(|(seed, _)| *seed);
    Ok(found.into_iter().map(|(_, outcome)| outcome).collect())
}

fn identified(room: RoomDrift, seed: u64) -> Result<DriftOutcome, RecordError> {
    let mut record = record(room, seed)?;
    let mut gain = |drift: DriftGiven| {
        let options = IdentifyOptions { drift, ..IdentifyOptions::default() };
        identify(&mut record, &options, &mut |_, _, _| {}, &mut |_| {})
    };
    let model = gain(DriftGiven::Auto)?;
    let of = |model: &diffusive::model::Model| {
        let class = &model.pairs[0].classes["all"];
        (class.steady_gain_k_per_w - true_gain_k_per_w(), class.se_steady_gain_k_per_w)
    };
    let known = room.known().map(&mut gain).transpose()?;
    let (error_k_per_w, se_k_per_w) = of(&model);
    Ok(DriftOutcome {
        error_k_per_w,
        se_k_per_w,
        known_error_k_per_w: known.as_ref().map_or(f64::NAN, |model| of(model).0),
        is_supported: model.supported,
        has_drift: model.outputs[0].drift.as_ref().is_some_and(|drift| !drift.is_average()),
    })
}

/// Figures of one kind of drift.
#[derive(Debug, Clone, PartialEq)]
pub struct DriftFigures {
    /// Motion of the room.
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

/// Findings of a campaign.
#[derive(Debug, Clone, PartialEq)]
pub struct DriftReport {
    /// Kind by kind.
    pub kinds: Vec<DriftFigures>,
}

impl DriftFigures {
    /// Summary of the records of one kind.
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
    /// Page of the book. `day` is when it was measured.
    pub fn page(&self, day: &str, records: u64) -> String {
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
        let table = ResultTable::new(head, self.kinds.iter().map(row)).markdown();
        format!(
            "# Identification in a room that drifts\n\n\
             A heater of {:.0} K/W on three relaxations (0.8, 14 and 240 s), 90 min of pseudo-random power at 20 Hz after one quiet \
             minute, 8 mK of noise, in a room that moves by 0.15 K. {records} records of each kind, identified without options. \
             \u{201c}Known drift\u{201d} is a fit that is told its kind. Measured on {day} by\n\n\
             ```\ncargo run --release -p studies -- benchmark drift --records {records}\n```\n\n{table}",
            true_gain_k_per_w()
        )
    }
}
