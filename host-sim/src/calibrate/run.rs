//! What a calibration starts from: the head as drawn, and its readings in steady, known winds.
//!
//! ```text
//! c_i (q_i + G0_i a_i) = θ_i (k A_i / d) Nu_i(r)          r = R v ρ d / µ
//! ```
//!
//! | symbol | field | meaning |
//! |---|---|---|
//! | v | `wind_m_s` | known wind, where the gas goes to, in the tunnel's frame |
//! | ρ, µ, k | `gas` | properties of the gas during the reading |
//! | q_i | `power_w` | convective power of part i beyond that of still gas at the reference, as the windless observer sees it |
//! | θ_i | `overheat_k` | surface over gas, now |
//! | a_i | `above_reference_k` | surface over the gas temperature of the windless identification |
//!
//! Readings that cannot be meant are refused here by the label of their wind; whether the winds are well spread is for
//! [`spread`](super::spread).

use dr_core::sensor::wind::{Gas, Part, PartConfig};

use super::CalibrateError;

/// Reynolds numbers that a calibration takes; those of dr-core's amplitudes are wider.
const REYNOLDS: std::ops::RangeInclusive<f64> = 1e-2..=1e5;

/// A head as drawn: its parts in its own frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Head {
    pub diameter_m: f64,
    pub parts: Vec<HeadPart>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct HeadPart {
    /// As the user knows it, such as `sector3`.
    pub name: String,
    pub config: PartConfig,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GasProperties {
    pub density_kg_m3: f64,
    pub viscosity_pa_s: f64,
    pub conductivity_w_m_k: f64,
}

/// One steady wind.
#[derive(Debug, Clone, PartialEq)]
pub struct Steady {
    pub label: String,
    /// Where the gas goes to, m/s, in the tunnel's frame; zero for still gas.
    pub wind_m_s: [f64; 3],
    pub gas: GasProperties,
    /// In the head's order.
    pub parts: Vec<PartReading>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartReading {
    pub power_w: f64,
    pub overheat_k: f64,
    pub above_reference_k: f64,
    /// Of the mean of `power_w`, W².
    pub variance_w2: f64,
}

impl GasProperties {
    /// As dr-core takes it.
    ///
    /// # Errors
    /// Names the property that no gas has.
    pub fn core(&self) -> Result<Gas, dr_core::ConfigError> {
        Gas::new(self.density_kg_m3 as f32, self.viscosity_pa_s as f32, self.conductivity_w_m_k as f32)
    }
}

/// The head, checked.
#[derive(Debug, Clone)]
pub struct Ready {
    pub diameter_m: f64,
    pub names: Vec<String>,
    pub parts: Vec<Part>,
}

/// One wind, checked, in the numbers that the model takes.
#[derive(Debug, Clone)]
pub struct Wind {
    pub label: String,
    /// Place among the readings that were given.
    pub given: usize,
    pub speed_m_s: f64,
    /// Re; zero in still gas.
    pub reynolds: f64,
    /// v/|v|; zero in still gas.
    pub towards: [f64; 3],
    /// One a part.
    pub rows: Vec<Row>,
}

#[derive(Debug, Clone, Copy)]
pub struct Row {
    pub power_w: f64,
    pub error_w: f64,
    /// k A / d: conductance at a Nusselt number of one, W/K.
    pub unit_w_k: f64,
    pub overheat_k: f64,
    pub above_reference_k: f64,
}

impl Wind {
    pub fn is_still(&self) -> bool {
        self.reynolds == 0.0
    }
}

/// # Errors
/// Names the part whose geometry is not one.
pub fn ready(head: &Head) -> Result<Ready, CalibrateError> {
    if !(head.diameter_m.is_finite() && head.diameter_m > 0.0) {
        let sentence = format!("the diameter is {} m; it must be a positive length", head.diameter_m);
        return Err(CalibrateError::Head(sentence));
    }
    if head.parts.len() < 2 {
        let sentence = format!("{} parts are given; a head that tells a direction has at least two", head.parts.len());
        return Err(CalibrateError::Head(sentence));
    }
    let parts = head
        .parts
        .iter()
        .map(|part| Part::new(&part.config).map_err(|error| CalibrateError::Head(format!("{}: {error}", part.name))));
    Ok(Ready {
        diameter_m: head.diameter_m,
        names: head.parts.iter().map(|part| part.name.clone()).collect(),
        parts: parts.collect::<Result<_, _>>()?,
    })
}

/// # Errors
/// The label of the first wind that cannot be meant, and why.
pub fn winds(head: &Ready, steady: &[Steady]) -> Result<Vec<Wind>, CalibrateError> {
    steady
        .iter()
        .enumerate()
        .map(|(given, steady)| {
            wind(head, given, steady)
                .map_err(|sentence| CalibrateError::Reading { label: steady.label.clone(), sentence })
        })
        .collect()
}

fn wind(head: &Ready, given: usize, steady: &Steady) -> Result<Wind, String> {
    if steady.parts.len() != head.parts.len() {
        return Err(format!("{} parts were read, but the head has {}", steady.parts.len(), head.parts.len()));
    }
    if let Some(bad) = steady.wind_m_s.iter().find(|v| !v.is_finite()) {
        return Err(format!("a component of the wind is {bad}; it must be a number in m/s"));
    }
    let gas = steady.gas.core().map_err(|error| format!("gas: {error}"))?;
    let diameter_m = head.diameter_m as f32;
    let speed_m_s = steady.wind_m_s.iter().map(|v| v * v).sum::<f64>().sqrt();
    let reynolds = speed_m_s * f64::from(gas.reynolds_per_speed(diameter_m));
    if speed_m_s > 0.0 && !REYNOLDS.contains(&reynolds) {
        return Err(format!(
            "{speed_m_s} m/s make a Reynolds number of {reynolds:.3e}; it must lie within {:e} and {:e}, or the wind be zero",
            REYNOLDS.start(),
            REYNOLDS.end()
        ));
    }
    let rows = steady.parts.iter().zip(head.names.iter().zip(&head.parts)).map(|(reading, (name, part))| {
        check(reading).map_err(|sentence| format!("{name}: {sentence}"))?;
        Ok(Row {
            power_w: reading.power_w,
            error_w: reading.variance_w2.sqrt(),
            unit_w_k: f64::from(gas.conductance_per_nusselt_w_k(diameter_m, part.area_m2())),
            overheat_k: reading.overheat_k,
            above_reference_k: reading.above_reference_k,
        })
    });
    let towards = if speed_m_s > 0.0 { steady.wind_m_s.map(|v| v / speed_m_s) } else { [0.0; 3] };
    let rows = rows.collect::<Result<_, String>>()?;
    Ok(Wind { label: steady.label.clone(), given, speed_m_s, reynolds, towards, rows })
}

fn check(reading: &PartReading) -> Result<(), String> {
    for (name, value) in [("power_w", reading.power_w), ("above_reference_k", reading.above_reference_k)] {
        if !value.is_finite() {
            return Err(format!("`{name}` is {value}; it must be a number"));
        }
    }
    for (name, value) in [("overheat_k", reading.overheat_k), ("variance_w2", reading.variance_w2)] {
        if !(value.is_finite() && value > 0.0) {
            return Err(format!("`{name}` is {value}; it must be a number greater than zero"));
        }
    }
    Ok(())
}
