//! The simulated device: banks of charge under two voltages in turn, a C₀ that follows its
//! surroundings, and a meter with noise.

use diffusive::random::StandardNormal;
use dr_core::model::mesh;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::Distribution;

use crate::device::{Carriers, Device, Simulation};
use crate::port::{ChargeSymbol, SymbolShape};
use crate::port::{DevicePort, DeviceTruth, PortError, SymbolReadings};

/// A device that is computed. All times are its own: it waits for nobody.
pub struct SimulatedDevice {
    device: Device,
    simulation: Simulation,
    surroundings: Vec<SurroundingsPoint>,
    noise: ChaCha8Rng,
    now_s: f64,
    banks: Vec<ChargeBank>,
    /// Shares of the way that relaxations go in a part, by its length.
    gains: Vec<(f64, Vec<Vec<f64>>)>,
    truth: DeviceTruth,
}

/// Charge of carriers of one kind.
struct ChargeBank {
    carriers: Carriers,
    rates_rad_s: Vec<f64>,
    weights: Vec<f64>,
    /// x_k, V.
    x_v: Vec<f64>,
}

impl ChargeBank {
    fn empty(carriers: &Carriers) -> Self {
        let (rates_rad_s, weights) = carriers.bank();
        Self { carriers: carriers.clone(), x_v: vec![0.0; weights.len()], rates_rad_s, weights }
    }
}

impl SimulatedDevice {
    /// A device without charge. None if its file has no simulation.
    pub fn new(device: &Device, surroundings: &[SurroundingsPoint], seed: u64) -> Option<Self> {
        let simulation = device.simulation.clone()?;
        let truth = DeviceTruth { shift_v: 0.0, offset_f: device.capacitor.offset_f };
        Some(Self {
            device: device.clone(),
            banks: simulation.carriers.iter().map(ChargeBank::empty).collect(),
            simulation,
            surroundings: surroundings.to_vec(),
            noise: ChaCha8Rng::seed_from_u64(seed),
            now_s: 0.0,
            gains: Vec::new(),
            truth,
        })
    }

    /// V_sh, V.
    pub fn shift_v(&self) -> f64 {
        let of = |bank: &ChargeBank| bank.x_v.iter().zip(&bank.weights).map(|(x, weight)| x * weight).sum::<f64>();
        self.banks.iter().map(of).sum()
    }

    /// C₀ now, F.
    fn offset_f(&self) -> f64 {
        let (temperature_c, humidity_percent) = self.surroundings_now();
        let of = &self.simulation;
        let share = of.offset_per_k * (temperature_c - of.temperature_c)
            + of.offset_per_percent * (humidity_percent - of.humidity_percent)
            + of.offset_per_hour * self.now_s / 3600.0;
        self.device.capacitor.offset_f * (1.0 + share)
    }

    fn surroundings_now(&self) -> (f64, f64) {
        let own = (self.simulation.temperature_c, self.simulation.humidity_percent);
        surroundings_at(&self.surroundings, self.now_s).unwrap_or(own)
    }

    /// Holds a bias for a time.
    pub fn hold(&mut self, bias_v: f64, time_s: f64) {
        let charging =
            1.0 + self.simulation.charging_per_k * (self.surroundings_now().0 - self.simulation.temperature_c);
        let at = self.gains.iter().position(|(known_s, _)| *known_s == time_s).unwrap_or_else(|| {
            let of = |bank: &ChargeBank| bank.rates_rad_s.iter().map(|rate| mesh::gain(*rate, time_s)).collect();
            self.gains.push((time_s, self.banks.iter().map(of).collect()));
            self.gains.len() - 1
        });
        for (bank, gains) in self.banks.iter_mut().zip(&self.gains[at].1) {
            let steady_v = charging * bank.carriers.steady_v(bias_v);
            for (x, gain) in bank.x_v.iter_mut().zip(gains) {
                *x += gain * (steady_v - *x);
            }
        }
        self.now_s += time_s;
    }

    /// A reading under a bias: none above the meter's range, as when the membrane has fallen.
    pub fn read(&mut self, bias_v: f64) -> Option<f64> {
        let over_v = bias_v - self.shift_v();
        let noise: f64 = StandardNormal.sample(&mut self.noise);
        if over_v.abs() >= self.device.capacitor.pull_in_v {
            // It lies on the dielectric: more than any capacitance of one that hangs free.
            return Some(0.5 * (self.device.limits.capacitance_max_f + self.device.meter.full_scale_f));
        }
        let capacitance_f = self.device.capacitor.curvature_f_v2 * over_v * over_v + self.offset_f();
        Some(capacitance_f + self.device.meter.noise_f * noise).filter(|of| *of < self.device.meter.full_scale_f)
    }
}

/// Temperature and humidity at a time; between two points both go straight.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurroundingsPoint {
    /// When, s.
    pub start_s: f64,
    /// Temperature, °C.
    pub temperature_c: f64,
    /// Relative humidity, %.
    pub humidity_percent: f64,
}

/// Temperature in °C and humidity in % at a moment; before the first point and after the last,
/// theirs. None without points.
pub fn surroundings_at(points: &[SurroundingsPoint], now_s: f64) -> Option<(f64, f64)> {
    let next = points.partition_point(|point| point.start_s <= now_s);
    let after = points.get(next).or(points.last())?;
    let before = points.get(next.saturating_sub(1))?;
    let length_s = after.start_s - before.start_s;
    let share = if length_s > 0.0 { ((now_s - before.start_s) / length_s).clamp(0.0, 1.0) } else { 0.0 };
    let between = |from: f64, to: f64| from + share * (to - from);
    Some((between(before.temperature_c, after.temperature_c), between(before.humidity_percent, after.humidity_percent)))
}

impl DevicePort for SimulatedDevice {
    fn apply(&mut self, symbol: Option<ChargeSymbol>, shape: &SymbolShape) -> Result<SymbolReadings, PortError> {
        let parts = symbol.map_or([(0.0, 0.0), (0.0, shape.symbol_time_s)], |symbol| shape.parts(symbol));
        let mut readings = [None; 2];
        for (place, ((bias_v, time_s), reading)) in parts.into_iter().zip(&mut readings).enumerate() {
            self.hold(bias_v, time_s);
            *reading = self.read(bias_v);
            let now = DeviceTruth { shift_v: self.shift_v(), offset_f: self.offset_f() };
            self.truth = match place {
                0 => now,
                _ => DeviceTruth { shift_v: 0.5 * (self.truth.shift_v + now.shift_v), ..self.truth },
            };
        }
        Ok(readings)
    }

    fn release(&mut self) -> Result<(), PortError> {
        Ok(())
    }

    fn truth(&self) -> Option<DeviceTruth> {
        Some(self.truth)
    }
}

#[cfg(test)]
mod tests;
