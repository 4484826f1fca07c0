//! A netlist for SPICE: 1 V stands for 1 K, 1 A for 1 W, 1 Ω for 1 K/W and 1 F for 1 J/K.
//!
//! | pair | subcircuit | nodes |
//! |---|---|---|
//! | self-heating without dead time | a one-port: the power is the current into it, the rise the voltage over it | `junction ambient` |
//! | cross-heating, or with dead time | the power is measured where it enters and drives a network elsewhere | `heater temperature ambient` |
//! | in a wind of structure `conductance` | the one-port with 1/ΔG from its junction to the gas | `junction ambient gas` |
//!
//! `ambient` is to be held at the model's offset, so that voltages are temperatures in °C. Dead
//! time is a lossless line of 1 Ω, matched at both ends.

use std::fmt::Write as _;

use super::error::ExportError;
use super::{cauer, foster};
use crate::model::pair_class::{PairClass, element};

/// The network that a netlist holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpiceNetwork {
    /// Resistor and capacitor side by side, in series: any model.
    Foster,
    /// A ladder: models without negative resistances.
    Cauer,
}

/// The netlist of one pair: a subcircuit, with a way to try it in its comments.
///
/// # Errors
/// If the pair has no such network.
pub fn netlist(part: &PairClass, network: SpiceNetwork) -> Result<String, ExportError> {
    let one_port = part.is_self_heating() && part.pair.dead_time_samples == 0;
    refuse_if!(part.wind_w_per_k.is_some() && !one_port, ExportError::WindOnAll(part.label.to_owned()));
    let name = subcircuit_name(part);
    let (nodes, heated) = match (one_port, part.wind_w_per_k) {
        (true, None) => ("junction ambient", "junction"),
        (true, Some(_)) => ("junction ambient gas", "junction"),
        (false, _) => ("heater temperature ambient", "temperature"),
    };
    let mut text = format!(
        "* {} -> {}, class {}: thermal model by anemo\n\
         * 1 V is 1 K, 1 A is 1 W, 1 ohm is 1 K/W, 1 F is 1 J/K\n\
         * Steady gain {} K/W{}. Hold `ambient` at {} V to read degrees Celsius.\n",
        ascii(&part.pair.input),
        ascii(&part.pair.output),
        ascii(part.label),
        spice(part.class.steady_gain_k_per_w),
        if part.wind_w_per_k.is_some() { " without the conductance to the gas" } else { "" },
        spice(part.offset_c()),
    );
    if let Some(warning) = part.warning() {
        let _ = writeln!(text, "* Warning: {}", ascii(&warning));
    }
    let _ = writeln!(text, "* Try it:  Vambient amb 0 {}", spice(part.offset_c()));
    let (input, instance) = match (one_port, part.wind_w_per_k) {
        (true, None) => ("t", "t amb"),
        (true, Some(_)) => ("t", "t amb amb"),
        (false, _) => ("p", "p t amb"),
    };
    let _ = writeln!(text, "*          Iheat 0 {input} 1\n*          Xmodel {instance} {name}");
    let slowest = part.pair.mesh_rad_s.first().map_or(1.0, |rate| 5.0 / rate);
    let _ = writeln!(
        text,
        "*          .tran {} {} uic\n*          .print tran v(t)\n",
        spice(slowest / 500.0),
        spice(slowest)
    );
    let _ = writeln!(text, ".subckt {name} {nodes}");
    if !one_port {
        text.push_str("Vheater heater ambient 0\n");
        if part.pair.dead_time_samples > 0 {
            text.push_str("Fsent ambient sent Vheater 1\nRsent sent ambient 1\n");
            let _ = writeln!(text, "Tdead sent ambient late ambient Z0=1 TD={}", spice(part.dead_time_s()));
            text.push_str("Rlate late ambient 1\nGheat ambient temperature late ambient 2\n");
        } else {
            text.push_str("Fheat ambient temperature Vheater 1\n");
        }
    }
    if let Some(conductance) = part.wind_w_per_k.filter(|conductance| *conductance != 0.0) {
        let _ = writeln!(text, "Rwind junction gas {}", spice(1.0 / conductance));
    }
    let mut from = heated.to_owned();
    if part.class.feed_through_k_per_w != 0.0 {
        let _ = writeln!(text, "Rfeed {from} n0 {}", spice(part.class.feed_through_k_per_w));
        "n0".clone_into(&mut from);
    }
    match network {
        SpiceNetwork::Foster => foster_cells(part, &mut text, from)?,
        SpiceNetwork::Cauer => cauer_sections(part, &mut text, from)?,
    }
    let _ = writeln!(text, ".ends {name}");
    Ok(text)
}

fn foster_cells(part: &PairClass, text: &mut String, mut from: String) -> Result<(), ExportError> {
    let cells = foster::foster(&part.pair.mesh_rad_s, &part.class.r_k_per_w);
    refuse_if!(cells.is_empty(), ExportError::Nothing);
    for (i, cell) in cells.iter().enumerate() {
        let to = if i + 1 == cells.len() { "ambient".to_owned() } else { format!("n{}", i + 1) };
        let n = i + 1;
        let _ = writeln!(text, "R{n} {from} {to} {}", spice(cell.resistance_k_per_w));
        let _ = writeln!(text, "C{n} {from} {to} {}", spice(cell.capacitance_j_per_k()));
        from = to;
    }
    Ok(())
}

fn cauer_sections(part: &PairClass, text: &mut String, mut from: String) -> Result<(), ExportError> {
    let ladder = cauer::cauer(&part.pair.mesh_rad_s, &part.class.r_k_per_w)?;
    let sections = ladder.resistance_k_per_w.len();
    for (i, (resistance, capacitance)) in ladder.resistance_k_per_w.iter().zip(&ladder.capacitance_j_per_k).enumerate()
    {
        let to = if i + 1 == sections { "ambient".to_owned() } else { format!("n{}", i + 1) };
        let n = i + 1;
        let _ = writeln!(text, "C{n} {from} ambient {}", spice(*capacitance));
        let _ = writeln!(text, "R{n} {from} {to} {}", spice(*resistance));
        from = to;
    }
    Ok(())
}

/// Always with an exponent: SPICE takes letters behind a number for factors.
fn spice(value: f64) -> String {
    format!("{value:e}")
}

fn ascii(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_graphic() || c == ' ' { c } else { '_' }).collect()
}

fn subcircuit_name(part: &PairClass) -> String {
    let mut words = vec!["thermal", element(&part.pair.input)];
    if !part.is_self_heating() {
        words.push(element(&part.pair.output));
    }
    if part.model.classes.len() > 1 {
        words.push(part.label);
    }
    words.join("_").chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
}

#[cfg(test)]
mod tests;
