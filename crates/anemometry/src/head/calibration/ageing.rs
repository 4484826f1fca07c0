//! A calibration that ages: its date, its version, and a scale of its speed.
//!
//! Curves over Reynolds numbers that all grow by a factor give the same conductances at speeds that
//! are greater by it: the head then reports each speed times the factor, and the same directions.

use recording::toml_file::FileError;

use super::checked::Calibration;
use super::table::CalibrationTable;
use crate::head::file::Head;

/// The version of a calibration that does not state one.
pub const FIRST_VERSION: u32 = 1;

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
            *share = share.hypot(scale_u / scale).min(1.0);
        }
        table.with_head(head)
    }
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
