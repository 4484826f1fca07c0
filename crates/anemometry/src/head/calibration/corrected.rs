//! A calibration with corrections of slow errors: checked, as commands, and on its way to the file.

use dr_core::wind::slow_errors::SurfaceCorrection;
use dr_core::wind::sphere::SECTORS;
use recording::toml_file::{FileError, TomlSource};

use super::checked::Calibration;
use super::correction::{CorrectionTable, SurfaceCorrectionTable};
use super::table::CalibrationTable;
use crate::head::file::Head;

impl Calibration {
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

    /// Whether the corrections are of this calibration's four surfaces, and can be.
    pub(super) fn check_correction(&self, source: &TomlSource) -> Result<(), FileError> {
        let Some(correction) = &self.table.correction else { return Ok(()) };
        if self.table.surfaces.len() != SECTORS || self.table.card.is_some() {
            let sentence = "belongs to heads of four surfaces round a body: this one has another form";
            return Err(source.refuse("calibration.correction", sentence));
        }
        let names = |of: &[String]| format!("`{}`", of.join("`, `"));
        let own: Vec<String> = self.table.surfaces.iter().map(|of| of.element.clone()).collect();
        let its: Vec<String> = correction.surfaces.iter().map(|of| of.element.clone()).collect();
        if own != its {
            let sentence = format!("must have the calibration's surfaces in its order, {}", names(&own));
            return Err(source.refuse("calibration.correction", sentence));
        }
        for (i, of) in correction.surfaces.iter().enumerate() {
            let key = format!("calibration.correction.surfaces[{i}]");
            for (name, number, least, most, unit) in [
                ("offset_w", of.offset_w, -1.0, 1.0, "W"),
                ("offset_u_w", of.offset_u_w, 0.0, 1.0, "W"),
                ("gain_change", of.gain_change, -0.9, 9.0, ""),
                ("gain_change_u", of.gain_change_u, 0.0, 9.0, ""),
            ] {
                source.within(&format!("{key}.{name}"), number, least..=most, unit)?;
            }
            let board = of.config().checked();
            board.map(drop).map_err(|error| source.refuse(&key, format!("cannot be used: {error}")))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
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
        let output = crate::head::output::WindOutput::new(None, None, false, 0.01);
        let (commands, _) = its.commands(&output, 0.01).unwrap();
        let at = |of: &dyn Fn(&WindCommand) -> bool| commands.iter().position(of);
        let correction = at(&|of| matches!(of, WindCommand::Correction(_))).unwrap();
        assert!(correction < at(&|of| matches!(of, WindCommand::Output(_))).unwrap());
        // All else stays.
        assert_eq!(its.network, first.network);
        let sentence = its.table.correction.as_ref().unwrap().sentence();
        assert_eq!(sentence, "corrections of 2026-03-01 are applied, by sun.parquet");
        // Those that are found later take their place, and name what they came from.
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
