//! A sensor board in a process of its own, for `anemo run … --on silicon`: `anemo-silicon FIRMWARE
//! [--experiment EXPERIMENT] [--flash FILE]`. Its line are standard input and output, turn by turn
//! ([`host_sim::instrument::virtual_line`]). At the end it writes the sectors of its settings into
//! the file, says on standard error what the models have complained about, and fails if there is
//! anything.

use host_sim::experiment::Experiment;
use host_sim::instrument::link::BoardStream;
use host_sim::instrument::virtual_line::Turn;
use host_sim::sensor::SensorConfig;
use silicon::machine::{Machine, MachineConfig};
use silicon::stream::MachineStream;
use std::cell::RefCell;
use std::error::Error;
use std::io::{self, ErrorKind};
use std::path::PathBuf;
use std::process::ExitCode;
use std::rc::Rc;

/// A frame is shorter by far.
const MOST_BYTES: usize = 4096;

const USAGE: &str = "usage: anemo-silicon FIRMWARE [--experiment EXPERIMENT] [--flash FILE]";

fn main() -> ExitCode {
    match live() {
        Ok(0) => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Lives until the host is gone; gives the number of complaints.
fn live() -> Result<usize, Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let firmware = arguments.next().ok_or(USAGE)?;
    let (mut sensor, mut flash) = (SensorConfig::default(), None);
    while let (Some(option), file) = (arguments.next(), arguments.next().ok_or(USAGE)) {
        match option.to_str() {
            Some("--experiment") => sensor = Experiment::read(&file?)?.sensor_config()?,
            Some("--flash") => flash = Some(file?),
            _ => return Err(USAGE.into()),
        }
    }
    let mut machine = Machine::power_on(&firmware, &MachineConfig { sensor, oscillator_hz: None })?;
    if let Some(file) = flash.as_ref().filter(|file| file.exists()) {
        let kept = std::fs::read(file)?;
        let settings = &mut machine.board_mut().flash.settings;
        if kept.len() != settings.len() {
            return Err(format!(
                "{}: no flash of a board: it has another length than {}",
                file.display(),
                settings.len()
            )
            .into());
        }
        settings.copy_from_slice(&kept);
    }
    let machine = Rc::new(RefCell::new(machine));
    let mut stream = MachineStream::new(Rc::clone(&machine));
    let (mut from_host, mut to_host) = (io::stdin().lock(), io::stdout().lock());
    loop {
        let turn = match Turn::read(&mut from_host) {
            Ok(turn) => turn,
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => break,
            Err(error) => return Err(error.into()),
        };
        stream.write_all(&turn.bytes)?;
        let mut bytes = vec![0; MOST_BYTES];
        let read = match stream.read_within(&mut bytes, turn.time) {
            Ok(read) => read,
            Err(error) if error.kind() == ErrorKind::TimedOut => 0,
            Err(error) => return Err(error.into()),
        };
        bytes.truncate(read);
        let wind_m_s = stream.true_wind_m_s().unwrap_or_default();
        let answered = Turn { time: stream.now(), wind_m_s, bytes }.write(&mut to_host);
        if answered.is_err() {
            // The host does not wait for it.
            break;
        }
    }
    let machine = machine.borrow();
    if let Some(file) = flash {
        std::fs::write(file, &machine.board().flash.settings)?;
    }
    let complaints = machine.board().complaints.all();
    complaints.iter().for_each(|complaint| eprintln!("complaint: {complaint}"));
    Ok(complaints.len())
}
