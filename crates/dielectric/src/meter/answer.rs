//! What answers mean.

use super::error::MeterError;

/// What stands where a number would, if there is none.
const NO_NUMBER: f64 = 9.9e37;

/// A number.
pub(super) fn number(command: &str, answer: &str) -> Result<f64, MeterError> {
    let number = answer.trim().parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| MeterError::Garbled { command: command.to_owned(), answer: answer.to_owned() })
}

/// Whether a switch is on.
pub(super) fn switch(command: &str, answer: &str) -> Result<bool, MeterError> {
    match answer.trim().trim_start_matches('+') {
        "0" => Ok(false),
        "1" => Ok(true),
        _ => Err(MeterError::Garbled { command: command.to_owned(), answer: answer.to_owned() }),
    }
}

/// Capacitance of `<C>,<D>,<status>[,<bin>]` in F; none at a status other than 0.
pub(super) fn capacitance_f(command: &str, answer: &str) -> Result<Option<f64>, MeterError> {
    let fields: Vec<&str> = answer.split(',').collect();
    let [capacitance, loss, status, ..] = fields[..] else {
        return Err(MeterError::CutShort { command: command.to_owned(), answer: answer.to_owned() });
    };
    // An answer is whole or it is nothing: D is not needed, but it has to be there.
    number(command, loss)?;
    let (capacitance_f, status) = (number(command, capacitance)?, number(command, status)?);
    Ok((status == 0.0 && capacitance_f.abs() < NO_NUMBER).then_some(capacitance_f))
}

/// An entry of the queue of errors; none if the queue is empty.
pub(super) fn queued_error(command: &str, answer: &str) -> Result<Option<String>, MeterError> {
    let (code, _) = answer.split_once(',').unwrap_or((answer, ""));
    Ok((number(command, code)? != 0.0).then(|| answer.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reading_is_there_or_missing_or_garbled() {
        let read = |answer| capacitance_f(":FETC?", answer);
        assert_eq!(read("+1.234567890E-12,+1.0E-03,+0").expect("a reading"), Some(1.23456789e-12));
        assert_eq!(read("-1.2E-15,-1.0E-03,+0,+1").expect("a bin behind it"), Some(-1.2e-15));
        for missing in ["+9.9E+37,+9.9E+37,+1", "+9.9E+37,+9.9E+37,+0", "+1E-12,+1E-3,+3", "+1E-12,+1E-3,-1"] {
            assert_eq!(read(missing).expect("an answer"), None, "{missing}");
        }
        assert!(matches!(read("+1.2E-12,+1"), Err(MeterError::CutShort { .. })));
        for garbled in ["x,+1E-3,+0", "+1E-12,,+0", "+1E-12,+1E-3,", "nan,+1E-3,+0", "+1E-12,inf,+0", "1,2,3x"] {
            assert!(matches!(read(garbled), Err(MeterError::Garbled { .. })), "{garbled}");
        }
    }

    #[test]
    fn an_empty_queue_is_no_error() {
        assert_eq!(queued_error("", "+0,\"No error\"").expect("an answer"), None);
        assert_eq!(queued_error("", "-222,\"x\"").expect("an answer").as_deref(), Some("-222,\"x\""));
        assert!(queued_error("", "#!").is_err());
    }
}
