//! The loop of a log.

use anyhow::{Context, anyhow, ensure};
use dr_core::Command;
use dr_core::control::{Drive, Refusal, RunState, SelfTestFinding, Trip};
use dr_core::wind::WindCommand;

use super::overheat::{self, Overheat};
use super::tick_time::TickTime;
use super::{Acknowledges, LogCommand, LogEvent, LogHost, LogOptions, LogRequest, LogSummary};
use crate::experiment::Experiment;
use crate::instrument::{InstrumentError, InstrumentPort, LinkReport, setup, why_it_started};
use crate::run::error::{EarlyEnd, RunError};
use crate::run::recorded::{RowBuilder, state_name};
use crate::run::start::{change_drives, setup_of, start};

/// Logs an instrument, heated by the drives of an experiment, until its host ends it.
///
/// # Errors
/// If it does not come to its first row. The instrument is stopped first.
pub fn log(experiment: &Experiment, options: &LogOptions, host: &mut dyn LogHost) -> Result<LogSummary, RunError> {
    let mut session = Session::new(experiment, options, host)?;
    let mut instrument = session.host.connect()?;
    options.continued.into_iter().for_each(|without_s| session.tell(LogEvent::Continued(without_s)));
    session.begin_life(instrument.as_ref());
    let begun = start(&session.experiment, instrument.as_mut()).map(drop);
    let (mut instrument, end) = match begun {
        Ok(()) => session.follow(instrument),
        Err(error) => (Some(instrument), error),
    };
    // Stopped whatever happened: a board must not be left heating.
    let stopped = instrument.take().map(InstrumentPort::finish);
    if session.summary.rows == 0 && !matches!(end, RunError::Interrupted) {
        return Err(end);
    }
    let why = end.to_string();
    let ended = match (end, stopped) {
        (RunError::Interrupted, Some(Ok(_))) => None,
        (RunError::Interrupted, Some(Err(error))) => Some(EarlyEnd::not_stopped(None, &error)),
        (_, Some(Ok(LinkReport { .. }))) => Some(EarlyEnd { why, stopped: true }),
        (_, Some(Err(_)) | None) => Some(EarlyEnd { why, stopped: false }),
    };
    Ok(LogSummary { ended, ..session.summary })
}

struct Session<'a> {
    host: &'a mut dyn LogHost,
    experiment: Experiment,
    options: LogOptions,
    summary: LogSummary,
    times: TickTime,
    overheat: Option<Overheat>,
    acknowledges: Acknowledges,
    first_s: Option<f64>,
    now_s: f64,
    /// Number of changes of the experiment's drives so far.
    changes: usize,
    /// Board and number of its life.
    life: Option<([u32; 3], u32)>,
    state: Option<RunState>,
    state_name: String,
    /// The trip of a board that does not know its sample period any more, and sends no samples.
    mute: Option<Trip>,
    /// For the next row.
    event: String,
}

impl<'a> Session<'a> {
    fn new(experiment: &Experiment, options: &LogOptions, host: &'a mut dyn LogHost) -> Result<Self, RunError> {
        let mut experiment = experiment.clone();
        let refused = |sentence: String| RunError::Instrument(InstrumentError::Unusable(sentence));
        let overheat = match (options.overheat_k, overheat::reference(&experiment)) {
            (None, _) => None,
            (Some(overheat_k), Some(reference)) => {
                let first_c = experiment.gas_temperature_c + overheat_k;
                overheat::set(&mut experiment, first_c).map_err(|refusal| refused(refusal.to_string()))?;
                Some(Overheat::new(overheat_k, reference))
            }
            (Some(_), None) => {
                let sentence = "--overheat: the head has no element `reference` that measures the gas; name set-points";
                return Err(refused(sentence.to_owned()));
            }
        };
        let summary =
            LogSummary { title: experiment.title.clone(), head: experiment.head.name.clone(), ..LogSummary::default() };
        Ok(Self {
            host,
            options: *options,
            summary,
            times: TickTime::new(options.begin_s),
            overheat,
            acknowledges: Acknowledges::default(),
            first_s: None,
            now_s: options.begin_s,
            changes: 0,
            life: None,
            state: None,
            state_name: String::new(),
            mute: None,
            event: String::new(),
            experiment,
        })
    }

