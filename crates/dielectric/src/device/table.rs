//! The tables of a device's file, and what is checked of them.

use std::path::Path;

use serde::Deserialize;

use super::carriers::{Carriers, Polarity};
use super::content::{Device, MeterRange, Simulation};
use recording::toml_file::{FileError, TomlSource};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DeviceTable {
    name: String,
    capacitor: CapacitorTable,
    limits: LimitsTable,
    meter: MeterTable,
    simulation: Option<SimulationTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CapacitorTable {
    curvature_f_v2: f64,
    offset_f: f64,
    pull_in_v: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LimitsTable {
    bias_max_v: f64,
    shift_max_v: f64,
    capacitance_max_f: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MeterTable {
    full_scale_f: f64,
    #[serde(default)]
    noise_f: f64,
    #[serde(default = "megahertz")]
    frequency_hz: f64,
    #[serde(default = "tenth_of_a_volt")]
    level_v: f64,
}

const fn megahertz() -> f64 {
    1e6
}

const fn tenth_of_a_volt() -> f64 {
    0.1
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SimulationTable {
    #[serde(default = "room_c")]
    temperature_c: f64,
    #[serde(default)]
    humidity_percent: f64,
    #[serde(default)]
    offset_per_k: f64,
    #[serde(default)]
    offset_per_percent: f64,
    #[serde(default)]
    offset_per_hour: f64,
    #[serde(default)]
    charging_per_k: f64,
    carriers: Vec<CarriersTable>,
}

const fn room_c() -> f64 {
    20.0
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CarriersTable {
    polarity: Polarity,
    steady_shift_v: f64,
    at_bias_v: f64,
    scale_v: f64,
    slowest_s: f64,
    fastest_s: f64,
    order: usize,
    #[serde(default)]
    slope: f64,
}

impl Device {
    /// Reads a device.
    ///
    /// # Errors
    /// File, line and what is wrong.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let source = TomlSource::read(path)?;
        source.parse::<DeviceTable>()?.checked(source)
    }
}

/// Most relaxations of a bank.
const MOST_ORDER: usize = 100;

impl DeviceTable {
    fn checked(self, source: TomlSource) -> Result<Device, FileError> {
        let Self { name, capacitor, limits, meter, simulation } = self;
        if name.is_empty() || !name.chars().all(|of| of.is_ascii_alphanumeric() || of == '-' || of == '_') {
            return Err(
                source.refuse("name", "stands in the columns of recordings: letters, digits, - and _ belong here")
            );
        }
        for (key, value, unit) in [
            ("capacitor.curvature_f_v2", capacitor.curvature_f_v2, "F/V²"),
            ("capacitor.offset_f", capacitor.offset_f, "F"),
            ("capacitor.pull_in_v", capacitor.pull_in_v, "V"),
            ("limits.bias_max_v", limits.bias_max_v, "V"),
            ("limits.shift_max_v", limits.shift_max_v, "V"),
            ("limits.capacitance_max_f", limits.capacitance_max_f, "F"),
            ("meter.full_scale_f", meter.full_scale_f, "F"),
            ("meter.frequency_hz", meter.frequency_hz, "Hz"),
            ("meter.level_v", meter.level_v, "V"),
        ] {
            source.positive(key, value, unit)?;
        }
        source.within("meter.noise_f", meter.noise_f, 0.0..=meter.full_scale_f, "F")?;
        if limits.bias_max_v >= capacitor.pull_in_v {
            let sentence = format!(
                "is {} V, but the membrane falls at `pull_in_v`, {} V: it must lie below",
                limits.bias_max_v, capacitor.pull_in_v
            );
            return Err(source.refuse("limits.bias_max_v", sentence));
        }
        let pulled_f = capacitor.offset_f + capacitor.curvature_f_v2 * capacitor.pull_in_v.powi(2);
        if meter.full_scale_f <= limits.capacitance_max_f || limits.capacitance_max_f <= capacitor.offset_f {
            let sentence = format!(
                "is {:e} F: it must lie above `offset_f`, {:e} F, and below the meter's `full_scale_f`, {:e} F; at pull-in C(V) is {pulled_f:.3e} F",
                limits.capacitance_max_f, capacitor.offset_f, meter.full_scale_f
            );
            return Err(source.refuse("limits.capacitance_max_f", sentence));
        }
        let simulation = simulation.map(|table| table.checked(&source)).transpose()?;
        let MeterTable { full_scale_f, noise_f, frequency_hz, level_v } = meter;
        Ok(Device {
            source,
            name,
            curvature_f_v2: capacitor.curvature_f_v2,
            offset_f: capacitor.offset_f,
            pull_in_v: capacitor.pull_in_v,
            bias_max_v: limits.bias_max_v,
            shift_max_v: limits.shift_max_v,
            capacitance_max_f: limits.capacitance_max_f,
            meter: MeterRange { full_scale_f, noise_f, frequency_hz, level_v },
            simulation,
        })
    }
}

impl SimulationTable {
    fn checked(self, source: &TomlSource) -> Result<Simulation, FileError> {
        let finite = |key: &str, value: f64, unit| source.within(key, value, -1e3..=1e3, unit);
        finite("simulation.temperature_c", self.temperature_c, "°C")?;
        source.within("simulation.humidity_percent", self.humidity_percent, 0.0..=100.0, "%")?;
        finite("simulation.offset_per_k", self.offset_per_k, "a kelvin")?;
        finite("simulation.offset_per_percent", self.offset_per_percent, "a percent")?;
        finite("simulation.offset_per_hour", self.offset_per_hour, "an hour")?;
        finite("simulation.charging_per_k", self.charging_per_k, "a kelvin")?;
        if self.carriers.is_empty() {
            return Err(
                source.refuse("simulation.carriers", "is empty: one [[simulation.carriers]] at least belongs here")
            );
        }
        let carriers = self.carriers.iter().enumerate();
        let carriers = carriers.map(|(i, table)| table.checked(source, &format!("simulation.carriers[{i}]")));
        Ok(Simulation {
            temperature_c: self.temperature_c,
            humidity_percent: self.humidity_percent,
            offset_per: [self.offset_per_k, self.offset_per_percent, self.offset_per_hour],
            charging_per_k: self.charging_per_k,
            carriers: carriers.collect::<Result<_, _>>()?,
        })
    }
}

impl CarriersTable {
    fn checked(&self, source: &TomlSource, place: &str) -> Result<Carriers, FileError> {
        let key = |key: &str| format!("{place}.{key}");
        source.within(&key("steady_shift_v"), self.steady_shift_v, -1e3..=1e3, "V")?;
        source.positive(&key("at_bias_v"), self.at_bias_v, "V")?;
        source.positive(&key("scale_v"), self.scale_v, "V")?;
        source.positive(&key("fastest_s"), self.fastest_s, "s")?;
        source.positive(&key("slowest_s"), self.slowest_s, "s")?;
        source.within(&key("slope"), self.slope, -3.0..=3.0, "")?;
        source.within(&key("order"), self.order as f64, 1.0..=MOST_ORDER as f64, "")?;
        if self.slowest_s < self.fastest_s || (self.order > 1 && self.slowest_s == self.fastest_s) {
            let sentence = format!("is {} s: it must lie above `fastest_s`, {} s", self.slowest_s, self.fastest_s);
            return Err(source.refuse(&key("slowest_s"), sentence));
        }
        let (rates_rad_s, weights) = Carriers::bank(self.slowest_s, self.fastest_s, self.order, self.slope);
        Ok(Carriers {
            polarity: self.polarity,
            steady_shift_v: self.steady_shift_v,
            at_bias_v: self.at_bias_v,
            scale_v: self.scale_v,
            rates_rad_s,
            weights,
        })
    }
}
