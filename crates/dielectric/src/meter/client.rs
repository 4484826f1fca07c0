//! The meter as a device port, and its settings.

use crate::port::{ChargeSymbol, DevicePort, PortError, SymbolReadings, SymbolShape};
use std::time::{Duration, Instant};

use super::error::MeterError;
use super::link::{MeterLink, capacitance_f, number, switch};
use super::symbol_clock::{LateSymbols, SymbolClock};

/// Coarsest step of the meter's bias source, 20 V and above: a bias is read back as near as that.
const BIAS_STEP_V: f64 = 0.005;
/// A medium measurement takes 0.1 s; a shorter part that is several times longer has room for it.
const ROOM_FOR_MEDIUM_S: f64 = 0.4;
/// Share of late symbols beyond which a run ends, unless somebody chose another.
const MOST_LATE: f64 = 0.1;
/// One over the readings over which the time of one is smoothed: a hiccup of the network shall not
/// move the next triggers to where the membrane still settles.
const SMOOTHING: u32 = 8;

/// An E4980A at the end of a TCP connection.
///
/// Dropping it leaves the bias at 0 V and off, as far as the meter can be reached. What ends this
/// program without that, as a power cut does, leaves the bias on: the meter has no dead-man timer.
///
/// ```no_run
/// use dielectric::meter::{MeterSettings, ScpiMeter};
/// use dielectric::port::{ChargeSymbol, DevicePort, SymbolShape};
///
/// let settings = MeterSettings { frequency_hz: 1e6, level_v: 0.1, most_bias_v: 20.0, timeout_s: 5.0 };
/// let mut meter = ScpiMeter::connect("192.168.0.17", &settings)?;
/// let shape = SymbolShape { positive_v: 10.0, negative_v: -20.0, second_share: 0.5, symbol_time_s: 0.1 };
/// println!("{:?}", meter.apply(Some(ChargeSymbol::Bit1), &shape)?);
/// meter.release()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct ScpiMeter {
    link: MeterLink,
    identity: String,
    settings: MeterSettings,
    clock: SymbolClock,
    most_late: f64,
    /// Time that a reading takes.
    reading: Duration,
    /// The meter has confirmed 0 V and off, and has not been commanded otherwise since.
    is_released: bool,
}

impl ScpiMeter {
    /// Connects to `HOST` or `HOST:PORT` (5025 if there is none), and sets the meter up with a bias
    /// of 0 V, on.
    ///
    /// # Errors
    /// If settings or address are wrong, nobody answers, another instrument does, or a command of
    /// the set-up is refused.
    pub fn connect(address: &str, settings: &MeterSettings) -> Result<Self, MeterError> {
        let timeout = settings.check()?;
        let mut link = MeterLink::connect(address, timeout)?;
        let identity = link.identity()?;
        if !identity.split(',').nth(1).is_some_and(|model| model.trim().starts_with("E4980A")) {
            return Err(MeterError::Other(format!(
                "{address} is {identity:?}: this program commands a Keysight or Agilent E4980A, nothing has been set"
            )));
        }
        let (settings, clock) = (*settings, SymbolClock::default());
        let (most_late, reading, is_released) = (MOST_LATE, Duration::ZERO, false);
        let mut meter = Self { link, identity, settings, clock, most_late, reading, is_released };
        let set_up = meter.set_up();
        set_up.map_err(|error| meter.fail(error))?;
        Ok(meter)
    }

    /// Ends a run when more than this share of its symbols are late, instead of a tenth; 1 for
    /// never.
    pub fn with_most_late(mut self, share: f64) -> Self {
        self.most_late = share;
        self
    }

    /// The meter's answer to `*IDN?`: manufacturer, model, serial number, firmware.
    pub fn identity(&self) -> &str {
        &self.identity
    }

    /// Symbols so far, and those that were late.
    pub fn late(&self) -> LateSymbols {
        self.clock.counted
    }

    fn set_up(&mut self) -> Result<(), MeterError> {
        let MeterSettings { frequency_hz, level_v, .. } = self.settings;
        // Errors that others have left in the queue are no refusals.
        self.link.command("*CLS")?;
        self.link.command("*RST")?;
        self.link.command(":FUNC:IMP CPD")?;
        self.link.command(&format!(":FREQ {frequency_hz}"))?;
        self.link.command(&format!(":VOLT {level_v}"))?;
        self.link.command(":FORM:ASC:LONG ON")?;
        self.link.command(":TRIG:SOUR BUS")?;
        self.link.command(":INIT:CONT OFF")?;
        self.is_released = false;
        self.link.command(":BIAS:VOLT 0")?;
        self.link.command(":BIAS:STAT ON")?;
        self.confirm(0.0, true)
    }

