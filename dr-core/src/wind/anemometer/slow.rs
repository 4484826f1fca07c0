//! Corrections of slow errors, and what finds them: the inverse by itself, in a gas.

use super::Anemometer;
use crate::wind::anemometer::head_inverse::HeadInverse;
use crate::wind::free_stream::FreeStream;
use crate::wind::gas::GasState;
use crate::wind::gas_law::ZERO_CELSIUS_K;
use crate::wind::slow_errors::SurfaceCorrection;
use crate::wind::sphere::SECTORS;
use crate::wind::surface_inverse::WindVector;

impl<const N: usize> Anemometer<N> {
    /// Corrects the conductances of the first surfaces from now on.
    pub fn correct(&mut self, corrections: Option<[SurfaceCorrection; SECTORS]>) {
        self.corrections = corrections;
        self.update_given_checksum();
    }

    /// Corrections of the wind.
    pub const fn corrections(&self) -> Option<&[SurfaceCorrection; SECTORS]> {
        self.corrections.as_ref()
    }

    /// The inverse of a head of surfaces round a body; none of a card, or without a calibration.
    pub fn vector(&self) -> Option<&WindVector> {
        match &self.output.as_ref()?.head {
            Some(HeadInverse::Surfaces(vector)) => Some(vector),
            _ => None,
        }
    }

    /// The gas at a temperature, °C, round surfaces of this mean overheat, K; none without a
    /// pressure, or outside its law.
    pub fn gas_at(&self, gas_c: f32, overheat_k: f32) -> Option<GasState> {
        self.gas(Some(gas_c), overheat_k)
    }

    /// From the wind to the stream that surfaces of this mean overheat, K, meet, and the speed of
    /// its rise, m/s.
    pub fn free_stream(&self, gas_c: f32, overheat_k: f32) -> (FreeStream, f32) {
        let free = self.setup.convection.as_ref().map_or_else(FreeStream::default, |of| of.free_stream);
        let diameter_m = self.output.as_ref().map_or(0.0, |output| output.config.diameter_m);
        (free, free.rise_speed_m_s(overheat_k, gas_c + ZERO_CELSIUS_K, diameter_m))
    }

    /// κ: share of a conductance by which the calibration misses it at a speed; 0 where it does not
    /// say.
    pub fn missed_share(&self, gas: &GasState, gas_c: f32, speed_m_s: f32) -> f32 {
        let scale = self.output.as_ref().and_then(|output| self.setup.scale(&output.config, gas, gas_c));
        let (Some(uncertainty), Some(scale)) = (&self.setup.uncertainty, scale) else { return 0.0 };
        uncertainty.conductance_share_at(scale.place(speed_m_s * scale.per_speed))
    }

    /// Tells whether the calibration assumes properties of the film.
    pub fn is_film_assumed(&self) -> bool {
        self.setup.convection.as_ref().is_some_and(crate::wind::convection::ConvectionSettings::is_film_assumed)
    }

    /// Gains of the surfaces, one after the other.
    pub fn gains(&self) -> impl Iterator<Item = f32> {
        self.setup.surfaces().map(|part| part.gain)
    }
}
