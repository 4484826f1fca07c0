//! A calibration on its way to the end of a head file: just made, with its day, with corrections of
//! slow errors, or with a scale of its speed.
//!
//! A calibration ages by a scale of its speed. Curves over Reynolds numbers that all grow by a factor
//! give the same conductances at speeds that are greater by it: the head then reports each speed
//! times the factor, and the same directions.

use std::collections::BTreeMap;

use dr_core::wind::slow_errors::SurfaceCorrection;
use dr_core::wind::sphere::SECTORS;
use recording::toml_file::{FileError, TomlSource};

use super::checked::Calibration;
use super::table::{CalibrationTable, CorrectionTable, SurfaceCorrectionTable};
use crate::head::file::Head;

/// The version of a calibration that does not state one.
const FIRST_VERSION: u32 = 1;

impl Calibration {
    /// The table with its network, as it is written.
    pub(super) fn whole_table(&self) -> CalibrationTable {
        let (self_heating, cross_heating) = (self.network.own.clone(), self.network.cross.clone());
        CalibrationTable { self_heating, cross_heating, ..self.table.clone() }
    }

    /// Its version.
    pub fn version(&self) -> u32 {
        self.table.version.unwrap_or(FIRST_VERSION)
    }

    /// The head's file, and the head, with the day of its calibration.
    ///
    /// # Errors
    /// If it cannot be written, or not be read again.
    pub fn made_on(&self, day: &str, head: &Head) -> Result<(String, Head), FileError> {
        CalibrationTable { made_on: Some(day.to_owned()), ..self.whole_table() }.with_head(head)
    }

    /// The same with speeds that are greater by a factor with a standard uncertainty; `why` says
    /// by what it was found.
    ///
    /// # Errors
    /// If it cannot be written, or not be read again.
    pub fn rescaled(
        &self,
        (scale, scale_u): (f64, f64),
        why: &str,
        day: Option<&str>,
        head: &Head,
    ) -> Result<(String, Head), FileError> {
        let mut table = self.whole_table();
        let made_on = table.made_on.as_ref().map_or_else(String::new, |day| format!(" of {day}"));
        table.former = Some(format!("version {}{made_on}: {}", self.version(), table.made_from));
        table.version = Some(self.version() + 1);
        table.made_on = day.map(str::to_owned).or(table.made_on);
        table.made_from = format!("{}; speed × {scale:.4} ± {scale_u:.4} by {why}", table.made_from);
        let reynolds = table.nusselt.iter_mut().flat_map(|of| [&mut of.least_reynolds, &mut of.most_reynolds]);
        let of_card = table.card.iter_mut().flat_map(|of| [&mut of.least_reynolds, &mut of.most_reynolds]);
        let slowest = table.convection.iter_mut().map(|of| &mut of.slowest_reynolds);
        reynolds.chain(of_card).chain(slowest).for_each(|of| *of *= scale);
        for share in table.uncertainty.iter_mut().flat_map(|of| &mut of.speed_share) {
            *share = libm::hypot(*share, scale_u / scale).min(1.0);
        }
        table.with_head(head)
    }

    /// The corrections that its head carries, as the board takes them.
    pub fn corrections(&self) -> Option<[SurfaceCorrection; SECTORS]> {
        self.table.correction.as_ref()?.config()
    }

    /// The head's file, and the head, with these corrections in place of those that it carries.
    ///
    /// # Errors
    /// If it cannot be written, or not be read again.
    pub fn with_corrections(
        &self,
        corrections: &[SurfaceCorrection; SECTORS],
        found: &str,
        day: Option<&str>,
        head: &Head,
    ) -> Result<(String, Head), FileError> {
        let former = self.table.correction.as_ref();
        let made_from = former.map_or_else(|| found.to_owned(), |of| format!("{}; then {found}", of.made_from));
        let named = self.table.surfaces.iter().zip(corrections);
        let correction = CorrectionTable {
            made_from,
            made_on: day.map(str::to_owned),
            surfaces: named.map(|(of, own)| SurfaceCorrectionTable::new(of.element.clone(), own)).collect(),
        };
        CalibrationTable { correction: Some(correction), ..self.whole_table() }.with_head(head)
    }
}

impl CalibrationTable {
    /// The head's file with this calibration at its end, and the head that it makes.
    ///
    /// # Errors
    /// If it cannot be written, or not be read again.
    pub fn with_head(self, head: &Head) -> Result<(String, Head), FileError> {
        let path = head.source.path.clone();
        let tail = toml::to_string(&BTreeMap::from([("calibration", self)])).map_err(|error| FileError {
            path: path.clone(),
            line: None,
            sentence: error.to_string(),
        })?;
        let text = format!("{}\n{tail}", without_calibration(&head.source.text).trim_end());
        // A head that cannot be read again is not written.
        let made = Head::from_source(TomlSource { path, text: text.clone() })?;
        Ok((text, made))
    }
}

