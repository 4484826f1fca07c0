//! Instrument that a command is about, and how it is reached.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::options::choice;
use crate::output::Failure;
use host_sim::instrument::emulated::{Emulated, EmulatorLink};
use host_sim::instrument::serial::Serial;
use host_sim::instrument::virtual_line::{self, VirtualBoardFiles, VirtualLine};
use host_sim::instrument::{InstrumentPort, LinkReport, LockStep, LockStepController, SettingsPort, in_process, setup};
use host_sim::sensor::Sensor;
use wire::BoardKind;

/// The firmware of the emulated board: beside this command in a release, in this folder of a build.
const FIRMWARE: &str = "firmware-virtual-board.elf";
/// The one that is flashed, for `--on silicon`.
const SENSOR_FIRMWARE: &str = "firmware-sensor-board.elf";
/// Program that runs it: one of a build that no release contains, beside this command.
const SILICON: &str = "anemo-silicon";
const BUILT: &str = "thumbv7em-none-eabihf/firmware";

/// Where the help has what nobody else needs.
pub(super) const EMULATED: &str = "Emulated board";

/// The instrument that a command works with.
#[derive(clap::Args)]
pub(super) struct InstrumentArguments {
    /// The instrument: simulated in this process, an emulated or a sensor board; of a MEMS
    /// capacitor also an LCR meter at HOST or HOST:PORT.
    #[arg(long, value_name = "sim|qemu|serial:DEVICE|scpi:HOST")]
    pub(super) on: On,
    #[command(flatten)]
    pub(super) emulation: Emulation,
    /// The file that is its flash, as of `anemo board settings`; without it the board keeps nothing.
    #[arg(long, value_name = "FILE", help_heading = EMULATED)]
    pub(super) flash: Option<PathBuf>,
    /// Acknowledge a trip of an earlier run, and go on.
    #[arg(long)]
    pub(super) acknowledge: bool,
}

impl InstrumentArguments {
    /// The file that is its flash, if it has one; refused where that could not be.
    pub(super) fn flash(&self) -> Result<Option<&Path>, Failure> {
        if self.flash.is_some() && !matches!(self.on, On::Qemu | On::Silicon) {
            return Err(Failure::usage(
                "--flash: only the flash of qemu and silicon is a file; leave it out, or name --on qemu or --on silicon",
            ));
        }
        Ok(self.flash.as_deref())
    }

    /// Opens it; what is simulated gets this sensor, which is that of the experiment.
    pub(super) fn open(
        &self,
        experiment: Option<&Path>,
        sensor: impl FnOnce() -> Result<Sensor, Failure>,
    ) -> Result<Box<dyn InstrumentPort>, Failure> {
        let flash = self.flash()?;
        self.emulation.has_link(&self.on)?;
        let mut instrument: Box<dyn InstrumentPort> = match &self.on {
            On::Sim => {
                let sensor = sensor()?;
                in_process::of_head(sensor.codes().len(), sensor)
            }
            On::Qemu => {
                let sensor = sensor()?;
                Box::new(LockStep::new(self.emulation.start(flash)?, sensor))
            }
            On::Silicon => {
                let missing = || Failure::usage("--on silicon: the sensor is that of an experiment: name one");
                Box::new(self.emulation.start_silicon(Some(experiment.ok_or_else(missing)?), flash)?)
            }
            On::Serial(device) => Box::new(Serial::open(device).map_err(Failure::work)?),
            On::Scpi(_) => return Err(no_head()),
        };
        if self.acknowledge {
            setup::acknowledge(instrument.as_mut()).map_err(Failure::work)?;
        }
        Ok(instrument)
    }
}

/// How a board is emulated.
#[derive(Clone, clap::Args)]
pub(super) struct Emulation {
    /// Firmware of the emulated board; by default that of the release or build.
    #[arg(long, value_name = "ELF", env = "ANEMO_FIRMWARE", help_heading = EMULATED)]
    firmware: Option<PathBuf>,
    /// Link of `--on qemu`: `fifo`, the default, is fast, `usart` is what a cable would carry.
    #[arg(long, value_name = "fifo|usart", hide_possible_values = true, help_heading = EMULATED,
        value_parser = choice([("fifo", "", EmulatorLink::Fifo), ("usart", "", EmulatorLink::Usart)]))]
    link: Option<EmulatorLink>,
}

impl Emulation {
    pub(super) fn start(&self, flash: Option<&Path>) -> Result<Emulated, Failure> {
        let link = self.link.unwrap_or(EmulatorLink::Fifo);
        Emulated::start_with(&self.firmware(FIRMWARE), link, flash).map_err(Failure::work)
    }

    /// Refuses a choice of link where there is none.
    pub(super) fn has_link(&self, on: &On) -> Result<(), Failure> {
        match self.link {
            Some(_) if *on != On::Qemu => {
                Err(Failure::usage("--link: only qemu has a choice of links; leave it out, or name --on qemu"))
            }
            _ => Ok(()),
        }
    }

