use super::pretended::{Misbehaviour, MisbehaviourKind, PretendedDevice, PretendedSettings};
use super::{MeterError, MeterSettings, PretendedMeter, ScpiMeter};
use crate::port::{ChargeSymbol, SymbolShape};
use crate::port::{DevicePort, PortError};
use std::net::{Ipv6Addr, SocketAddr};
use std::time::{Duration, Instant};

/// 20 ms, so that a run takes no time.
const SHAPE: SymbolShape = SymbolShape { positive_v: 20.5, negative_v: -30.0, second_share: 0.3, symbol_time_s: 0.02 };
/// Far beyond what a loaded machine needs for an answer.
const SETTINGS: MeterSettings = MeterSettings { frequency_hz: 1e6, level_v: 0.5, most_bias_v: 35.0, timeout_s: 0.5 };

const KINDS: [MisbehaviourKind; 7] = [
    MisbehaviourKind::Disconnect,
    MisbehaviourKind::Garbage,
    MisbehaviourKind::HalfAnswer,
    MisbehaviourKind::Silence,
    MisbehaviourKind::Overload,
    MisbehaviourKind::Refusal,
    MisbehaviourKind::WrongBias,
];

/// C(V) = C₀ + α (V − V_sh)² with 1 pF, 1 fF/V², 1 V.
fn capacitance_f(bias_v: f64) -> f64 {
    1e-12 + 1e-15 * (bias_v - 1.0).powi(2)
}

fn device() -> PretendedDevice {
    Box::new(|bias_v, _| Some(capacitance_f(bias_v)))
}

fn pretended(misbehaviour: Option<Misbehaviour>) -> PretendedMeter {
    let settings = PretendedSettings { misbehaviour, ..PretendedSettings::default() };
    PretendedMeter::start(settings, device()).expect("the loopback")
}

/// Tells whether symbols are in time depends on the machine: a test of something else lets them be
/// late.
fn connect(pretended: &PretendedMeter) -> Result<ScpiMeter, MeterError> {
    Ok(ScpiMeter::connect(&pretended.address().to_string(), &SETTINGS)?.with_most_late(1.0))
}

fn symbols(meter: &mut ScpiMeter) -> Result<(), PortError> {
    meter.apply(Some(ChargeSymbol::Bit0), &SHAPE)?;
    meter.apply(Some(ChargeSymbol::Bit1), &SHAPE)?;
    meter.release()
}

/// Connects, applies two symbols, releases; asserts that an error tells the truth about the bias.
fn short_run(pretended: &PretendedMeter) -> Option<(String, Option<bool>)> {
    let mut meter = match connect(pretended) {
        Ok(meter) => meter,
        Err(MeterError::Port(error)) => return Some((error.to_string(), Some(error.is_released))),
        Err(error) => return Some((error.to_string(), None)),
    };
    let error = symbols(&mut meter).err()?;
    if error.is_released {
        assert_eq!(pretended.bias_v(), 0.0, "{error}");
    }
    Some((error.to_string(), Some(error.is_released)))
}

/// Words that the sentence of an error names.
fn names(kind: MisbehaviourKind) -> &'static [&'static str] {
    match kind {
        MisbehaviourKind::Disconnect => &["the connection to the meter broke at"],
        // The identity is any text: rubbish is the name of another instrument.
        MisbehaviourKind::Garbage => &["makes no sense", "this program commands"],
        // Half of one character is nothing.
        MisbehaviourKind::HalfAnswer => &["is cut short", "has not answered"],
        // A bias that is not obeyed is read back; without its source a trigger is refused.
        MisbehaviourKind::Silence => &["has not answered", "was commanded", "refuses :TRIG:IMM: -211"],
        MisbehaviourKind::Overload => &[],
        MisbehaviourKind::Refusal => &["the meter refuses", "and reports -113", "with the error -113", "*IDN? for"],
        MisbehaviourKind::WrongBias => &["was commanded"],
    }
}