/// A head's text without a calibration that stands at its end.
fn without_calibration(text: &str) -> &str {
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        if line.trim_start().starts_with("[calibration") {
            return &text[..at];
        }
        at += line.len();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rescaled_calibration_names_its_former_one_and_moves_its_reynolds_numbers() {
        let path =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/sphere-b-calibrated.toml");
        let head = Head::read(&path).unwrap();
        let first = head.calibration.clone().unwrap();
        let (_, dated) = first.made_on("2026-03-01", &head).unwrap();
        let dated_calibration = dated.calibration.clone().unwrap();
        assert_eq!((dated_calibration.version(), dated_calibration.table.made_on.as_deref()), (1, Some("2026-03-01")));
        assert_eq!(dated_calibration.network, first.network);
        let (_, aged) = dated_calibration.rescaled((1.02, 0.004), "cup.csv", Some("2027-03-01"), &dated).unwrap();
        let aged = aged.calibration.unwrap();
        assert_eq!((aged.version(), aged.table.made_on.as_deref()), (2, Some("2027-03-01")));
        assert!(aged.table.former.as_ref().unwrap().starts_with("version 1 of 2026-03-01: "));
        assert!(aged.table.made_from.ends_with("; speed × 1.0200 ± 0.0040 by cup.csv"));
        let most = |of: &CalibrationTable| of.nusselt.as_ref().unwrap().most_reynolds;
        assert_eq!(most(&dated_calibration.table) * 1.02, most(&aged.table));
        assert_eq!(aged.network, first.network);
    }
}

#[cfg(test)]
mod corrected_tests {
    use super::*;
    use dr_core::wind::WindCommand;

    fn sphere_b() -> Head {
        let path =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/sphere-b-calibrated.toml");
        Head::read(&path).unwrap()
    }

    const FOUND: [SurfaceCorrection; SECTORS] = [
        SurfaceCorrection { offset_w: 3e-3, gain: 0.0, offset_u_w: 1e-4, gain_u: 0.0 },
        SurfaceCorrection { offset_w: 0.0, gain: 0.05, offset_u_w: 1e-4, gain_u: 0.01 },
        SurfaceCorrection { offset_w: -1e-3, gain: -0.02, offset_u_w: 2e-4, gain_u: 0.02 },
        SurfaceCorrection { offset_w: 0.0, gain: 0.0, offset_u_w: 0.0, gain_u: 0.0 },
    ];

    #[test]
    fn a_head_carries_its_corrections_to_the_board() {
        let head = sphere_b();
        let first = head.calibration.clone().unwrap();
        assert_eq!(first.corrections(), None);
        let (_, corrected) = first.with_corrections(&FOUND, "sun.parquet", Some("2026-03-01"), &head).unwrap();
        let its = corrected.calibration.clone().unwrap();
        for (own, found) in its.corrections().unwrap().iter().zip(&FOUND) {
            let pairs = [(own.offset_w, found.offset_w), (own.gain, found.gain), (own.gain_u, found.gain_u)];
            assert!(pairs.iter().all(|(a, b)| (a - b).abs() < 1e-7), "{own:?} {found:?}");
        }
        let output = crate::head::WindOutput::new(None, None, false, 0.01);
        let (commands, _) = its.commands(&output, 0.01).unwrap();
        let at = |of: &dyn Fn(&WindCommand) -> bool| commands.iter().position(of);
        let correction = at(&|of| matches!(of, WindCommand::Correction(_))).unwrap();
        assert!(correction < at(&|of| matches!(of, WindCommand::Output(_))).unwrap());
        // All else stays.
        assert_eq!(its.network, first.network);
        let sentence = its.table.correction.as_ref().unwrap().sentence();
        assert_eq!(sentence, "corrections of 2026-03-01 are applied, by sun.parquet");
        // Later ones take their place, and name what they came from.
        let (_, again) = its.with_corrections(&FOUND, "dust.parquet", None, &corrected).unwrap();
        let again = again.calibration.unwrap().table.correction.unwrap();
        assert_eq!(again.sentence(), "corrections are applied, by sun.parquet; then dust.parquet");
        assert_eq!(again.surfaces.len(), SECTORS);
    }

    #[test]
    fn corrections_that_cannot_be_are_refused_by_key_and_line() {
        let head = sphere_b();
        let (text, _) = head.calibration.as_ref().unwrap().with_corrections(&FOUND, "sun", None, &head).unwrap();
        let at = text.find("[calibration.correction]").unwrap();
        let refused = |from: &str, to: &str| {
            let (before, tail) = text.split_at(at);
            assert!(tail.contains(from), "{from}: {tail}");
            let source = TomlSource { path: "h.toml".into(), text: before.to_owned() + &tail.replacen(from, to, 1) };
            Head::from_source(source).unwrap_err().to_string()
        };
        let whole = refused("offset_u_w = ", "offset_u_w = 2.0 # ");
        assert!(whole.contains("`calibration.correction.surfaces[0].offset_u_w` is 2 W"), "{whole}");
        let gain = refused("gain_change = 0.0", "gain_change = -1.0");
        assert!(gain.contains("`calibration.correction.surfaces[0].gain_change` is -1"), "{gain}");
        let day = refused("made_from", "made_on = \"2026-02-30\"\nmade_from");
        assert!(day.contains("`calibration.correction.made_on` is `2026-02-30`: a day belongs there, as "), "{day}");
        let other = refused("element = \"sector1\"", "element = \"sector2\"");
        assert!(other.contains("must have the calibration's surfaces in its order, `sector1`, "), "{other}");
        let unknown = refused("made_from", "made_form");
        assert!(unknown.contains("unknown key `made_form`"), "{unknown}");
    }
}
