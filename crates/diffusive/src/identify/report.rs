//! What an identification reports: the model, what was decided before it, and where it was written.

use std::fmt::{self, Display, Formatter};
use std::path::Path;

use recording::text::{brief, estimate, short};
use serde::Serialize;

use super::drift::DriftKind;
use crate::model::certainty::steady_gain_error;
use crate::model::{Class, Model, ModelGas, ModelOutput, ModelWind, OutputDrift, Pair, gain_unit};

/// Tables of resistances that are read; more than that are a file's matter.
const MOST_TABLES: usize = 6;

/// A model for people, by `Display`: resistances with their standard errors, fit, what was chosen
/// and why. As JSON it is the model and nothing else.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(transparent)]
pub struct IdentifyReport<'a> {
    /// What was identified.
    pub model: &'a Model,
    /// What the record's reader decided by default, and what it found remarkable.
    #[serde(skip)]
    pub notes: &'a [String],
    /// The file that the model was written to.
    #[serde(skip)]
    pub written: Option<&'a Path>,
}

impl IdentifyReport<'_> {
    /// Whether the record does not support its model, or its offset may have moved, so that another
    /// one is called for.
    fn lacks(&self) -> bool {
        let has_drift = || self.model.outputs.iter().any(|output| output.drift.is_some());
        !self.model.advice.is_empty() && (!self.model.supported || has_drift())
    }
}

impl Display for IdentifyReport<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let &Self { model, notes, written } = self;
        let provenance = &model.provenance;
        writeln!(
            f,
            "{}: {} rows{}, {} s in all",
            provenance.records.join(", "),
            provenance.rows,
            spacing(model),
            brief(provenance.duration_s)
        )?;
        for note in notes {
            writeln!(f, "  {note}")?;
        }
        let tables: usize = model.pairs.iter().map(|pair| pair.classes.len()).sum();
        if tables > MOST_TABLES {
            writeln!(f, "\nsteady gains; resistances stand in the model's file, and in --json and --plot")?;
        }
        for pair in &model.pairs {
            for (label, class) in &pair.classes {
                if tables > MOST_TABLES {
                    steady_gain(f, model, pair, label, class)?;
                } else {
                    resistances(f, model, pair, label, class)?;
                }
            }
        }
        if let Some(wind) = &model.wind {
            conductances(f, model, wind)?;
        }
        writeln!(f)?;
        following(f, model)?;
        for output in &model.outputs {
            fit(f, output)?;
        }
        if let Some(error) = &model.chosen.cross_validation {
            writeln!(f, "cross-validated error: {} rms", estimate(error.value, error.se))?;
        }
        chosen(f, model)?;
        if self.lacks() {
            writeln!(f, "\nnext record:")?;
            for advice in &model.advice {
                writeln!(f, "  {advice}")?;
            }
        }
        match written {
            Some(path) => writeln!(f, "\nmodel written to {}", path.display()),
            None => Ok(()),
        }
    }
}

/// Distance of rows.
pub fn spacing(model: &Model) -> String {
    match model.provenance.uneven_times {
        true => " at uneven times".to_owned(),
        false => format!(", one each {} s", brief(model.sample_period_s)),
    }
}

/// Reasons of what was chosen, and warnings.
pub(super) fn chosen(f: &mut Formatter<'_>, model: &Model) -> fmt::Result {
    if !model.chosen.reasons.is_empty() {
        writeln!(f, "\nchosen:")?;
    }
    for reason in &model.chosen.reasons {
        writeln!(f, "  {reason}")?;
    }
    for warning in &model.warnings {
        writeln!(f, "\nwarning: {warning}")?;
    }
    Ok(())
}

fn subject(model: &Model, pair: &Pair, label: &str) -> String {
    let label = if model.classes.len() > 1 { format!(", {label}") } else { String::new() };
    format!("{} → {}{label}", pair.input, pair.output)
}

fn steady_gain(f: &mut Formatter<'_>, model: &Model, pair: &Pair, label: &str, class: &Class) -> fmt::Result {
    let gain = estimate(class.steady_gain_k_per_w, steady_gain_error(model, pair, class));
    writeln!(f, "  {:<50} {gain}", subject(model, pair, label))
}

