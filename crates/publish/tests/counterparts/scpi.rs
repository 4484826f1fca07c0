//! SCPI, asked by lxi-tools and pyvisa.

use crate::bench::{Run, Running, Tested, free, listening, program, python, wait_for, wait_until};
use std::process::Command;

#[test]
fn lxi_tools_identify_the_instrument() -> Tested {
    let Some(lxi) = program("lxi") else { return Ok(()) };
    let address = free()?;
    let run = Run::start(&format!("scpi://{address}"))?;
    wait_for(address)?;
    let ask = |query: &str| {
        let port = address.port().to_string();
        Running::start(Command::new(&lxi).args(["scpi", "--address", "127.0.0.1", "--raw", "--port", &port, query]))?
            .printed()
    };
    assert_eq!(ask("*IDN?")?.trim(), "anemo,sphere  \"silver\",000000010000000200000003,anemo 0.2.0");
    assert_eq!(ask("MEAS:WIND:SPE?")?.trim(), "2.5");
    assert!(run.end().is_empty());
    Ok(())
}

#[test]
fn pyvisa_measures_and_heats_nothing_without_the_token() -> Tested {
    let Some(python) = python() else { return Ok(()) };
    let address = free()?;
    let run = Run::start(&format!("scpi://{address}"))?;
    wait_for(address)?;
    let script = format!(
        "import pyvisa
instrument = pyvisa.ResourceManager('@py').open_resource('TCPIP::127.0.0.1::{}::SOCKET',
    read_termination='\\n', write_termination='\\n', timeout=30000)
speed, direction, *u = instrument.query_ascii_values('MEAS:WIND?')
print(speed, round(direction), u[0])
print(instrument.query('MEAS:TEMP?'))
instrument.write('INIT')
print(instrument.query('SYST:ERR?'))
instrument.write('SYST:PASS \"{}\"')
instrument.write('INIT')
print(instrument.query('SYST:ERR?'))",
        address.port(),
        listening().token().text(),
    );
    let printed = Running::start(Command::new(python).args(["-c", &script]))?.printed()?;
    let lines: Vec<_> = printed.lines().collect();
    assert_eq!(lines[..2], ["2.5 270 0.125", "60.5,9.91E37"]);
    assert!(lines[2].starts_with("-203,"), "{printed}");
    assert!(lines[3].contains("the run takes no commands"), "{printed}");
    assert!(run.end().is_empty());
    Ok(())
}

#[test]
fn a_port_in_use_is_one_sentence_and_tried_again() -> Tested {
    let other = listening().bind(([127, 0, 0, 1], 0).into())?;
    let address = other.address();
    let run = Run::start(&format!("scpi://{address}"))?;
    wait_until("it has failed", || run.has_said("cannot listen on"))?;
    drop(other);
    wait_until("it works", || run.has_said("works again"))?;
    assert_eq!(run.sentences.lock().expect("no panic").len(), 2, "one sentence each");
    assert!(run.end().is_empty());
    Ok(())
}
