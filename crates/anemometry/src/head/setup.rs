//! Set-up of an anemometer with a head's calibration; refusals name the key and line of the head
//! file.

use dr_core::control::MOST_ELEMENTS;
use dr_core::wind::{Anemometer, WindCommand};

use super::file::Head;
use recording::toml_file::FileError;

impl Head {
    /// Sends `commands` of this head's calibration to an anemometer.
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
            anemometer.handle(command, sample_period_s as f32).map_err(|error| {
                self.source.refuse(&self.table_of(command, crosses), format!("cannot be used: {error}"))
            })?;
            crosses += usize::from(matches!(command, WindCommand::CrossHeating(_)));
        }
        Ok(())
    }

    /// The table with a command's numbers; `crosses` counts the pairs before it.
    fn table_of(&self, command: &WindCommand, crosses: usize) -> String {
        let own = |element: u8| {
            let known = self.calibration.as_ref().map_or(&[][..], |calibration| &calibration.network.own);
            match known.iter().position(|own| own.element == usize::from(element)) {
                Some(place) => format!("calibration.self_heating[{place}]"),
                None => "calibration".to_owned(),
            }
        };
        match command {
            WindCommand::SelfHeating { element, .. } => own(*element),
            WindCommand::FasterGains(config) => own(config.element),
            WindCommand::CrossHeating(_) => format!("calibration.cross_heating[{crosses}]"),
            WindCommand::NusseltPoint { .. } => "calibration.nusselt.amplitudes".to_owned(),
            WindCommand::Surface { surface: part, .. } => format!("calibration.surfaces[{part}]"),
            WindCommand::Card(_) => "calibration.card".to_owned(),
            WindCommand::Uncertainty(_) => "calibration.uncertainty".to_owned(),
            WindCommand::Convection(_) => "calibration.convection".to_owned(),
            WindCommand::Correction(_) => "calibration.correction".to_owned(),
            WindCommand::GasLaw(_) => "calibration.reference_gas_c".to_owned(),
            WindCommand::Form(_) | WindCommand::Output(_) | WindCommand::Gas { .. } => "calibration".to_owned(),
        }
    }
}
