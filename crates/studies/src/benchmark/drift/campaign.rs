//! Records of a rig identified without options, on two threads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use diffusive::identify::record::RecordError;
use diffusive::identify::{DriftGiven, IdentifyOptions, identify};

use super::room::{RoomDrift, record, true_gain_k_per_w};

/// What was found of one record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriftOutcome {
    /// Error of the steady gain.
    pub error_k_per_w: f64,
    /// Its stated standard error.
    pub se_k_per_w: f64,
    /// Error of a fit that knows what drift there is; NaN where that is no process.
    pub known_error_k_per_w: f64,
    /// The offset that was found, for 22 °C.
    pub offset_c: f64,
    /// Whether the record supports the model.
    pub is_supported: bool,
    /// Whether the model has a drift.
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
        offset_c: model.offset_c,
        is_supported: model.supported,
        has_drift: model.outputs[0].drift.as_ref().is_some_and(|drift| !drift.is_average()),
    })
}
