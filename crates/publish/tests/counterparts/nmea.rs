//! NMEA 0183 by UDP, TCP and a serial port, read by pynmea2.

use crate::bench::{Run, Running, Tested, free, python, wait_until};
use std::process::Command;

/// Reads three sentences from `lines`, strictly, and prints what they say.
const READ: &str = "
import pynmea2
for _ in range(3):
    line = next(lines)
    wind = pynmea2.parse(line.decode('ascii').strip(), check=True)
    print(wind.talker, wind.sentence_type, wind.wind_angle, wind.reference, wind.wind_speed, wind.wind_speed_units, wind.status)
";
/// Towards −y is towards the right of north, which is east: a west wind.
const SAID: &str = "WI MWV 270.0 R 2.50 M A\n";

fn reader(python: &std::path::Path, lines: &str) -> std::io::Result<Running> {
    Running::start(Command::new(python).arg("-c").arg(format!("{lines}\n{READ}")))
}

#[test]
fn pynmea2_reads_datagrams() -> Tested {
    let Some(python) = python() else { return Ok(()) };
    let address = free()?;
    let lines = format!(
        "import socket
udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
udp.bind(('127.0.0.1', {}))
lines = iter(lambda: udp.recv(1000), None)",
        address.port()
    );
    let reader = reader(&python, &lines)?;
    let run = Run::start(&format!("nmea+udp://{address}"))?;
    assert_eq!(reader.printed()?, SAID.repeat(3));
    assert!(run.end().is_empty());
    Ok(())
}

#[test]
fn pynmea2_reads_a_connection_and_a_reader_that_left_is_no_fault() -> Tested {
    let Some(python) = python() else { return Ok(()) };
    let address = free()?;
    let run = Run::start(&format!("nmea+tcp://{address}"))?;
    crate::bench::wait_for(address)?;
    for _ in 0..2 {
        let lines = format!(
            "import socket
lines = socket.create_connection(('127.0.0.1', {}), 30).makefile('rb')",
            address.port()
        );
        assert_eq!(reader(&python, &lines)?.printed()?, SAID.repeat(3));
    }
    assert!(run.sentences.lock().expect("no panic").is_empty());
    assert!(run.end().is_empty());
    Ok(())
}

#[test]
fn pynmea2_reads_a_serial_port() -> Tested {
    let Some(python) = python() else { return Ok(()) };
    let folder = tempfile::tempdir()?;
    let name = folder.path().join("name");
    let lines = format!(
        "import os, pty, tty
line, port = pty.openpty()
tty.setraw(port)
open({name:?} + '.new', 'w').write(os.ttyname(port))
os.rename({name:?} + '.new', {name:?})
lines = os.fdopen(line, 'rb')"
    );
    let reader = reader(&python, &lines)?;
    wait_until("the port is there", || name.is_file())?;
    let run = Run::start(&format!("nmea+serial:{}", std::fs::read_to_string(&name)?))?;
    assert_eq!(reader.printed()?, SAID.repeat(3));
    assert!(run.end().is_empty());
    Ok(())
}