    /// Notes whose samples come now; whether it is the life of before.
    fn begin_life(&mut self, instrument: &dyn InstrumentPort) -> bool {
        let identity = instrument.identity();
        self.summary.firmware = identity.firmware.to_string();
        let life = Some((identity.unique_id, identity.starts));
        std::mem::replace(&mut self.life, life) == life
    }

    /// Rows and events until the end; returns why it ended, and the instrument if it is there.
    fn follow(&mut self, mut instrument: Box<dyn InstrumentPort>) -> (Option<Box<dyn InstrumentPort>>, RunError) {
        let mut rows = RowBuilder::new(&self.experiment);
        loop {
            let end = loop {
                if let Err(end) = self.step(instrument.as_mut(), &mut rows) {
                    break end;
                }
            };
            let error = match end {
                RunError::Instrument(error) if self.summary.rows > 0 && self.host.reconnects() => error,
                end => return (Some(instrument), end),
            };
            self.tell(LogEvent::LinkLost(error.to_string()));
            self.summary.gaps += 1;
            drop(instrument);
            instrument = match self.reconnect() {
                Ok(instrument) => instrument,
                Err(end) => return (None, end),
            };
        }
    }

    /// Waits until the board is there again, and makes it send samples, with its heaters as it has
    /// them.
    fn reconnect(&mut self) -> Result<Box<dyn InstrumentPort>, RunError> {
        loop {
            self.host.wait()?;
            while let Some(LogRequest { command, answer }) = self.host.request() {
                match command {
                    LogCommand::Mark(text) => {
                        self.tell(LogEvent::Mark(text));
                        answer(Ok(()));
                    }
                    _ => answer(Err(anyhow!("the board does not answer now"))),
                }
            }
            let Ok(mut instrument) = self.host.connect() else { continue };
            let is_same_life = self.begin_life(instrument.as_ref());
            if !is_same_life {
                self.times.begin_anew();
                if self.resume(instrument.as_mut()).is_err() {
                    // Another try is another life, so that this is done again.
                    self.life = None;
                    continue;
                }
                self.summary.resets += 1;
                let why = why_it_started(instrument.identity());
                self.tell(LogEvent::BoardReset(why));
            }
            self.tell(LogEvent::LinkBack);
            return Ok(instrument);
        }
    }

    /// Sets up a board that has forgotten everything; it stays in standby, or tripped.
    fn resume(&mut self, instrument: &mut dyn InstrumentPort) -> Result<(), RunError> {
        self.mute = None;
        match setup::configure(instrument, &setup_of(&self.experiment)?) {
            Ok(()) => Ok(()),
            Err(InstrumentError::Refused(Refusal::Tripped(trip))) => {
                self.mute = Some(trip);
                self.count_trip(trip);
                Ok(())
            }
            Err(error) => Err(error.into()),
        }
    }

    fn count_trip(&mut self, trip: Trip) {
        let (cause, element) = (trip.cause.name(), setup::place(trip, &self.experiment.head.names()));
        self.summary.trips += 1;
        self.summary.last_trip = Some(format!("{cause}, {element}, at {} s", self.now_s));
        self.tell(LogEvent::Trip { cause, element });
    }

    fn tell(&mut self, event: LogEvent) {
        if !self.event.is_empty() {
            self.event += "; ";
        }
        self.event += &event.to_string();
        self.host.happened(self.now_s, &event);
    }