    /// Begins a run. The bias is off since the last one, and a meter that has restarted meanwhile
    /// has forgotten its set-up.
    fn begin_run(&mut self, shape: &SymbolShape) -> Result<(), MeterError> {
        self.set_up()?;
        let shorter_s = shape.symbol_time_s * shape.second_share.min(1.0 - shape.second_share);
        self.link.command(if shorter_s >= ROOM_FOR_MEDIUM_S { ":APER MED" } else { ":APER SHOR" })?;
        let begun = Instant::now();
        self.read_capacitance_f()?;
        self.reading = begun.elapsed();
        Ok(())
    }

    fn apply_symbol(
        &mut self,
        symbol: Option<ChargeSymbol>,
        shape: &SymbolShape,
    ) -> Result<SymbolReadings, MeterError> {
        self.settings.allow(shape.positive_v)?;
        self.settings.allow(shape.negative_v)?;
        let parts = match symbol {
            Some(symbol) => shape.parts(symbol),
            None => shape.parts(ChargeSymbol::Bit0).map(|(_, length_s)| (0.0, length_s)),
        };
        let [first, second] = [length(parts[0].1)?, length(parts[1].1)?];
        if !self.clock.is_running() {
            self.begin_run(shape)?;
        }
        let begins = self.clock.begin(Instant::now(), first + second);
        let mut readings = [None; 2];
        let mut work = Duration::ZERO;
        for (i, ends) in [begins + first, begins + first + second].into_iter().enumerate() {
            let (reading, took) = self.apply_part(parts[i].0, ends)?;
            readings[i] = reading;
            work = work.max(took);
        }
        self.clock.end(shape, work, self.most_late)?;
        Ok(readings)
    }

    /// One part: its reading, and what bias and reading took.
    fn apply_part(&mut self, bias_v: f64, ends: Instant) -> Result<(Option<f64>, Duration), MeterError> {
        let begun = Instant::now();
        self.is_released = false;
        self.link.send(&format!(":BIAS:VOLT {bias_v}"))?;
        self.confirm(bias_v, true)?;
        let biased = begun.elapsed();
        sleep_until(ends.checked_sub(self.reading).unwrap_or(ends));
        let begun = Instant::now();
        let reading = self.read_capacitance_f()?;
        let took = begun.elapsed();
        self.reading = (self.reading * (SMOOTHING - 1) + took) / SMOOTHING;
        sleep_until(ends);
        self.clock.note(Instant::now(), ends);
        Ok((reading, biased + took))
    }

    fn read_capacitance_f(&mut self) -> Result<Option<f64>, MeterError> {
        // Refused, it would leave the reading before this one to be fetched.
        self.link.command(":TRIG:IMM")?;
        let (complete, command) = ("*OPC?", ":FETC?");
        switch(complete, &self.link.query(complete)?)?;
        capacitance_f(command, &self.link.query(command)?)
    }

    /// Reads the bias back: a meter without Option 001, another program or a finger on the front
    /// panel may have set it otherwise.
    fn confirm(&mut self, commanded_v: f64, commanded_on: bool) -> Result<(), MeterError> {
        let (voltage, state) = (":BIAS:VOLT?", ":BIAS:STAT?");
        let found_v = number(voltage, &self.link.query(voltage)?)?;
        let found_on = switch(state, &self.link.query(state)?)?;
        if (found_v - commanded_v).abs() <= BIAS_STEP_V && found_on == commanded_on {
            return Ok(());
        }
        let reason = self.link.next_error()?.map_or_else(String::new, |error| format!(", with the error {error}"));
        let [found, commanded] = [found_on, commanded_on].map(|is_on| if is_on { "on" } else { "off" });
        Err(MeterError::Other(format!(
            "the meter has a bias of {found_v} V, {found}, where {commanded_v} V, {commanded}, was commanded{reason}; does it have Option 001, and does nobody else use it?"
        )))
    }