/// Each kind at each command of a short run, all commands of a kind at once: most of the time is
/// spent waiting.
fn at_every_command(
    is_lasting: bool,
    check: impl Fn(Misbehaviour, &PretendedMeter, Option<(String, Option<bool>)>) + Sync,
) {
    let well = pretended(None);
    assert_eq!(short_run(&well), None);
    let count = well.commands().len();
    for kind in KINDS {
        std::thread::scope(|scope| {
            for at in 0..count {
                let check = &check;
                scope.spawn(move || {
                    let misbehaviour = Misbehaviour { at, is_lasting, kind };
                    let pretended = pretended(Some(misbehaviour));
                    let error = short_run(&pretended);
                    if let Some((sentence, is_released)) = &error {
                        // Whoever refuses each query cannot say so.
                        let is_mute = is_lasting && kind == MisbehaviourKind::Refusal;
                        let sentence_names = names(if is_mute { MisbehaviourKind::Silence } else { kind });
                        assert!(
                            sentence_names.iter().any(|name| sentence.contains(name)),
                            "{misbehaviour:?}: {sentence}"
                        );
                        assert_eq!(
                            sentence.ends_with("take it off by hand"),
                            *is_released == Some(false),
                            "{sentence}"
                        );
                    }
                    check(misbehaviour, &pretended, error);
                });
            }
        });
    }
}

#[test]
fn a_meter_that_misbehaves_once_is_left_at_zero_and_named() {
    let well = pretended(None);
    short_run(&well);
    let commands = well.commands();
    let release = commands.iter().rposition(|command| command == "*IDN?").expect("it resynchronises") - 2;
    at_every_command(false, |misbehaviour, pretended, error| {
        let Misbehaviour { at, kind, .. } = misbehaviour;
        assert_eq!(pretended.bias_v(), 0.0, "{misbehaviour:?}");
        let is_noticed = match kind {
            MisbehaviourKind::Overload => false,
            MisbehaviourKind::WrongBias => commands[at] == ":BIAS:VOLT?",
            MisbehaviourKind::Disconnect | MisbehaviourKind::Garbage | MisbehaviourKind::Refusal => true,
            // An initial state that the meter has anyway.
            _ => commands[at].ends_with('?'),
        };
        if at < release && is_noticed {
            assert!(error.is_some(), "{misbehaviour:?} at {}", commands[at]);
        }
        if let Some((sentence, is_released)) = error {
            // Before the set-up nothing has been commanded that had to be taken back.
            assert_eq!(is_released, (at > 0).then_some(true), "{misbehaviour:?}: {sentence}");
            assert!(at < release, "a release is tried again: {misbehaviour:?}: {sentence}");
        }
    });
}

#[test]
fn a_meter_that_is_lost_is_not_said_to_be_at_zero() {
    at_every_command(true, |misbehaviour, pretended, error| {
        if misbehaviour.kind == MisbehaviourKind::Overload {
            assert_eq!(error, None);
            assert_eq!(pretended.bias_v(), 0.0);
            return;
        }
        if let Some((sentence, is_released)) = &error {
            assert_ne!(*is_released, Some(true), "{misbehaviour:?}: {sentence}");
        }
        // Whoever obeys has obeyed also where nobody could read it.
        let obeys = [MisbehaviourKind::Garbage, MisbehaviourKind::HalfAnswer, MisbehaviourKind::WrongBias];
        if obeys.contains(&misbehaviour.kind) {
            assert_eq!(pretended.bias_v(), 0.0, "{misbehaviour:?}");
        }
        assert!(error.is_some() || pretended.bias_v() == 0.0, "{misbehaviour:?}");
    });
}

#[test]
fn fifty_symbols_alternate_the_biases() {
    let pretended = pretended(None);
    let mut meter = connect(&pretended).expect("a meter");
    assert_eq!(meter.identity(), "Keysight Technologies,E4980A,pretended,0");
    let (begun, mut expected_v) = (Instant::now(), vec![0.0]);
    for k in 0..50 {
        let symbol = match k % 7 {
            0 => None,
            1 | 2 | 5 => Some(ChargeSymbol::Bit1),
            _ => Some(ChargeSymbol::Bit0),
        };
        let parts_v = symbol.map_or([0.0; 2], |symbol| SHAPE.parts(symbol).map(|(bias_v, _)| bias_v));
        let readings = meter.apply(symbol, &SHAPE).expect("a symbol");
        for (reading, bias_v) in readings.into_iter().zip(parts_v) {
            // Ten digits.
            let reading_f = reading.expect("no overload");
            assert!((reading_f / capacitance_f(bias_v) - 1.0).abs() < 1e-9, "{reading_f}");
        }
        expected_v.extend(parts_v);
    }
    // Never ahead of the grid; how far behind depends on the machine.
    assert!(begun.elapsed() >= Duration::from_secs(1));
    assert_eq!(meter.late().symbols, 50);
    meter.release().expect("released");
    expected_v.push(0.0);
    expected_v.dedup();
    let history_v: Vec<f64> = pretended.bias_history().into_iter().map(|step| step.bias_v).collect();
    assert_eq!(history_v, expected_v);
    assert!(pretended.commands().contains(&":BIAS:STAT OFF".to_owned()));
    // Ready for another run, and released when it is dropped.
    meter.apply(Some(ChargeSymbol::Bit1), &SHAPE).expect("a symbol");
    assert_eq!(pretended.bias_v(), SHAPE.negative_v);
    drop(meter);
    assert_eq!(pretended.bias_v(), 0.0);
}

