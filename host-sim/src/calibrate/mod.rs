//! Calibration of a head in a wind tunnel: from its readings in known winds to what the board needs to tell unknown ones.
//!
//! ```text
//! c_i (q_i + G0_i a_i) = θ_i (k A_i / d) Nu_i(r)          Nu_i = Σ_n a_n(Re) q_n(i, w),   r = R v ρ d / µ,   w = −r/|r|
//! ```
//!
//! Known: winds v, readings q, θ, a (see [`run`]), the head as drawn (q_n comes from dr-core's `Part`). Sought: the amplitudes a_n(Re) as
//! splines in ln Re, gains c_i of mean one, zero-wind conductances G0_i ≥ 0, the mounting R.
//!
//! | file | what |
//! |---|---|
//! | [`run`] | the data, and what cannot be meant |
//! | [`speeds`], [`spread`] | whether the winds determine the unknowns, and which are missing |
//! | [`spline`], [`family`] | amplitudes as functions of the Reynolds number, and what is known of them beforehand |
//! | [`rotation`] | the mounting |
//! | [`equations`], [`fit`] | weighted least squares |
//! | [`calibration`] | what was found, with errors, and dr-core's configurations of it |
//! | [`folds`], [`held_out`](mod@held_out) | cross-validation through dr-core's inverse |
//! | [`report`] | all that in words |
//! | [`card`] | all of it for the four dice of a card, in winds of its plane |
//!
//! *What no wind can tell.* A common factor of all gains is one of all amplitudes: the mean gain is one by definition. A common offset
//! of G0 is, at one overheat in one gas, one of a_0: still gas among the readings settles it, where Nu is 2. Without it only k A / d holds
//! G0, to 30 %, which matters once the gas temperature is another than that of the calibration.
//!
//! *Accuracy* on ideal 10 mm spheres in CO2 of 1000 Pa, Re 11 to 305, gains and mounting unknown, 0.1 % of noise (tests): 12 speeds from 10
//! directions tell directions that were held out to 0.17° and 0.17 % of speed rms, bands of speeds that were held out to 0.4° and 0.5 %; the
//! mounting is found within 0.02° (two hemispheres: 0.06°). 6 speeds from 6 directions still do for 0.2° and 0.4 % (two hemispheres: 0.5° and 0.3 %). What is left
//! comes from the bend that the simulated amplitudes have at Re 200. Gas 5 K warmer or colder than in the calibration costs nothing,
//! without still gas among the readings 0.5 % of speed.
//!
//! *Limits.* The winds count as known exactly; their errors belong into the variances. No stem, no free convection, one Prandtl number.

pub mod calibration;
pub mod card;
pub mod equations;
pub mod family;
pub mod fit;
pub mod folds;
pub mod held_out;
pub mod report;
pub mod rotation;
pub mod run;
pub mod speeds;
pub mod spline;
pub mod spread;

pub use calibration::{CalibratedPart, Calibration};
pub use card::{CardCalibration, CardHeldOut, DrawnCard};
pub use folds::Scheme;
pub use held_out::{HeldOut, held_out};
pub use run::{GasProperties, Head, HeadPart, PartReading, Steady};

use family::{Family, seen_orders};

/// Of the convective power, rms. Two parts in each other's place leave 24 %; no stem takes as much as this.
const MOST_RESIDUAL_RMS: f64 = 0.1;

#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CalibrateError {
    #[error("head: {0}")]
    Head(String),
    #[error("wind `{label}`: {sentence}")]
    Reading { label: String, sentence: String },
    /// What is missing, a sentence each.
    #[error("the winds do not determine a calibration:\n  {}", .0.join("\n  "))]
    Spread(Vec<String>),
    #[error(
        "no best fit of the readings could be found: a gain is far from 1 or the mounting far from drawn; check the order of the parts \
         and the frame of the winds"
    )]
    NoMinimum,
    #[error(
        "what fits best leaves {:.0} % rms of the convective power, most of it `{}`, {}: parts in another order than the head's, winds in another \
         frame, or a part of the head that is not as drawn",
        100.0 * residual_rms, worst.label, worst.part
    )]
    Unexplained { residual_rms: f64, worst: calibration::Worst },
    #[error(
        "the amplitudes that fit best do not tell a wind: {0}; check the order of the parts and the signs of the winds"
    )]
    Amplitudes(#[from] dr_core::ConfigError),
}

/// Calibrates a head.
///
/// # Errors
/// If a reading cannot be meant, if the winds do not determine what is sought, or if what fits best makes no head.
pub fn calibrate(head: &Head, steady: &[Steady]) -> Result<Calibration, CalibrateError> {
    let ready = run::ready(head)?;
    let winds = run::winds(&ready, steady)?;
    let orders = seen_orders(head.parts.iter().map(|part| &part.config));
    let lacking = spread::lacking(&ready, &winds, &orders);
    if !lacking.is_empty() {
        return Err(CalibrateError::Spread(lacking));
    }
    solve(head, steady)
}

/// The same without asking whether the winds are well spread.
fn solve(head: &Head, steady: &[Steady]) -> Result<Calibration, CalibrateError> {
    let ready = run::ready(head)?;
    let winds = run::winds(&ready, steady)?;
    let moving = speeds::ascending(&winds);
    let (Some(first), Some(last)) = (moving.first(), moving.last()) else {
        return Err(CalibrateError::Spread(vec!["all readings are of still gas: winds are missing".into()]));
    };
    if first.reynolds >= last.reynolds {
        return Err(CalibrateError::Spread(vec!["all winds have one speed".into()]));
    }
    let orders = seen_orders(head.parts.iter().map(|part| &part.config));
    // The middle of every speed, but the first and last wind themselves.
    let mut reynolds: Vec<f64> = speeds::distinct(&moving)
        .iter()
        .map(|group| (group.iter().map(|wind| wind.reynolds.ln()).sum::<f64>() / group.len() as f64).exp())
        .collect();
    reynolds.dedup();
    if let [only] = reynolds[..] {
        reynolds.push(only);
    }
    let end = reynolds.len() - 1;
    (reynolds[0], reynolds[end]) = (first.reynolds, last.reynolds);

    let family = Family::new(&reynolds, orders, moving.len() * head.parts.len());
    let problem = equations::Problem::new(&ready, &winds, family);
    let fitted = fit::fit(&problem)?;
    let calibration = Calibration::of(&problem, head, &fitted);
    if calibration.residual_rms > MOST_RESIDUAL_RMS {
        let Calibration { residual_rms, worst, .. } = calibration;
        return Err(CalibrateError::Unexplained { residual_rms, worst });
    }
    dr_core::sensor::wind::Nusselt::new(&calibration.nusselt())?;
    Ok(calibration)
}

#[cfg(test)]
mod tests;
