//! An identified quiescent-gas network as text and as JSON: self-heating with its layers, and
//! steady gains of all pairs.

use std::fmt;
use std::path::PathBuf;

use diffusive::model::{Model, Pair};
use recording::text::count;
use recording::{POWER, TEMPERATURE};
use serde::Serialize;

use super::from_model::{LadderSection, contact_time_s};
use super::parameters::{QuiescentNetwork, SelfHeatingParameters};

/// Explains the lines of the elements.
const LEGEND: &str = "\n\
    rad/s and K/W: rates of an element's self-heating and the resistance of each; surface: temperature of the surface over\n\
    the element's in that relaxation, negative where it is too fast for the layers between them\n";
/// Overheat to which the disagreement of records is compared, K.
const TYPICAL_OVERHEAT_K: f64 = 30.0;

/// Summary of `anemo head identify`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NetworkReport {
    /// Elements of the head's network; empty where none can be made of the model.
    pub elements: Vec<NetworkElementReport>,
    /// All pairs of the model.
    pub pairs: Vec<PairReport>,
    /// All temperatures of the model.
    pub outputs: Vec<OutputReport>,
    /// Why each pair has so many rates.
    pub reasons: Vec<String>,
    /// Warnings about the network.
    pub warnings: Vec<String>,
    /// Nothing is wrong.
    pub supported: bool,
    /// The file that was written.
    #[serde(skip)]
    pub written: Option<PathBuf>,
    /// Records, their rows, and how long they are in all, s.
    #[serde(skip)]
    data: (usize, u64, f64),
    /// Columns of power, in the model's order.
    #[serde(skip)]
    inputs: Vec<String>,
}

/// Self-heating of an element.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NetworkElementReport {
    /// Name of the element.
    pub name: String,
    /// Temperature with no heating at all, °C.
    pub rest_c: f64,
    /// Rates, ascending.
    pub mesh_rad_s: Vec<f64>,
    /// Resistance of each.
    pub r_k_per_w: Vec<f64>,
    /// Share of each that the surface takes part in; `None` for an element that no wind cools.
    pub surface: Option<Vec<f64>>,
    /// Layers between the element and its surface.
    pub layers: Vec<LadderSection>,
    /// By how much the surface lags behind the element, s.
    pub contact_time_s: f64,
    /// Standard deviation of a reading at the low level, K.
    pub noise_low_k: f64,
    /// Standard deviation of a reading at the high level, K.
    pub noise_high_k: f64,
}

/// Heating of one temperature by one power.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PairReport {
    /// Column of the power.
    pub input: String,
    /// Column of the temperature.
    pub output: String,
    /// Number of rates.
    pub rates: usize,
    /// Sum of the resistances, K/W.
    pub steady_gain_k_per_w: f64,
}

/// A temperature of the model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OutputReport {
    /// Column of the temperature.
    pub name: String,
    /// Temperature with no heating at all, °C.
    pub offset_c: f64,
    /// Residuals of readings at the low level, K rms.
    pub residual_rms: f64,
    /// Amount by which the records disagree about the offset, K.
    #[serde(skip)]
    apart_k: f64,
}

impl NetworkReport {
    /// Report of a model, and of the head's network where it makes one.
    pub fn new(model: &Model, network: Option<&QuiescentNetwork>) -> Self {
        let own = network.map_or(&[][..], |network| &network.own);
        let element = |own: &SelfHeatingParameters| NetworkElementReport {
            name: own.name.clone(),
            rest_c: own.rest_c,
            mesh_rad_s: own.mesh_rad_s.clone(),
            r_k_per_w: own.r_k_per_w.clone(),
            surface: own.surface.clone(),
            layers: own.layers.clone(),
            contact_time_s: contact_time_s(&own.layers),
            noise_low_k: own.noise.low_k,
            noise_high_k: own.noise.high_k,
        };
        let pair = |pair: &Pair| PairReport {
            input: pair.input.clone(),
            output: pair.output.clone(),
            rates: pair.mesh_rad_s.len(),
            steady_gain_k_per_w: pair.classes.values().next().map_or(0.0, |class| class.steady_gain_k_per_w),
        };
        let output = |output: &diffusive::model::ModelOutput| OutputReport {
            name: output.name.clone(),
            offset_c: output.offset_c,
            residual_rms: output.residual_rms,
            apart_k: output.se_offset_c,
        };
        let provenance = &model.provenance;
        Self {
            elements: own.iter().map(element).collect(),
            pairs: model.pairs.iter().map(pair).collect(),
            outputs: model.outputs.iter().map(output).collect(),
            reasons: model.chosen.reasons.clone(),
            warnings: model.warnings.clone(),
            supported: model.supported,
            written: None,
            data: (provenance.records.len(), provenance.rows, provenance.duration_s),
            inputs: model.inputs.clone(),
        }
    }