    fn step(&mut self, instrument: &mut dyn InstrumentPort, rows: &mut RowBuilder) -> Result<(), RunError> {
        while let Some(LogRequest { command, answer }) = self.host.request() {
            let outcome = self.obey(instrument, command);
            answer(outcome);
        }
        self.change_drives(instrument)?;
        let observation = match instrument.observe() {
            // It has told why it is mute; it may still be acknowledged.
            Err(InstrumentError::Silent(_)) if self.mute.is_some() => {
                self.acknowledge(instrument)?;
                return self.host.wait();
            }
            observation => observation?,
        };
        self.tell_findings(instrument);
        let names = self.experiment.head.names();
        if !observation.is_of(names.len()) {
            let sentence = format!("a sample is not one of {} elements, as the head is", names.len());
            return Err(InstrumentError::Protocol(sentence).into());
        }
        let sample = &observation.sample;
        let (time_s, lost) = self.times.of(sample.tick, self.host.elapsed_s(), &self.experiment);
        self.now_s = time_s;
        self.summary.lost += u64::from(lost);
        let changed = self.state != Some(sample.state);
        if changed {
            self.state = Some(sample.state);
            self.state_name = state_name(sample.state, &names);
        }
        let trip = match sample.state {
            RunState::Tripped(trip) if changed => Some(trip),
            _ => None,
        };
        trip.into_iter().for_each(|trip| self.count_trip(trip));
        let event = std::mem::take(&mut self.event);
        // The experiment begins with the log, not with the recording that this continues.
        let since_s = time_s - *self.first_s.get_or_insert(time_s);
        let tick = (since_s / self.experiment.sample_period_s).round() as u32;
        let event = if event.is_empty() { self.experiment.event(tick) } else { &event };
        // Who takes a row may want it to be the last.
        self.summary.rows += 1;
        self.summary.duration_s = since_s;
        self.host.row(&rows.row(&observation, time_s, event, &self.state_name), &observation, self.summary.lost)?;
        if trip.is_some() && self.options.ends_at_trip {
            return Err(RunError::Interrupted);
        }
        if matches!(sample.state, RunState::Tripped(_)) {
            self.acknowledge(instrument)?;
        }
        if let Some(target_c) = self.overheat.as_mut().and_then(|overheat| overheat.add(&observation, &self.experiment))
        {
            self.follow_gas(instrument, target_c)?;
        }
        Ok(())
    }

    /// Drives that the experiment changes with the row that comes.
    fn change_drives(&mut self, instrument: &mut dyn InstrumentPort) -> Result<(), RunError> {
        let since_s = self.first_s.map_or(0.0, |first_s| self.now_s - first_s + self.experiment.sample_period_s);
        while let Some(change) = self.experiment.changes.get(self.changes).cloned()
            && self.experiment.time_s(change.tick) <= since_s + 0.5 * self.experiment.sample_period_s
        {
            self.changes += 1;
            // One that does not run has them at its next start.
            if matches!(self.state, None | Some(RunState::Running)) {
                change_drives(&self.experiment, instrument, &change, &mut |_, _| ())?;
            }
            change.drives.iter().for_each(|&(place, drive)| self.experiment.drives[place] = drive);
        }
        Ok(())
    }

    fn tell_findings(&mut self, instrument: &mut dyn InstrumentPort) {
        for SelfTestFinding { element, faults, .. } in instrument.findings() {
            let names = self.experiment.head.names();
            let name = names.get(usize::from(element)).copied().unwrap_or("?");
            let text = format!("self-test of {name}, faults: {faults}");
            self.tell(LogEvent::Mark(text));
        }
    }

    /// Acknowledges a trip, where that was asked for and may be.
    fn acknowledge(&mut self, instrument: &mut dyn InstrumentPort) -> Result<(), InstrumentError> {
        let trip = match (self.mute, self.state) {
            (Some(trip), _) | (None, Some(RunState::Tripped(trip))) => trip,
            _ => return Ok(()),
        };
        let now_s = self.host.elapsed_s().unwrap_or(self.now_s);
        if !self.options.acknowledges || !self.acknowledges.grant(trip.cause, now_s) {
            return Ok(());
        }
        match instrument.command(Command::Acknowledge) {
            // Still bad: it would trip again.
            Err(InstrumentError::Refused(_)) => return Ok(()),
            outcome => outcome.map(drop)?,
        }
        self.tell(LogEvent::Acknowledged);
        if self.mute.take().is_some() {
            let commands = setup_of(&self.experiment).unwrap_or_default();
            setup::configure(instrument, &commands)?;
        }
        Ok(())
    }