    /// 0 V and off, confirmed; at a second try over a new connection.
    fn make_safe(&mut self) -> Result<(), MeterError> {
        self.clock.stop();
        if let Err(first) = self.command_zero() {
            // Why the first connection was of no use says more than why there is no second one.
            self.link.reconnect().map_err(|_| first)?;
            self.command_zero()?;
        }
        self.is_released = true;
        Ok(())
    }

    fn command_zero(&mut self) -> Result<(), MeterError> {
        // An empty line ends what an error may have cut off. Nothing is waited for before 0 V is
        // commanded; answers that are still to come are dropped after it.
        self.link.send("")?;
        self.link.send(":BIAS:VOLT 0")?;
        self.link.send(":BIAS:STAT OFF")?;
        self.link.resynchronise(&self.identity)?;
        self.confirm(0.0, false)
    }

    fn fail(&mut self, error: MeterError) -> PortError {
        let is_released = self.make_safe().is_ok();
        let mut sentence = error.to_string();
        // A query that the meter refuses has no answer.
        if matches!(error, MeterError::Silent { .. })
            && is_released
            && let Ok(Some(reason)) = self.link.next_error()
        {
            sentence.push_str(&format!(" and reports {reason}"));
        }
        PortError { sentence, is_released }
    }
}

impl DevicePort for ScpiMeter {
    fn apply(&mut self, symbol: Option<ChargeSymbol>, shape: &SymbolShape) -> Result<SymbolReadings, PortError> {
        let readings = self.apply_symbol(symbol, shape);
        readings.map_err(|error| self.fail(error))
    }

    fn release(&mut self) -> Result<(), PortError> {
        self.make_safe().map_err(|error| PortError { sentence: error.to_string(), is_released: false })
    }
}

impl Drop for ScpiMeter {
    fn drop(&mut self) {
        if !self.is_released {
            // Nobody is left to whom an error could be given.
            self.make_safe().ok();
        }
    }
}

fn length(part_s: f64) -> Result<Duration, MeterError> {
    let possible = Duration::from_micros(1)..=Duration::from_secs(86_400);
    let length = Duration::try_from_secs_f64(part_s).ok().filter(|length| possible.contains(length));
    length.ok_or_else(|| {
        MeterError::Other(format!("a part of a symbol has a length of {part_s} s: 0.000001 to 86400 s is possible"))
    })
}

fn sleep_until(moment: Instant) {
    std::thread::sleep(moment.saturating_duration_since(Instant::now()));
}

/// Settings of the measurement, and the largest bias.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeterSettings {
    /// Frequency of the oscillator, Hz.
    pub frequency_hz: f64,
    /// Level of the oscillator, V rms. It pulls at the membrane as a bias does.
    pub level_v: f64,
    /// Largest bias of either sign that may reach the device, V.
    pub most_bias_v: f64,
    /// Time that a connection or an answer may take, s: longer than a measurement and a reset,
    /// which take up to a second at low frequencies.
    pub timeout_s: f64,
}

impl MeterSettings {
    /// The time-out.
    fn check(&self) -> Result<Duration, MeterError> {
        let positive = [("frequency_hz", self.frequency_hz), ("level_v", self.level_v), ("timeout_s", self.timeout_s)];
        let wrong = positive.into_iter().find(|(_, value)| !(value.is_finite() && *value > 0.0));
        if let Some((name, value)) = wrong {
            return Err(MeterError::Other(format!("{name} is {value}: a number above 0 is needed")));
        }
        if !(self.most_bias_v.is_finite() && self.most_bias_v >= 0.0) {
            let value = self.most_bias_v;
            return Err(MeterError::Other(format!("most_bias_v is {value}: a number from 0 is needed")));
        }
        // A socket refuses a time-out of zero, which a very small one would round to.
        let timeout = Duration::try_from_secs_f64(self.timeout_s).unwrap_or(Duration::MAX);
        if timeout < Duration::from_millis(1) || timeout > Duration::from_secs(3600) {
            let value = self.timeout_s;
            return Err(MeterError::Other(format!("timeout_s is {value}: 0.001 to 3600 is possible")));
        }
        Ok(timeout)
    }

    /// Tells whether a bias may be applied.
    fn allow(&self, bias_v: f64) -> Result<(), MeterError> {
        let most_v = self.most_bias_v;
        // Also refuses what is not a number.
        if bias_v.abs() <= most_v {
            return Ok(());
        }
        Err(MeterError::Other(format!("a bias of {bias_v} V is beyond most_bias_v, which is {most_v} V")))
    }
}
