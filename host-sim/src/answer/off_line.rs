//! A calibrated head's anemometer beside the ticks of a run or a recording: the code of the board, with what the head file says.

use dr_core::control::{Anemometer, Tick, WindCommand};
use wire::{MOST_ELEMENTS, WindSample};

use crate::head::calibration::Calibration;
use crate::head::{Answering, Head};

/// An anemometer that knows its head.
#[derive(Debug, Clone)]
pub struct OffLine<'a> {
    head: &'a Head,
    anemometer: Anemometer<MOST_ELEMENTS>,
    sample_period_s: f32,
    /// Elements that stay at the steady bandwidth after a jump although more was asked for, and why.
    not_quick: Vec<String>,
}

impl<'a> OffLine<'a> {
    /// # Errors
    /// A sentence: what of the calibration, or of how it shall answer, cannot be.
    pub fn new(
        head: &'a Head,
        calibration: &Calibration,
        answering: &Answering,
        sample_period_s: f64,
    ) -> Result<Self, String> {
        let made = calibration.commands(answering, sample_period_s);
        let (commands, observer) = made.map_err(|sentence| format!("{}: {sentence}", head.source.path.display()))?;
        let (anemometer, not_quick) = (Anemometer::new(), observer.not_quick);
        let mut own = Self { head, anemometer, sample_period_s: sample_period_s as f32, not_quick };
        head.set_up(&mut own.anemometer, &commands, sample_period_s).map_err(|error| error.to_string())?;
        Ok(own)
    }

    /// Elements that stay at the steady bandwidth after a jump, and why: a sentence for each reason.
    pub fn not_quick(&self) -> &[String] {
        &self.not_quick
    }

    /// Tells it the gas; its temperature only where the head has no reference.
    ///
    /// # Errors
    /// A sentence: which number cannot be.
    pub fn gas(&mut self, pressure_pa: f32, temperature_c: Option<f32>) -> Result<(), String> {
        let told = self.anemometer.handle(&WindCommand::Gas { pressure_pa, temperature_c }, self.sample_period_s);
        told.map_err(|error| error.to_string())
    }

    /// Follows a tick; gives an answer where one is due.
    pub fn step(&mut self, tick: &Tick<MOST_ELEMENTS>) -> Option<WindSample> {
        let head = self.head;
        let answer = self.anemometer.step(tick, |element, temperature_c| standing_w(head, element, temperature_c))?;
        Some(WindSample::from(&answer))
    }
}

/// Power of an element at its low level, W.
pub(super) fn standing_w(head: &Head, element: usize, temperature_c: f32) -> f32 {
    head.elements.get(element).map_or(0.0, |of| of.config.channel.standing_power_w(temperature_c))
}

/// Outward axes of the parts, for the linear inverse.
pub fn axes(head: &Head, calibration: &Calibration) -> Vec<[f64; 3]> {
    calibration.parts.iter().filter_map(|&place| head.elements[place].normal).collect()
}
