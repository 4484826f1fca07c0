//! Report of the wind estimates of a recording, as text and as JSON.

use std::fmt;
use std::path::PathBuf;

use recording::text::{count, tidy};
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use super::comparison::WindComparison;
use super::field_correction::SlowErrorReport;
use super::gas_input::GasInput;
use super::tally::{EstimateSummary, UnknownHeat};

use crate::head::calibration::commands::WindOutput;

/// Summary of `anemo wind`.
#[derive(Debug, Clone, PartialEq)]
pub struct WindReport {
    /// The recording.
    pub recording: PathBuf,
    /// Name of the head.
    pub head: String,
    /// Recordings and cross-validation of its calibration, in words.
    pub made_from: String,
    /// That corrections of the head are applied, in words, if it carries any.
    pub correction: Option<String>,
    /// It outputs the wind in a plane only.
    pub in_plane: bool,
    /// Number of all estimates.
    pub estimates: u64,
    /// Bandwidth and interval.
    pub output: WindOutput,
    /// Why the bandwidth stays fixed although it was to rise after a jump of the wind.
    pub fixed_because: Option<String>,
    /// The gas, with its source.
    pub gas: GasInput,
    /// Warnings about the recording: gas, labels of winds.
    pub warnings: Vec<String>,
    /// Elements of the network that stayed at one level, as no loop does.
    pub at_one_level: Vec<String>,
    /// Number of gaps of the recording.
    pub gaps: u64,
    /// Length of all gaps, s.
    pub missing_s: f64,
    /// Estimates before do not count, s.
    pub from_s: f64,
    /// Left out at the beginning of every label, s.
    pub settle_s: f64,
    /// Statistics of the estimates that count.
    pub counted: EstimateSummary,
    /// Heat of elements without a surface on ways that the identification did not have.
    pub unknown_heat: Vec<UnknownHeat>,
    /// Slow errors that were corrected, or would explain contradictions.
    pub slow_errors: Option<SlowErrorReport>,
    /// The same compared with the true wind, if any of it is known.
    pub comparison: Option<WindComparison>,
    /// Files that were written.
    pub written: Vec<PathBuf>,
}

impl Serialize for WindReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (counted, none) = (&self.counted, WindComparison::default());
        let errors = self.comparison.as_ref().unwrap_or(&none);
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("head", &self.head)?;
        map.serialize_entry("estimates", &self.estimates)?;
        map.serialize_entry("bandwidth_hz", &self.output.bandwidth_hz)?;
        map.serialize_entry("fixed", &self.output.fixed)?;
        map.serialize_entry("output_interval_s", &self.output.interval_s)?;
        map.serialize_entry("gas", &self.gas)?;
        map.serialize_entry("correction", &self.correction)?;
        map.serialize_entry("warnings", &self.warnings)?;
        map.serialize_entry("gaps", &self.gaps)?;
        map.serialize_entry("missing_s", &self.missing_s)?;
        map.serialize_entry("counted", &counted.estimates)?;
        map.serialize_entry("quality_flags", &counted.quality_flags)?;
        map.serialize_entry("mean_speed_m_s", &counted.mean_speed_m_s)?;
        map.serialize_entry("speed_error_m_s", &counted.speed_error_m_s)?;
        map.serialize_entry("speed_standard_error", &counted.speed_standard_error)?;
        map.serialize_entry("direction_standard_error_deg", &counted.direction_standard_error_deg)?;
        map.serialize_entry("unknown_heat", &self.unknown_heat)?;
        map.serialize_entry("slow_errors", &self.slow_errors)?;
        map.serialize_entry("compared", &errors.count)?;
        map.serialize_entry("failed", &errors.failed)?;
        map.serialize_entry("without_direction", &errors.no_direction)?;
        map.serialize_entry("speed_rms_error", &errors.speed.rms())?;
        map.serialize_entry("speed_bias", &errors.speed.mean())?;
        map.serialize_entry("speed_worst_error", &errors.speed.worst())?;
        map.serialize_entry("direction_rms_error_deg", &errors.direction_deg.rms())?;
        map.serialize_entry("direction_worst_error_deg", &errors.direction_deg.worst())?;
        map.serialize_entry("speed_coverage", &errors.speed_coverage.share())?;
        map.serialize_entry("direction_coverage", &errors.direction_coverage.share())?;
        map.serialize_entry("linear_direction_rms_error_deg", &errors.linear_deg.rms())?;
        map.end()
    }
}

impl fmt::Display for WindReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let WindOutput { bandwidth_hz, interval_s, fixed } = self.output;
        writeln!(f, "{} · head {} · {}", self.recording.display(), self.head, self.made_from)?;
        writeln!(f, "gas: {}", self.gas)?;
        let fixed = if fixed { ", fixed" } else { "" };
        let estimates = count(self.estimates as usize, "wind estimate");
        writeln!(f, "{estimates}, one each {interval_s} s, bandwidth {bandwidth_hz} Hz{fixed}")?;
        self.fixed_because.iter().try_for_each(|why| writeln!(f, "the bandwidth stays fixed for {why}"))?;
        self.correction.iter().try_for_each(|correction| writeln!(f, "{correction}"))?;
        self.warnings.iter().try_for_each(|warning| writeln!(f, "warning: {warning}"))?;
        if self.gaps > 0 {
            let (gaps, missing_s) = (count(self.gaps as usize, "gap"), tidy(self.missing_s));
            write!(f, "{gaps} in the recording, {missing_s} s in all: ")?;
            writeln!(f, "for ten times as long after each, estimates are flagged `starting`")?;
        }
        self.counting(f)?;
        self.quality(f)?;
        self.slow_errors.iter().try_for_each(|slow_errors| write!(f, "{slow_errors}"))?;
        if let Some(comparison) = &self.comparison {
            compared(f, comparison, self.in_plane)?;
        }
        self.written.iter().try_for_each(|path| writeln!(f, "\nwritten to {}", path.display()))
    }
}

