//! Source of what a log heats: by an experiment, or by a head and a few options.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::output::{Failure, finite, is_head};
use anemometry::gas::PRESSURE_RANGE_PA;
use anemometry::head::Head;
use host_sim::experiment::Experiment;
use host_sim::run::log::{alternate, hold};
use recording::toml_file::TomlSource;
use wire::BoardKind;

/// Set-points and conditions of a log.
#[derive(clap::Args)]
pub(super) struct SourceArguments {
    /// The experiment, or the head of a sensor board: a TOML file.
    #[arg(value_name = "EXPERIMENT|HEAD")]
    source: PathBuf,
    /// Set-point of every element that holds a temperature, °C; of a head, of all elements.
    #[arg(long, value_name = "°C", conflicts_with = "overheat", allow_negative_numbers = true)]
    set_point: Option<f64>,
    /// Set-points so far above the gas, K, as the head's element `reference` measures it.
    #[arg(long, value_name = "K")]
    pub(super) overheat: Option<f64>,
    /// Alternate between the set-points and these, so far above the gas, K: heat beside the wind
    /// shows by it.
    #[arg(long, value_name = "K", requires = "overheat")]
    overheat_alternation: Option<f64>,
    /// How long each of the two is held, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 600.0, requires = "overheat_alternation")]
    half: f64,
    /// Gas pressure: a number in Pa, or a file whose last line is one, read again when it changes.
    #[arg(long, value_name = "PA|FILE")]
    pub(super) pressure: Option<PressureSource>,
    /// Sample period of a head without an experiment, s; 0.01 if not given.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    sample_period: Option<f64>,
    /// Gas temperature before the head has measured any, °C, of a head without an experiment; 20 if
    /// not given.
    #[arg(long, value_name = "°C", allow_negative_numbers = true)]
    gas_temperature: Option<f64>,
}

/// Where the gas pressure comes from.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum PressureSource {
    Pascal(f64),
    File(PathBuf),
}

impl FromStr for PressureSource {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(text.parse().map_or_else(|_| Self::File(text.into()), Self::Pascal))
    }
}

impl PressureSource {
    /// The pressure now, Pa; of a file its last line.
    pub(super) fn now_pa(&self) -> Result<f64, Failure> {
        let (pressure_pa, place) = match self {
            Self::Pascal(pressure_pa) => (Some(*pressure_pa), "--pressure".to_owned()),
            Self::File(path) => {
                let text = std::fs::read_to_string(path).map_err(|error| Failure::in_file(path, error))?;
                let last = text.lines().rev().find(|line| !line.trim().is_empty());
                (last.and_then(|line| line.trim().parse().ok()), path.display().to_string())
            }
        };
        pressure_pa
            .filter(|pressure_pa: &f64| PRESSURE_RANGE_PA.contains(pressure_pa))
            .ok_or_else(|| Failure::usage(format!("{place}: a pressure of 1 to 200000 Pa belongs there")))
    }
}

impl SourceArguments {
    pub(super) fn path(&self) -> &Path {
        &self.source
    }

    /// Reads it; a controller in this process judges it by what such a board grants.
    pub(super) fn experiment(&self, board: Option<BoardKind>) -> Result<Experiment, Failure> {
        finite(&[
            ("--set-point", self.set_point),
            ("--overheat", self.overheat),
            ("--overheat-alternation", self.overheat_alternation),
            ("--half", Some(self.half)),
            ("--sample-period", self.sample_period),
            ("--gas-temperature", self.gas_temperature),
        ])?;
        let source = TomlSource::read(&self.source)?;
        let mut experiment = if is_head(&source) {
            if board != Some(BoardKind::Sensor) {
                let sentence = "is a head: a simulation asks for an experiment, with the wind around it; name one, or a sensor board by --on serial:DEVICE";
                return Err(Failure::in_file(&self.source, sentence));
            }
            self.of_head(&source)?
        } else {
            let own = [("--sample-period", self.sample_period), ("--gas-temperature", self.gas_temperature)];
            if let Some((option, _)) = own.iter().find(|(_, given)| given.is_some()) {
                return Err(Failure::usage(format!(
                    "{option}: {} is an experiment, which states it itself; change it there",
                    self.source.display()
                )));
            }
            Experiment::from_source(source)?
        };
        if let Some(pressure) = &self.pressure {
            experiment.pressure_pa = pressure.now_pa()?;
        }
        if let Some(target_c) = self.set_point {
            hold(&mut experiment, target_c).map_err(Failure::usage)?;
        }
        if let (Some(high_k), Some(low_k)) = (self.overheat, self.overheat_alternation) {
            alternate(&mut experiment, [high_k, low_k], self.half).map_err(Failure::usage)?;
        }
        host_sim::run::rehearse(&experiment, board)?;
        Ok(experiment)
    }

    /// An experiment in no wind of its own.
    fn of_head(&self, source: &TomlSource) -> Result<Experiment, Failure> {
        let head = Head::from_source(source.clone())?;
        let species = head.calibration.as_ref().map_or("air", |calibration| calibration.table.species.name());
        let pressure_pa = self.pressure.as_ref().map_or(Ok(101_325.0), PressureSource::now_pa)?;
        let gas_c = self.gas_temperature.unwrap_or(20.0);
        let target_c = self.set_point.or_else(|| self.overheat.map(|overheat_k| gas_c + overheat_k));
        let drives: String = target_c.map_or_else(String::new, |target_c| {
            let heated = head.names().into_iter().filter(|name| *name != recording::REFERENCE);
            heated.map(|name| format!("{name} = {{ temperature_c = {target_c:?} }}\n")).collect()
        });
        let text = format!(
            "title = {:?}\nhead = {:?}\nsample_period_s = {:?}\nduration_s = 86400.0\n\n\
             [gas]\nspecies = {species:?}\npressure_pa = {pressure_pa:?}\ntemperature_c = {:?}\n\n[drives]\n{drives}",
            head.name,
            self.source.file_name().unwrap_or_default().to_string_lossy(),
            self.sample_period.unwrap_or(0.01),
            gas_c,
        );
        Ok(Experiment::from_source(TomlSource { path: self.source.clone(), text })?)
    }
}
