//! Set-points held by the loops of both orders: predicted from a model and simulated, and for days.

use anyhow::Result;
use dielectric::experiment::{DeviceExperiment, DevicePhase};
use dielectric::predict::predict;
use diffusive::model::Model;
use dr_core::control::Drive;
use recording::Recording;

use super::records::run_of;

/// Set-points as shares of the range that the symbols can hold.
const SHARES: [f64; 3] = [-0.4, 0.1, 0.5];
/// Length of a loop that is predicted, s.
const LOOP_S: f64 = 40_000.0;
/// Gain of the integrator.
const GAIN_PER_TICK: f32 = 0.1;

/// A set-point, predicted and simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct LoopFigures {
    /// Order of the loop.
    pub order: u8,
    /// Set-point, V.
    pub target_v: f64,
    /// Mean symbol over the second half: predicted, simulated.
    pub mean_symbol: [f64; 2],
    /// Mean shift over the second half, V: predicted, simulated.
    pub mean_shift_v: [f64; 2],
    /// First crossing of the set-point, s: predicted, simulated.
    pub reached_s: [f64; 2],
    /// From the least to the greatest shift that the symbols hold, V.
    pub span_v: f64,
}

/// The three set-points under both orders, from a model of the device, on a device without charge.
pub fn predicted(model: &Model, prbs: &DeviceExperiment) -> Result<Vec<LoopFigures>> {
    let held = |drive: Drive| DeviceExperiment {
        phases: vec![DevicePhase { tick: 0, label: String::new(), drive }],
        ticks: (LOOP_S / prbs.shape.symbol_time_s) as u32,
        seed: prbs.seed + 1,
        ..prbs.clone()
    };
    let [least_v, most_v] = predict(model, &held(Drive::Passive), &mut |_| Ok(()))?.range_v;
    let mut all = Vec::new();
    for share in SHARES {
        let target_v = 0.5 * (least_v + most_v + share * (most_v - least_v));
        for order in [1, 2] {
            let experiment = held(drive(order, target_v as f32));
            let predicted = predict(model, &experiment, &mut |_| Ok(()))?.run;
            let simulated = run_of(&experiment)?.summary;
            let both = [&predicted.phases[0], &simulated.phases[0]];
            all.push(LoopFigures {
                order,
                target_v,
                mean_symbol: both.map(|of| of.mean_symbol.unwrap_or(f64::NAN)),
                mean_shift_v: both.map(|of| of.mean_voltage_shift_v.unwrap_or(f64::NAN)),
                reached_s: both.map(|of| of.reached_s.unwrap_or(f64::NAN)),
                span_v: most_v - least_v,
            });
        }
    }
    Ok(all)
}

/// A loop of an order at a set-point.
fn drive(order: u8, target: f32) -> Drive {
    match order {
        1 => Drive::Temperature { target_c: target },
        _ => Drive::SecondOrder { target, gain_per_tick: GAIN_PER_TICK },
    }
}

/// Days at a set-point.
#[derive(Debug, Clone, PartialEq)]
pub struct DaysFigures {
    /// Order of the loop.
    pub order: u8,
    /// Greatest distance of the measured shift from the set-point then, V.
    pub most_off_v: f64,
    /// By how much one symbol moves the shift, V: the greatest change from row to row.
    pub step_v: f64,
    /// Mean distance from the set-point, V.
    pub mean_off_v: f64,
    /// Mean symbol in the first and the last sixth.
    pub mean_symbol: [f64; 2],
}

/// Both orders over an experiment of days, whose first phase holds the set-point; pictures are
/// drawn of either.
pub fn days(experiment: &DeviceExperiment, draw: &dyn Fn(&str, &Recording) -> Result<()>) -> Result<[DaysFigures; 2]> {
    let target = experiment.phases[0].drive.target_range_c().map_or(0.0, |(target, _)| target);
    let of = |order: u8| -> Result<DaysFigures> {
        let phases = vec![DevicePhase { tick: 0, label: String::new(), drive: drive(order, target) }];
        let record = run_of(&DeviceExperiment { phases, ..experiment.clone() })?;
        draw(&format!("mems-days-{order}.svg"), &record.recording)?;
        let reached_s = record.summary.phases[0].reached_s.unwrap_or(f64::NAN);
        // The first crossing is followed by the swing of the approach.
        let from = ((reached_s / record.symbol_time_s) as usize + 60).min(record.rows.len().saturating_sub(2));
        let after = &record.rows[from..];
        let off = after.iter().map(|row| row.shift_v - f64::from(target));
        let steps = after.windows(2).map(|pair| (pair[1].shift_v - pair[0].shift_v).abs());
        let mean =
            |rows: &[super::records::DeviceNumbers]| rows.iter().map(|row| row.symbol).sum::<f64>() / rows.len() as f64;
        let sixth = after.len() / 6;
        Ok(DaysFigures {
            order,
            most_off_v: off.clone().fold(0.0, |most, off| f64::max(most, off.abs())),
            step_v: steps.fold(0.0, f64::max),
            mean_off_v: off.sum::<f64>() / after.len() as f64,
            mean_symbol: [mean(&after[..sixth]), mean(&after[after.len() - sixth..])],
        })
    };
    Ok([of(1)?, of(2)?])
}