fn resistances(f: &mut Formatter<'_>, model: &Model, pair: &Pair, label: &str, class: &Class) -> fmt::Result {
    writeln!(f, "\n{}", subject(model, pair, label))?;
    let unit = gain_unit(model, &pair.output).map_or(String::new(), |unit| format!(" {unit}"));
    writeln!(f, "  {:>11} {:>11}   R{unit} ± standard error", "rate rad/s", "1/rate s")?;
    let by = model.inflation(&pair.output);
    let rows = pair.mesh_rad_s.iter().zip(&class.r_k_per_w).zip(&class.se_k_per_w);
    for (k, ((rate, resistance), se)) in rows.enumerate() {
        let fitted = pair.se_rate_rad_s.as_ref().and_then(|se| se.get(k));
        let fitted = fitted.map_or(String::new(), |se| format!("   at {} rad/s", estimate(*rate, by * *se)));
        let resistance = estimate(*resistance, by * *se);
        writeln!(f, "  {:>11} {:>11}   {resistance}{fitted}", brief(*rate), brief(1.0 / rate))?;
    }
    if class.feed_through_k_per_w != 0.0 {
        let at_once = estimate(class.feed_through_k_per_w, by * class.se_feed_through_k_per_w);
        writeln!(f, "  {:>11} {:>11}   {at_once}", "at once", "0")?;
    }
    let gain = estimate(class.steady_gain_k_per_w, steady_gain_error(model, pair, class));
    writeln!(f, "  steady gain {gain}")
}

fn conductances(f: &mut Formatter<'_>, model: &Model, wind: &ModelWind) -> fmt::Result {
    let gas = match &wind.gas {
        ModelGas::ConstantC(gas_c) => format!("at {} °C", brief(*gas_c)),
        ModelGas::Column(name) => format!("in column `{name}`"),
        ModelGas::EstimatedC(gas) => format!("estimated to be at {} °C", estimate(gas.value, gas.se)),
    };
    writeln!(f, "\nconductance to the gas beyond class `{}`, W/K; gas {gas}", wind.reference)?;
    for (element, output) in wind.elements.iter().zip(&model.outputs) {
        let of = if model.outputs.len() > 1 { format!("  {}", output.name) } else { String::new() };
        for (label, value) in element.iter().filter(|(label, _)| **label != wind.reference) {
            writeln!(f, "  {label:<12} {}{of}", estimate(value.value, output.inflation() * value.se))?;
        }
    }
    Ok(())
}

fn following(f: &mut Formatter<'_>, model: &Model) -> fmt::Result {
    let what = model.ambient.as_ref().map_or("the gas".to_owned(), |ambient| format!("`{}`", ambient.column));
    for (followed, output) in model.following().iter().flat_map(|of| of.outputs.iter().zip(&model.outputs)) {
        let gain = estimate(followed.steady_gain_k_per_k, output.inflation() * followed.se_steady_gain_k_per_k);
        writeln!(f, "{} follows {what}, in the end by {gain} K/K", output.name)?;
    }
    Ok(())
}

fn fit(f: &mut Formatter<'_>, output: &ModelOutput) -> fmt::Result {
    write!(
        f,
        "{}: fit {:.2} %, residual {} rms, offset {}",
        output.name,
        output.fit_percent,
        brief(output.residual_rms),
        estimate(output.offset_c, output.inflation() * output.se_offset_c)
    )?;
    if let Some(verdict) = whiteness_verdict(output) {
        write!(f, "; {verdict}")?;
    }
    writeln!(f)?;
    if let Some(drift) = output.drift.as_ref().filter(|drift| !drift.is_average()) {
        writeln!(f, "  {}", moving_offset(drift))?;
    }
    let Some(ahead) = output.forecast_rms else { return Ok(()) };
    writeln!(f, "  error ahead: {} rms is to be expected of what comes after the record", short(ahead, 2))
}

/// Whether what the model leaves of an output is noise, and what that means for standard errors;
/// `None` for too few rows to tell.
pub fn whiteness_verdict(output: &ModelOutput) -> Option<String> {
    let white = output.whiteness.as_ref()?;
    Some(if white.is_white() {
        format!("residuals white (p = {:.2})", white.p_value)
    } else if output.drift.as_ref().is_some_and(OutputDrift::is_average) {
        "residuals coloured: standard errors hold how far candidates differ".to_owned()
    } else if output.inflation() == 1.0 {
        "residuals all but white".to_owned()
    } else {
        format!("residuals coloured, which makes ± {:.1} times as large", white.inflation)
    })
}

/// How an offset that is no average moves, in K of its output.
pub fn moving_offset(drift: &OutputDrift) -> String {
    let size = match drift.correlation_s {
        Some(time_s) => format!("by {} rms, and returns within {} s", short(drift.size, 2), short(time_s, 2)),
        None if drift.kind == DriftKind::RandomWalk.name() => {
            format!("as a random walk, by {} rms in an hour", short(60.0 * drift.size, 2))
        }
        None => format!("smoothly, its slope by {} an hour rms in an hour", short(3600.0 * 60.0 * drift.size, 2)),
    };
    format!(
        "the offset moves {size}; {} at the end, {} nats more evidence than for one that stands",
        short(drift.last_level_k, 2),
        short(drift.evidence_nats, 3)
    )
}