    fn start_silicon(&self, experiment: Option<&Path>, flash: Option<&Path>) -> Result<Serial<VirtualLine>, Failure> {
        let program = std::env::current_exe().unwrap_or_default().with_file_name(SILICON);
        let files = VirtualBoardFiles { firmware: &self.firmware(SENSOR_FIRMWARE), experiment, flash };
        virtual_line::start(&program, &files).map_err(Failure::work)
    }

    /// The firmware that was asked for, or the one that came with this command, wherever that is.
    fn firmware(&self, file: &str) -> PathBuf {
        let own = std::env::current_exe().unwrap_or_default();
        let folders = own.ancestors().skip(1).zip(["", BUILT]);
        let mut near = folders.map(|(folder, below)| folder.join(below).join(file));
        let found = || near.find(|path| path.exists()).unwrap_or_else(|| Path::new("target").join(BUILT).join(file));
        self.firmware.clone().unwrap_or_else(found)
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum On {
    Sim,
    Qemu,
    /// The image of the sensor board on models of the board: for tests of the firmware, from a
    /// build of the whole workspace.
    Silicon,
    Serial(String),
    /// A meter of capacitance and bias, at HOST or HOST:PORT.
    Scpi(String),
}

/// A meter cannot heat.
fn no_head() -> Failure {
    Failure::usage(
        "--on scpi: a meter reads the `device` of an experiment and no head; name sim, qemu or serial:DEVICE",
    )
}

impl On {
    /// Whose limits hold there: none in this process. A cable leads to a sensor board.
    pub(super) const fn board(&self) -> Option<BoardKind> {
        match self {
            Self::Sim | Self::Scpi(_) => None,
            Self::Qemu => Some(BoardKind::Virtual),
            Self::Silicon | Self::Serial(_) => Some(BoardKind::Sensor),
        }
    }
}

impl FromStr for On {
    type Err = Failure;

    fn from_str(text: &str) -> Result<Self, Failure> {
        match text.split_once(':') {
            None if text == "sim" => Ok(Self::Sim),
            None if text == "qemu" => Ok(Self::Qemu),
            None if text == "silicon" => Ok(Self::Silicon),
            Some(("scpi", host)) if !host.is_empty() => Ok(Self::Scpi(host.to_owned())),
            _ if text.starts_with("scpi") => Err(Failure::usage("a meter is named too, as in scpi:192.168.0.17")),
            Some(("serial", device)) if !device.is_empty() => Ok(Self::Serial(device.to_owned())),
            _ if text.starts_with("serial") => {
                Err(Failure::usage("a serial port is named too, as in serial:/dev/ttyACM0"))
            }
            _ => Err(Failure::usage("it is sim, qemu, serial:DEVICE or scpi:HOST")),
        }
    }
}

/// A board that is open for what it keeps. One that is not emulated here goes on when it is closed.
pub(super) enum OpenBoard {
    Emulated(Box<Emulated>),
    Other(Box<dyn SettingsPort>),
}

impl OpenBoard {
    pub(super) fn open(on: &On, emulation: &Emulation, flash: &Path) -> Result<Self, Failure> {
        emulation.has_link(on)?;
        Ok(match on {
            On::Sim => {
                return Err(Failure::usage(
                    "--on sim: a controller in this process keeps nothing; name a board: qemu or serial:DEVICE",
                ));
            }
            On::Scpi(_) => return Err(no_head()),
            On::Silicon => Self::Other(Box::new(emulation.start_silicon(None, Some(flash))?)),
            On::Qemu => Self::Emulated(Box::new(emulation.start(Some(flash))?)),
            On::Serial(device) => Self::Other(Box::new(Serial::open(device).map_err(Failure::work)?)),
        })
    }

    pub(super) fn port(&mut self) -> &mut dyn SettingsPort {
        match self {
            Self::Emulated(board) => board.as_mut(),
            Self::Other(board) => board.as_mut(),
        }
    }

    pub(super) fn close(self) -> Result<(), Failure> {
        match self {
            Self::Emulated(board) => board.finish().map(|_: LinkReport| ()).map_err(Failure::work),
            Self::Other(_) => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instruments_are_named_as_in_the_help() {
        assert_eq!("sim".parse(), Ok(On::Sim));
        assert_eq!("qemu".parse(), Ok(On::Qemu));
        assert_eq!("silicon".parse(), Ok(On::Silicon));
        assert_eq!("serial:/dev/ttyACM0".parse(), Ok(On::Serial("/dev/ttyACM0".to_owned())));
        assert_eq!(
            "serial:".parse::<On>().unwrap_err().sentence,
            "a serial port is named too, as in serial:/dev/ttyACM0"
        );
        assert_eq!("simulation".parse::<On>().unwrap_err().sentence, "it is sim, qemu, serial:DEVICE or scpi:HOST");
    }
}
