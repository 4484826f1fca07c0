//! A head's calibration as an anemometer takes it, with refusals said of the place in the head's file.

use dr_core::control::{Anemometer, WindCommand};
use wire::MOST_ELEMENTS;

use super::Head;
use crate::toml_file::FileError;

impl Head {
    /// Tells an anemometer what `commands` of this head's calibration say.
    ///
    /// # Errors
    /// The first command that is refused, with the table of the head's file that it comes from.
    pub fn set_up(
        &self,
        anemometer: &mut Anemometer<MOST_ELEMENTS>,
        commands: &[WindCommand],
        sample_period_s: f64,
    ) -> Result<(), FileError> {
        let mut crosses = 0;
        for command in commands {
            let told = anemometer.handle(command, sample_period_s as f32);
            told.map_err(|error| {
                self.source.refuse(&self.table_of(command, crosses), format!("cannot be used: {error}"))
            })?;
            crosses += usize::from(matches!(command, WindCommand::Cross(_)));
        }
        Ok(())
    }

    /// The table in which a command's numbers stand; of pairs it is the one after so many.
    fn table_of(&self, command: &WindCommand, crosses: usize) -> String {
        let own = |element: u8| {
            let known = self.calibration.as_ref().map_or(&[][..], |calibration| &calibration.windless.own);
            match known.iter().position(|own| own.element == usize::from(element)) {
                Some(place) => format!("calibration.own[{place}]"),
                None => "calibration".to_owned(),
            }
        };
        match command {
            WindCommand::Own { element, .. } => own(*element),
            WindCommand::Faster(config) => own(config.element),
            WindCommand::Cross(_) => format!("calibration.cross[{crosses}]"),
            WindCommand::Point { .. } => "calibration.nusselt.amplitudes".to_owned(),
            WindCommand::Part { part, .. } => format!("calibration.parts[{part}]"),
            WindCommand::Card(_) => "calibration.card".to_owned(),
            WindCommand::GasLaw(_) => "calibration.reference_gas_c".to_owned(),
            WindCommand::Answer(_) | WindCommand::Gas { .. } => "calibration".to_owned(),
        }
    }
}