    /// Steady gains: one line for each power, one column for each temperature.
    fn gains(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "\nsteady gains in K/W: a line heats, a column becomes warm")?;
        write!(f, "{:<14}", "")?;
        for output in &self.outputs {
            write!(f, " {:>12}", output.element())?;
        }
        writeln!(f)?;
        for input in &self.inputs {
            write!(f, "{:<14}", input.strip_prefix(POWER).unwrap_or(input))?;
            for output in &self.outputs {
                let pair = self.pairs.iter().find(|pair| pair.input == *input && pair.output == output.name);
                write!(f, " {:>12.4}", pair.map_or(0.0, |pair| pair.steady_gain_k_per_w))?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}

impl OutputReport {
    fn element(&self) -> &str {
        self.name.strip_prefix(TEMPERATURE).unwrap_or(&self.name)
    }
}

impl fmt::Display for NetworkReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (records, rows, duration_s) = self.data;
        writeln!(f, "{}, {rows} rows, {duration_s:.0} s in all", count(records, "record"))?;
        self.elements.iter().try_for_each(|element| element.fmt(f))?;
        if !self.elements.is_empty() {
            f.write_str(LEGEND)?;
        }
        self.gains(f)?;
        writeln!(f, "\nelement        without heat  apart by record  left at low level")?;
        for output in &self.outputs {
            let [apart_mk, left_mk] = [output.apart_k, output.residual_rms].map(|kelvin| 1e3 * kelvin);
            let (element, offset_c) = (output.element(), output.offset_c);
            writeln!(f, "{element:<14} {offset_c:>9.4} °C {apart_mk:>13.2} mK {left_mk:>15.3} mK")?;
        }
        // A part of the head that is not linear, and so is missing from the network.
        let worst = self.outputs.iter().max_by(|a, b| a.apart_k.total_cmp(&b.apart_k));
        if let Some(worst) = worst.filter(|output| output.apart_k > 0.0) {
            let (apart_mk, percent) = (1e3 * worst.apart_k, 100.0 * worst.apart_k / TYPICAL_OVERHEAT_K);
            write!(f, "records disagree by up to {apart_mk:.2} mK, {}: ", worst.element())?;
            writeln!(f, "{percent:.3} % of {TYPICAL_OVERHEAT_K} K of overheat")?;
        }
        writeln!(f, "\nchosen:")?;
        self.reasons.iter().try_for_each(|reason| writeln!(f, "  {reason}"))?;
        self.warnings.iter().try_for_each(|warning| writeln!(f, "\nwarning: {warning}"))?;
        self.written.iter().try_for_each(|path| writeln!(f, "\nnetwork written to {}", path.display()))
    }
}

impl fmt::Display for NetworkElementReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, mesh_rad_s, r_k_per_w, surface, layers, .. } = self;
        writeln!(f, "\n{name}")?;
        for (k, (rate, r)) in mesh_rad_s.iter().zip(r_k_per_w).enumerate() {
            let share = surface.as_ref().map_or(String::new(), |surface| format!("   surface {:.4}", surface[k]));
            writeln!(f, "  {rate:>10.5} rad/s {r:>10.4} K/W{share}")?;
        }
        for section in layers {
            let (c, r) = (1e3 * section.capacitance_j_per_k, section.resistance_k_per_w);
            writeln!(f, "  layer of {c:.3} mJ/K, {r:.3} K/W to the next")?;
        }
        if !layers.is_empty() {
            writeln!(f, "  its surface lags behind it by {:.4} s", self.contact_time_s)?;
        }
        Ok(())
    }
}
