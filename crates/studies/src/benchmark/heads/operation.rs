//! The experiments of a folder in another operating mode.

use dr_core::sensor::Level;
use host_sim::experiment::Experiment;

use crate::benchmark::modes::OperatingMode;
use crate::thesis::{StudyError, StudyLab};
use recording::text::short;

/// Of the power that holds the overheat in quiescent gas: no element becomes as warm as there.
const SHARE: f64 = 0.9;

/// An experiment of a lab with its elements in a mode; for other modes than constant temperature
/// with the power that its identification had on average, which quiescent gas bears.
///
/// # Errors
/// If an experiment cannot be read.
pub fn experiment(
    lab: &StudyLab,
    name: &str,
    elements: &[&str],
    mode: OperatingMode,
) -> Result<Experiment, StudyError> {
    let known = lab.experiment(name)?;
    if mode == OperatingMode::Cta {
        return Ok(known);
    }
    let (mut currents, mut drives) = ("[currents]\n".to_owned(), "[drives]\n".to_owned());
    for element in elements {
        let identification = lab.experiment(&format!("identify-{element}"))?;
        let of = identification.head.elements.iter().find(|of| of.name == *element);
        let of = of.ok_or_else(|| StudyError::Other(format!("{element}: is no element of the head")))?;
        let mean_w = 0.5 * SHARE * of.power_w(known.gas_temperature_c, Level::High);
        let high_a = of.nominal.current_high_a * (0.5 * SHARE).sqrt();
        if mode == OperatingMode::Cca {
            // Constant current has no use for its low level, but the two must differ.
            let low_a = of.nominal.current_low_a.min(0.5 * high_a);
            currents += &format!("{element} = {{ low_a = {}, high_a = {} }}\n", short(low_a, 4), short(high_a, 4));
            drives += &format!("{element} = {{ level = \"high\" }}\n");
        } else {
            drives += &format!("{element} = {{ power_w = {} }}\n", short(mean_w, 4));
        }
    }
    let mut source = known.source.clone();
    let table = |text: &str, heading: &str| text.find(heading).unwrap_or(text.len());
    let from = table(&source.text, "[drives]");
    let to = from + table(source.text.get(from..).unwrap_or_default(), "\n[sweep]");
    let own = if mode == OperatingMode::Cca { format!("{currents}\n{drives}") } else { drives };
    source.text.replace_range(from..to, &own);
    Ok(Experiment::from_source(source)?)
}
