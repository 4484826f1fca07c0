//! A netlist for SPICE: 1 V stands for 1 K, 1 A for 1 W, 1 Ω for 1 K/W and 1 F for 1 J/K.
//!
//! | pair | subcircuit | nodes |
//! |---|---|---|
//! | self-heating without dead time | a one-port: the power is the current into it, the rise the voltage over it | `junction ambient` |
//! | cross-heating, or with dead time | the power is measured where it enters and drives a network elsewhere | `heater temperature ambient` |
//! | in a wind of structure `conductance` | the one-port with 1/ΔG from its junction to the gas | `junction ambient gas` |
//!
//! Losses that grow with temperature are a current source of g V² W from junction to ambient, in a
//! one-port; other netlists are linear and say so.
//!
//! `ambient` is to be held at the model's offset, so that voltages are temperatures in °C. Dead
//! time is a lossless line of 1 Ω, matched at both ends.

use std::fmt::Write as _;

use super::cauer::{LadderSection, cauer, no_network};
use super::foster::{Cell, foster};
use crate::model::ModelError;
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
pub fn netlist(part: &PairClass, network: SpiceNetwork) -> Result<String, ModelError> {
    let one_port = part.is_self_heating() && part.pair.dead_time_samples == 0;
    if part.wind_w_per_k.is_some() && !one_port {
        return Err(model_error!(
            "in class `{}` the wind acts on all elements at once, and a netlist of one pair with cross-heating or dead time cannot show it: export the response",
            part.label
        ));
    }
    let name = subcircuit_name(part);
    let (nodes, heated, input, instance) = match (one_port, part.wind_w_per_k) {
        (true, None) => ("junction ambient", "junction", "t", "t amb"),
        (true, Some(_)) => ("junction ambient gas", "junction", "t", "t amb amb"),
        (false, _) => ("heater temperature ambient", "temperature", "p", "p t amb"),
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
    // Heat that is lost from a heater elsewhere depends on a temperature that a pair of its own
    // lacks.
    let loss_w_per_k2 = if one_port { part.loss_w_per_k2() } else { 0.0 };
    let warning = if loss_w_per_k2 > 0.0 { part.warning_beside_losses() } else { part.warning() };
    if let Some(warning) = warning {
        let _ = writeln!(text, "* Warning: {}", ascii(&warning));
    }
    let _ = writeln!(text, "* Try it:  Vambient amb 0 {}", spice(part.offset_c()));
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
    if loss_w_per_k2 > 0.0 {
        let g = spice(loss_w_per_k2);
        let _ = writeln!(text, "Bloss junction ambient I={g}*V(junction,ambient)*V(junction,ambient)");
    }
    let mut from = heated.to_owned();
    if part.class.feed_through_k_per_w != 0.0 {
        let _ = writeln!(text, "Rfeed {from} n0 {}", spice(part.class.feed_through_k_per_w));
        "n0".clone_into(&mut from);
    }
    let sections = sections(part, network)?;
    for (i, section) in sections.iter().enumerate() {
        let n = i + 1;
        let to = if n == sections.len() { "ambient".to_owned() } else { format!("n{n}") };
        let resistor = format!("R{n} {from} {to} {}\n", spice(section.resistance_k_per_w));
        let farad = spice(section.capacitance_j_per_k);
        text.push_str(&match network {
            SpiceNetwork::Foster => format!("{resistor}C{n} {from} {to} {farad}\n"),
            SpiceNetwork::Cauer => format!("C{n} {from} ambient {farad}\n{resistor}"),
        });
        from = to;
    }
    let _ = writeln!(text, ".ends {name}");
    Ok(text)
}

/// Resistors and capacitors from the heater outwards.
fn sections(part: &PairClass, network: SpiceNetwork) -> Result<Vec<LadderSection>, ModelError> {
    let (mesh_rad_s, r_k_per_w) = (&part.pair.mesh_rad_s, &part.class.r_k_per_w);
    if network == SpiceNetwork::Cauer {
        return cauer(mesh_rad_s, r_k_per_w);
    }
    let cells = foster(mesh_rad_s, r_k_per_w);
    refuse_if!(cells.is_empty(), no_network());
    let section = |cell: &Cell| LadderSection {
        capacitance_j_per_k: cell.capacitance_j_per_k(),
        resistance_k_per_w: cell.resistance_k_per_w,
    };
    Ok(cells.iter().map(section).collect())
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