impl WindReport {
    /// Estimates that count, and how noisy they are.
    fn counting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut which = Vec::new();
        if self.from_s > 0.0 {
            which.push(format!("from {} s on", self.from_s));
        }
        if self.settle_s > 0.0 {
            which.push(format!("{} s after every change of label", self.settle_s));
        }
        match self.counted.estimates {
            _ if which.is_empty() => {}
            0 => writeln!(f, "none of them counts: {}", which.join(", "))?,
            1 => writeln!(f, "1 of them counts: {}", which.join(", "))?,
            number => writeln!(f, "{number} of them count: {}", which.join(", "))?,
        }
        if let Some(error) = self.counted.speed_standard_error {
            write!(f, "standard uncertainty, median: speed {:.2} %", 100.0 * error)?;
            if let Some(error_deg) = self.counted.direction_standard_error_deg {
                write!(f, ", direction {error_deg:.2}°")?;
            }
            writeln!(f)?;
        }
        if !self.unknown_heat.is_empty() {
            let each: Vec<String> = self.unknown_heat.iter().map(ToString::to_string).collect();
            writeln!(f, "heat from the support or by the stem, beyond the identification's: {}", each.join(", "))?;
        }
        Ok(())
    }

    fn quality(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let EstimateSummary { estimates, quality_flags, .. } = &self.counted;
        if *estimates > 0 && quality_flags.is_empty() {
            writeln!(f, "no quality flags")?;
        }
        for (name, number) in quality_flags {
            let share = *number as f64 / *estimates as f64;
            writeln!(f, "{name:<13} {}, {:.1} %", count(*number as usize, "estimate"), 100.0 * share)?;
        }
        if quality_flags.contains_key("saturated") && !self.at_one_level.is_empty() {
            let (names, stay, hold) = match &self.at_one_level[..] {
                [one] => (format!("`{one}`"), "stays", "it"),
                several => (format!("`{}`", several.join("`, `")), "stay", "them"),
            };
            let hold = format!("no loop holds {hold}, hence `saturated`");
            writeln!(f, "{names} {stay} at one level, as at constant current: {hold}")?;
        }
        Ok(())
    }
}

/// Errors of the estimates that count.
fn compared(f: &mut fmt::Formatter<'_>, errors: &WindComparison, in_plane: bool) -> fmt::Result {
    if errors.count == 0 {
        return writeln!(f, "\ncompared with the true wind: no estimates to compare");
    }
    write!(f, "\ncompared with the true wind, {}", count(errors.count as usize, "estimate"))?;
    if errors.failed > 0 {
        write!(f, ", {} of them without a wind", errors.failed)?;
    }
    writeln!(f)?;
    if let (Some(rms), Some(bias), Some(worst)) = (errors.speed.rms(), errors.speed.mean(), errors.speed.worst()) {
        let [rms, bias, worst] = [rms, bias, worst].map(|share| format!("{:.2} %", 100.0 * share));
        writeln!(f, "  speed      {rms} rms, {bias} mean, {worst} at worst")?;
    }
    if let (Some(rms), Some(worst)) = (errors.direction_deg.rms(), errors.direction_deg.worst()) {
        write!(f, "  direction  {rms:.2}° rms, {worst:.2}° at worst")?;
        if in_plane {
            write!(f, ", in the plane that the head determines")?;
        } else if let Some(linear) = errors.linear_deg.rms() {
            write!(f, "; linear inverse {linear:.2}° rms")?;
        }
        writeln!(f)?;
    }
    let held = [("direction", errors.direction_coverage), ("speed", errors.speed_coverage)].into_iter();
    let held = held.filter_map(|(name, of)| Some(format!("{name} {:.1} %", 100.0 * of.share()?)));
    let held: Vec<String> = held.collect();
    if !held.is_empty() {
        writeln!(f, "  95 % intervals of estimates without a flag hold: {}", held.join(", "))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Compared<'a>(&'a WindComparison);

    impl fmt::Display for Compared<'_> {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            compared(f, self.0, false)
        }
    }

    #[test]
    fn what_was_not_compared_is_not_shown_as_perfect() {
        let text = |errors: &WindComparison| Compared(errors).to_string();
        assert_eq!(text(&WindComparison::default()), "\ncompared with the true wind: no estimates to compare\n");
        // One axis: a speed, and no direction.
        let mut errors = WindComparison::default();
        let mut estimate = super::super::comparison::tests::estimate([0.0, 2.2, 0.0]);
        estimate.quality_flags = dr_core::wind::QualityFlags::UNDETERMINED;
        errors.add(&estimate, &[[0.0, 1.0, 0.0]; 2], [0.0, 2.0, 0.0]);
        assert_eq!(
            text(&errors),
            "\ncompared with the true wind, 1 estimate\n  speed      10.00 % rms, 10.00 % mean, 10.00 % at worst\n  95 % \
             intervals of estimates without a flag hold: speed 0.0 %\n"
        );
        let mut failed = WindComparison::default();
        estimate.quality_flags = dr_core::wind::QualityFlags::FAILED;
        failed.add(&estimate, &[], [0.0, 2.0, 0.0]);
        assert!(text(&failed).ends_with("1 estimate, 1 of them without a wind\n"));
    }
}
