//! Effect of a line on the meter, and its answer.

use super::state::MisbehaviourKind;
use super::state::{MeterState, NO_NUMBER};

/// Range of the bias, V.
const MOST_BIAS_V: f64 = 40.0;

const UNDEFINED_HEADER: ScpiFault = ScpiFault("-113,\"Undefined header\"");
const DATA_TYPE: ScpiFault = ScpiFault("-104,\"Data type error\"");
const TRIGGER_IGNORED: ScpiFault = ScpiFault("-211,\"Trigger ignored\"");
const OUT_OF_RANGE: ScpiFault = ScpiFault("-222,\"Data out of range\"");
const ILLEGAL_PARAMETER: ScpiFault = ScpiFault("-224,\"Illegal parameter value\"");

/// An entry of its error queue.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
struct ScpiFault(&'static str);

/// Reaction of the meter.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Reaction {
    Bytes(Vec<u8>),
    Close,
}

/// Takes a line.
pub(super) fn react(state: &mut MeterState, line: &str) -> Reaction {
    let line = line.trim();
    if line.is_empty() {
        return Reaction::Bytes(Vec::new());
    }
    let kind = state.count(line);
    match kind {
        Some(MisbehaviourKind::Disconnect) => return Reaction::Close,
        Some(MisbehaviourKind::Silence) => return Reaction::Bytes(Vec::new()),
        Some(MisbehaviourKind::Refusal) => {
            state.errors.push_back(UNDEFINED_HEADER.0);
            return Reaction::Bytes(Vec::new());
        }
        _ => {}
    }
    state.has_overload = kind == Some(MisbehaviourKind::Overload);
    let answer = obey(state, line).unwrap_or_else(|error| {
        state.errors.push_back(error.0);
        None
    });
    let answer = match (kind, answer) {
        (Some(MisbehaviourKind::Garbage), _) => b"\xff\x00?#,,\n".to_vec(),
        (_, None) => Vec::new(),
        (Some(MisbehaviourKind::HalfAnswer), Some(answer)) => answer.as_bytes()[..answer.len() / 2].to_vec(),
        (Some(MisbehaviourKind::WrongBias), Some(_)) if line == ":BIAS:VOLT?" => {
            format!("{:+.5E}\n", state.bias_v + 1.0).into_bytes()
        }
        (_, Some(answer)) => (answer + "\n").into_bytes(),
    };
    Reaction::Bytes(answer)
}

fn obey(state: &mut MeterState, line: &str) -> Result<Option<String>, ScpiFault> {
    let (header, parameter) = line.split_once(' ').unwrap_or((line, ""));
    let answer = match (header, parameter) {
        ("*IDN?", "") => state.identity.clone(),
        ("*OPC?", "") => "+1".to_owned(),
        (":BIAS:VOLT?", "") => format!("{:+.5E}", state.bias_v),
        (":BIAS:STAT?", "") => i32::from(state.is_on).to_string(),
        (":SYST:ERR?", "") => state.errors.pop_front().unwrap_or("+0,\"No error\"").to_owned(),
        (":FETC?", "") => fetched(state),
        _ => return set(state, header, parameter).map(|()| None),
    };
    Ok(Some(answer))
}

fn set(state: &mut MeterState, header: &str, parameter: &str) -> Result<(), ScpiFault> {
    match (header, parameter) {
        ("*RST", "") => state.reset(),
        ("*CLS", "") => state.errors.clear(),
        (":FUNC:IMP", _) => one_of(parameter, &["CPD", "CPRP"])?,
        (":FREQ", _) => number(parameter, 20.0..=2e6).map(drop)?,
        (":VOLT", _) => number(parameter, 0.0..=20.0).map(drop)?,
        (":APER", _) => one_of(parameter, &["SHOR", "SHORT", "MED", "MEDIUM", "LONG"])?,
        (":FORM:ASC:LONG", _) => state.is_long = switch(parameter)?,
        (":INIT:CONT", _) => switch(parameter).map(drop)?,
        (":TRIG:SOUR", _) => {
            one_of(parameter, &["INT", "HOLD", "EXT", "BUS"])?;
            state.waits_for_bus = parameter == "BUS";
        }
        (":TRIG:IMM", "") if state.waits_for_bus => state.measure(),
        (":TRIG:IMM", "") => return Err(TRIGGER_IGNORED),
        (":BIAS:VOLT", _) => {
            let bias_v = number(parameter, -MOST_BIAS_V..=MOST_BIAS_V)?;
            state.bias(bias_v, state.is_on);
        }
        (":BIAS:STAT", _) => {
            let is_on = switch(parameter)?;
            state.bias(state.bias_v, is_on);
        }
        _ => return Err(UNDEFINED_HEADER),
    }
    Ok(())
}

fn fetched(state: &MeterState) -> String {
    let (capacitance_f, status) = state.reading;
    let loss = if status == 0 { 1e-3 } else { NO_NUMBER };
    let digits = if state.is_long { 9 } else { 5 };
    format!("{capacitance_f:+.digits$E},{loss:+.digits$E},{status:+}")
}

fn number(parameter: &str, range: std::ops::RangeInclusive<f64>) -> Result<f64, ScpiFault> {
    let number = parameter.parse().ok().filter(|number: &f64| number.is_finite()).ok_or(DATA_TYPE)?;
    if range.contains(&number) { Ok(number) } else { Err(OUT_OF_RANGE) }
}

fn switch(parameter: &str) -> Result<bool, ScpiFault> {
    one_of(parameter, &["ON", "1", "OFF", "0"])?;
    Ok(matches!(parameter, "ON" | "1"))
}

fn one_of(parameter: &str, known: &[&str]) -> Result<(), ScpiFault> {
    if known.contains(&parameter) { Ok(()) } else { Err(ILLEGAL_PARAMETER) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_that_the_meter_does_not_know_is_an_error_in_its_queue() {
        let mut state = MeterState::new("identity".to_owned(), None, Box::new(|bias_v, _| Some(bias_v * 1e-12)));
        let mut ask = |line| match react(&mut state, line) {
            Reaction::Bytes(answer) => String::from_utf8(answer).expect("text"),
            Reaction::Close => panic!("{line}"),
        };
        for (line, error) in [
            (":BIAS:VOLTS 1", UNDEFINED_HEADER),
            ("*RST 1", UNDEFINED_HEADER),
            (":BIAS:VOLT 40.1", OUT_OF_RANGE),
            (":BIAS:VOLT x", DATA_TYPE),
            (":BIAS:STAT MAYBE", ILLEGAL_PARAMETER),
            (":FREQ 1", OUT_OF_RANGE),
            (":TRIG:IMM", TRIGGER_IGNORED),
        ] {
            assert_eq!(ask(line), "", "{line}");
            assert_eq!(ask(":SYST:ERR?"), format!("{error}\n"), "{line}");
        }
        assert_eq!(ask(":FETC?"), "+9.90000E37,+9.90000E37,-1\n");
        for line in [":TRIG:SOUR BUS", ":BIAS:VOLT -30.5", ":BIAS:STAT ON", ":TRIG:IMM"] {
            assert_eq!(ask(line), "", "{line}");
        }
        assert_eq!(ask(":FETC?"), "-3.05000E-11,+1.00000E-3,+0\n");
        assert_eq!(ask(":BIAS:VOLT?"), "-3.05000E1\n");
        assert_eq!(ask(":SYST:ERR?"), "+0,\"No error\"\n");
        assert_eq!(state.history.iter().map(|step| step.bias_v).collect::<Vec<_>>(), [0.0, -30.5]);
    }
}
