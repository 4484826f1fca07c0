//! A sensor board in a process of its own, for `anemo run … --on silicon`: `anemo-silicon FIRMWARE
//! EXPERIMENT`. Its line are standard input and output, turn by turn
//! ([`host_sim::instrument::virtual_line`]). At the end it says on standard error what the models
//! have complained about, and fails if there is anything.

use host_sim::experiment::Experiment;
use host_sim::instrument::link::BoardStream;
use host_sim::instrument::virtual_line::Turn;
use silicon::machine::{Machine, MachineConfig};
use silicon::stream::MachineStream;
use std::cell::RefCell;
use std::error::Error;
use std::io::{self, ErrorKind};
use std::path::Path;
use std::process::ExitCode;
use std::rc::Rc;

/// A frame is shorter by far.
const MOST_BYTES: usize = 4096;

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args_os().skip(1).collect();
    let [firmware, experiment] = arguments.as_slice() else {
        eprintln!("usage: anemo-silicon FIRMWARE EXPERIMENT");
        return ExitCode::FAILURE;
    };
    match live(firmware.as_ref(), experiment.as_ref()) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Lives until the host is gone; gives the number of complaints.
fn live(firmware: &Path, experiment: &Path) -> Result<usize, Box<dyn Error>> {
    let sensor = Experiment::read(experiment)?.sensor_config()?;
    let machine = Machine::power_on(firmware, &MachineConfig { sensor, oscillator_hz: None })?;
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
        let answered = Turn { time: stream.now(), bytes }.write(&mut to_host);
        if answered.is_err() {
            // The host does not wait for it.
            break;
        }
    }
    let machine = machine.borrow();
    let complaints = machine.board().complaints.all();
    complaints.iter().for_each(|complaint| eprintln!("complaint: {complaint}"));
    Ok(complaints.len())
}