    fn follow_gas(&mut self, instrument: &mut dyn InstrumentPort, target_c: f64) -> Result<(), InstrumentError> {
        if let Err(refusal) = overheat::set(&mut self.experiment, target_c) {
            self.tell(LogEvent::Mark(refusal.to_string()));
            return Ok(());
        }
        let drives = self.experiment.drives.clone();
        let mut held = drives.iter().enumerate().filter(|(_, drive)| overheat::holds(drive));
        held.try_for_each(|(element, drive)| self.drive(instrument, element, *drive)).or_else(|error| match error {
            // A set-point that the models refuse, and a trip meanwhile: the samples tell of it.
            InstrumentError::Refused(refusal) => {
                self.tell(LogEvent::Mark(format!("the gas asks for {target_c:.2} °C: {refusal}")));
                Ok(())
            }
            error => Err(error),
        })
    }

    /// Another drive of an element that runs; one that does not has it at the next start.
    fn drive(
        &mut self,
        instrument: &mut dyn InstrumentPort,
        element: usize,
        drive: Drive,
    ) -> Result<(), InstrumentError> {
        if self.state != Some(RunState::Running) {
            return Ok(());
        }
        instrument.command(setup::ARM)?;
        instrument.command(Command::Drive { element: element as u8, drive })?;
        // An armed instrument would stay so for half a minute.
        instrument.command(Command::Disarm).map(drop)
    }

    /// Does what somebody asks for.
    fn obey(&mut self, instrument: &mut dyn InstrumentPort, command: LogCommand) -> anyhow::Result<()> {
        match command {
            LogCommand::Mark(text) => self.tell(LogEvent::Mark(text)),
            LogCommand::Stop => drop(instrument.command(Command::Stop)?),
            LogCommand::Acknowledge => {
                instrument.command(Command::Acknowledge)?;
                if self.mute.take().is_some() {
                    self.resume(instrument)?;
                }
            }
            LogCommand::Arm => drop(instrument.command(setup::ARM)?),
            LogCommand::Start => {
                // Set-points may have changed while it did not run.
                for (element, drive) in self.experiment.drives.iter().enumerate() {
                    instrument.command(Command::Drive { element: element as u8, drive: *drive })?;
                }
                instrument.command(Command::Start)?;
                self.times.begin_anew();
            }
            LogCommand::SelfTest(plan) => drop(instrument.command(Command::SelfTest(plan))?),
            LogCommand::SetPoint { element, temperature_c } => {
                let names = self.experiment.head.names();
                let place = names.iter().position(|name| *name == element);
                let place = place.with_context(|| format!("`{element}` is no element of the head"))?;
                let (most_c, _) = self.experiment.head.elements[place].config.hottest_set_point();
                if temperature_c.is_nan() || temperature_c > f64::from(most_c) {
                    return Err(overheat::beyond_limit(temperature_c, &element, most_c));
                }
                let drive = Drive::Temperature { target_c: temperature_c as f32 };
                instrument.command(Command::Drive { element: place as u8, drive })?;
                self.experiment.drives[place] = drive;
                self.tell(LogEvent::Mark(format!("set-point of {element}: {temperature_c} °C")));
            }
            LogCommand::Pressure(pressure_pa) => {
                let is_possible = pressure_pa.is_finite() && pressure_pa > 0.0;
                ensure!(is_possible, "a pressure of {pressure_pa} Pa is none of a gas: it stays");
                let calibration = self.experiment.head.calibration.as_ref();
                let has_reference = calibration.is_some_and(|calibration| calibration.reference.is_some());
                let temperature_c = (!has_reference).then_some(self.experiment.gas_temperature_c as f32);
                self.experiment.pressure_pa = pressure_pa;
                if calibration.is_some() {
                    let gas = WindCommand::Gas { pressure_pa: pressure_pa as f32, temperature_c };
                    instrument.command(Command::Wind(gas))?;
                }
                self.tell(LogEvent::Mark(format!("gas pressure: {pressure_pa} Pa")));
            }
        }
        Ok(())
    }
}
