//! Where the loop of first order locks: plateaus predicted from an identified model, and searched
//! for in the simulated loop.

use anyhow::Result;
use dielectric::experiment::{DeviceExperiment, DevicePhase};
use dielectric::predict::{DevicePredictError, Plateau, response_of};
use diffusive::identify::{DriftGiven, IdentifyOptions, identify};
use dr_core::control::Drive;

use super::records::run_of;

/// Plateaus that are compared: the widest.
const COUNT: usize = 5;
/// Longest stream of a plateau, symbols.
const MOST_SYMBOLS: usize = 8;
/// Length of a loop that is searched, and what of it is looked at, symbols: a multiple of all
/// lengths of streams up to 8.
const LOOP_TICKS: u32 = 9000;
const SEEN_TICKS: usize = 1680;
/// Halvings of a search for an edge.
const HALVINGS: u32 = 9;

/// A plateau, predicted and simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct PlateauFigures {
    /// From the model.
    pub predicted: Plateau,
    /// Its edges in the simulated loop of first order, V.
    pub simulated_v: [f64; 2],
    /// Mean symbol of the loop of first order at its lower edge, middle and upper edge.
    pub first_order: [f64; 3],
    /// The same of second order.
    pub second_order: [f64; 3],
    /// From the least to the greatest shift that the symbols hold, V.
    pub span_v: f64,
}

/// Identifies the device of an experiment from its own run, and compares the widest plateaus.
pub fn compare(experiment: &DeviceExperiment) -> Result<Vec<PlateauFigures>> {
    let record = run_of(experiment)?;
    let options = IdentifyOptions { drift: DriftGiven::None, ..IdentifyOptions::default() };
    let model = identify(&mut record.table()?, &options, &mut |_, _, _| {}, &mut |_| {})?;
    let response = response_of(&model, record.symbol_time_s).map_err(DevicePredictError::from)?;
    let span_v = 2.0 * response.steady_v().abs();
    let mut plateaus = response.plateaus(MOST_SYMBOLS, experiment.device.shift_noise_v(&experiment.shape));
    plateaus.sort_by(|a, b| (b.to_v - b.from_v).total_cmp(&(a.to_v - a.from_v)));
    plateaus.truncate(COUNT);
    let of = |plateau: &Plateau| {
        let (middle_v, width_v) = (0.5 * (plateau.from_v + plateau.to_v), plateau.to_v - plateau.from_v);
        let is_inside = |target_v: f64| {
            let drive = Drive::Temperature { target_c: target_v as f32 };
            anyhow::Ok((mean_symbol(experiment, drive)? - plateau.mean_symbol).abs() < 1e-9)
        };
        let edge = |towards: f64| {
            // From the middle outwards; beyond twice its width there is another stream.
            let (mut inside, mut outside) = (0.0, 2.0 * width_v);
            for _ in 0..HALVINGS {
                let at = 0.5 * (inside + outside);
                if is_inside(middle_v + towards * at)? { inside = at } else { outside = at }
            }
            anyhow::Ok(middle_v + towards * 0.5 * (inside + outside))
        };
        let places_v = [plateau.from_v + 0.1 * width_v, middle_v, plateau.to_v - 0.1 * width_v];
        let mean_of = |drive: &dyn Fn(f32) -> Drive| {
            let [low, middle, high] = places_v.map(|target_v| mean_symbol(experiment, drive(target_v as f32)));
            anyhow::Ok([low?, middle?, high?])
        };
        Ok(PlateauFigures {
            predicted: *plateau,
            simulated_v: [edge(-1.0)?, edge(1.0)?],
            first_order: mean_of(&|target| Drive::Temperature { target_c: target })?,
            second_order: mean_of(&|target| Drive::SecondOrder { target, gain_per_tick: 0.1 })?,
            span_v,
        })
    };
    plateaus.iter().map(of).collect()
}

/// Mean symbol at the end of a loop.
fn mean_symbol(experiment: &DeviceExperiment, drive: Drive) -> Result<f64> {
    let phases = vec![DevicePhase { tick: 0, label: String::new(), drive }];
    let record = run_of(&DeviceExperiment { phases, ticks: LOOP_TICKS, ..experiment.clone() })?;
    let seen = &record.rows[record.rows.len() - SEEN_TICKS..];
    Ok(seen.iter().map(|row| row.symbol).sum::<f64>() / SEEN_TICKS as f64)
}