#[test]
fn a_panic_leaves_zero() {
    let pretended = pretended(None);
    std::thread::scope(|scope| {
        let run = scope.spawn(|| {
            let mut meter = connect(&pretended).expect("a meter");
            meter.apply(Some(ChargeSymbol::Bit1), &SHAPE).expect("a symbol");
            assert_eq!(pretended.bias_v(), 0.0, "this is the panic");
        });
        assert!(run.join().is_err());
    });
    assert_eq!(pretended.bias_v(), 0.0);
    assert_eq!(pretended.commands().last().map(String::as_str), Some(":BIAS:STAT?"));
}

#[test]
fn overloads_are_readings_that_are_missing() {
    let overload = Misbehaviour { at: 0, is_lasting: true, kind: MisbehaviourKind::Overload };
    let pretended = pretended(Some(overload));
    let mut meter = connect(&pretended).expect("a meter");
    assert_eq!(meter.apply(Some(ChargeSymbol::Bit0), &SHAPE).expect("a symbol"), [None; 2]);
}

#[test]
fn a_bias_beyond_the_limit_is_never_sent() {
    let pretended = pretended(None);
    let mut meter = connect(&pretended).expect("a meter");
    for (positive_v, negative_v) in [(35.1, 0.0), (0.0, -35.1), (f64::NAN, 0.0)] {
        // Also where the symbol itself would be 0 V.
        for symbol in [Some(ChargeSymbol::Bit0), None] {
            let error = meter.apply(symbol, &SymbolShape { positive_v, negative_v, ..SHAPE }).expect_err("refused");
            let wrong_v = if negative_v == 0.0 { positive_v } else { negative_v };
            let expected = format!("a bias of {wrong_v} V is beyond most_bias_v, which is 35 V; the bias is 0 V");
            assert_eq!(error.to_string(), expected);
        }
    }
    assert_eq!(pretended.bias_history().len(), 1, "it has been 0 V all the time");
    assert!(!pretended.commands().iter().any(|command| command.contains("35.1") || command.contains("NaN")));
}

#[test]
fn a_bias_that_the_meter_does_not_have_is_named() {
    let pretended = pretended(None);
    let settings = MeterSettings { most_bias_v: 100.0, ..SETTINGS };
    let mut meter = ScpiMeter::connect(&pretended.address().to_string(), &settings).expect("a meter");
    let error =
        meter.apply(Some(ChargeSymbol::Bit1), &SymbolShape { positive_v: 41.0, ..SHAPE }).expect_err("too much");
    let expected = "the meter has a bias of 0 V, on, where 41 V, on, was commanded, with the error -222,\"Data out of range\"; does it have Option 001";
    assert!(error.is_released && error.sentence.starts_with(expected), "{error}");
}

#[test]
fn shapes_and_settings_that_cannot_be_are_refused() {
    let pretended = pretended(None);
    let address = pretended.address().to_string();
    let mut meter = connect(&pretended).expect("a meter");
    for (second_share, symbol_time_s) in [(0.0, 1.0), (1.0, 1.0), (0.5, f64::NAN), (0.5, 1e30), (-0.5, 1.0)] {
        let error = meter.apply(None, &SymbolShape { second_share, symbol_time_s, ..SHAPE }).expect_err("refused");
        assert!(error.sentence.starts_with("a part of a symbol has a length of"), "{error}");
    }
    for (settings, name) in [
        (MeterSettings { frequency_hz: -1.0, ..SETTINGS }, "frequency_hz is -1"),
        (MeterSettings { level_v: f64::NAN, ..SETTINGS }, "level_v is NaN"),
        (MeterSettings { most_bias_v: f64::INFINITY, ..SETTINGS }, "most_bias_v is inf"),
        (MeterSettings { timeout_s: 1e-9, ..SETTINGS }, "timeout_s is 0.000000001"),
        (MeterSettings { timeout_s: 1e300, ..SETTINGS }, "timeout_s is 1"),
        (MeterSettings { frequency_hz: 1e7, ..SETTINGS }, "the meter refuses :FREQ 10000000: -222"),
    ] {
        let sentence = ScpiMeter::connect(&address, &settings).err().expect("refused").to_string();
        assert!(sentence.starts_with(name), "{sentence}");
    }
}

#[test]
fn another_instrument_is_left_alone() {
    let identity = "Somebody,Power supply,1,2".to_owned();
    let settings = PretendedSettings { identity, ..PretendedSettings::default() };
    let pretended = PretendedMeter::start(settings, device()).expect("the loopback");
    let sentence = connect(&pretended).err().expect("another").to_string();
    assert!(sentence.contains("is \"Somebody,Power supply,1,2\": this program commands a Keysight"), "{sentence}");
    assert_eq!(pretended.commands(), ["*IDN?"]);
}

#[test]
fn a_second_client_that_takes_the_bias_away_is_noticed() {
    let pretended = pretended(None);
    let mut first = connect(&pretended).expect("a meter");
    first.apply(Some(ChargeSymbol::Bit0), &SHAPE).expect("a symbol");
    drop(connect(&pretended).expect("the same meter"));
    assert_eq!(pretended.bias_v(), 0.0);
    let error = first.apply(Some(ChargeSymbol::Bit0), &SHAPE).expect_err("the bias is off");
    let expected = "the meter has a bias of -30 V, off, where -30 V, on, was commanded";
    assert!(error.is_released && error.sentence.starts_with(expected), "{error}");
}

#[test]
fn addresses_where_no_meter_is_are_named() {
    let closed = pretended(None).address().to_string();
    for address in [closed.as_str(), "no-such-meter.invalid"] {
        let sentence = ScpiMeter::connect(address, &SETTINGS).err().expect("nobody").to_string();
        assert!(sentence.starts_with(&format!("no meter can be reached at {address}: ")), "{sentence}");
    }
}

#[test]
fn names_and_addresses_of_six_words_reach_a_meter() {
    let pretended_v4 = pretended(None);
    let name = format!("localhost:{}", pretended_v4.address().port());
    assert!(ScpiMeter::connect(&name, &SETTINGS).is_ok());
    let at: SocketAddr = (Ipv6Addr::LOCALHOST, 0).into();
    // Not every machine has IPv6.
    if let Ok(meter) = PretendedMeter::start(PretendedSettings { at, ..PretendedSettings::default() }, device()) {
        assert!(connect(&meter).is_ok());
    }
}

#[test]
fn a_meter_that_is_too_slow_for_its_symbols_ends_the_run() {
    // A call takes longer than the first part, 14 ms.
    let slow: PretendedDevice = Box::new(|_, _| {
        std::thread::sleep(Duration::from_millis(16));
        Some(1e-12)
    });
    let pretended = PretendedMeter::start(PretendedSettings::default(), slow).expect("the loopback");
    let mut meter = ScpiMeter::connect(&pretended.address().to_string(), &SETTINGS).expect("a meter");
    let error = (0..20).find_map(|_| meter.apply(Some(ChargeSymbol::Bit1), &SHAPE).err()).expect("late");
    assert!(
        error.sentence.starts_with("20 of 20 symbols were late by more than 2 % of a symbol time, the worst by"),
        "{error}"
    );
    assert!(error.is_released && error.sentence.contains("s; a symbol time of"), "{error}");
    let late = meter.late();
    assert!(late.late == 20 && late.worst_s >= 0.002, "{late:?}");
}

#[test]
fn a_reading_that_is_quicker_than_the_last_ones_shortens_no_part() {
    let mut calls = 0;
    let quicker: PretendedDevice = Box::new(move |_, _| {
        calls += 1;
        std::thread::sleep(Duration::from_millis(if calls == 1 { 100 } else { 0 }));
        Some(1e-12)
    });
    let pretended = PretendedMeter::start(PretendedSettings::default(), quicker).expect("the loopback");
    let mut meter = connect(&pretended).expect("a meter");
    let begun = Instant::now();
    meter.apply(Some(ChargeSymbol::Bit1), &SymbolShape { symbol_time_s: 0.2, ..SHAPE }).expect("a symbol");
    // The reading of the start, and a symbol.
    assert!(begun.elapsed() >= Duration::from_millis(300));
}
