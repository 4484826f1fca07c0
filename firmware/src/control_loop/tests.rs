//! The loop around a board that only remembers what it was told.

use super::*;
use crate::estimates::{EstimateJob, EstimateLoop, SLOTS};
use dr_core::control::{Drive, ElementConfig, Limits, Trip};
use dr_core::model::{GainsConfig, NetworkSelfHeatingConfig, mesh};
use dr_core::sensor::{Channel, Level, Platinum};
use dr_core::wind::{HeadSurface, WindCommand, WindOutputConfig, sphere};
use dr_core::{Handover, Reply};
use heapless::spsc::Queue;
use std::cell::Cell;
use std::collections::VecDeque;
use std::vec::Vec;
use wire::{List, Name};

const VOLT_PER_CODE: f32 = 4.0 / 8_388_608.0;

/// An element of −50 °C at a level.
fn code(level: Level) -> Reading {
    let current_a = if level == Level::High { 16e-3 } else { 3e-3 };
    Reading::Code((175.0 * (1.0 - 0.0031 * 50.0) * current_a / VOLT_PER_CODE) as i32)
}

#[derive(Default)]
struct MockBoard<'a> {
    readings: VecDeque<[Reading; 1]>,
    levels: usize,
    lowered: u32,
    /// Event while levels are put on the pins.
    meanwhile: Option<&'a dyn Fn()>,
    /// True for each reply that had everything estimated.
    drained: Vec<bool>,
    holds: Cell<bool>,
}

impl ControlBoard<1> for MockBoard<'_> {
    fn poll(&mut self) -> Option<[Reading; 1]> {
        self.readings.pop_front()
    }
    fn apply(&mut self, tick: &Tick<1>) -> bool {
        self.levels = tick.heaters.0;
        self.meanwhile.iter().for_each(|happens| happens());
        true
    }
    fn holds_levels(&mut self) -> bool {
        self.holds.get()
    }
    fn heaters_low(&mut self) {
        (self.levels, self.lowered) = (0, self.lowered + 1);
    }
    fn lower(&mut self) -> bool {
        std::mem::take(&mut self.levels) != 0
    }
    fn select(&mut self, _: FrontEndInput) {}
    fn restart(&mut self) {}
    fn set_sample_period(&mut self, _: f32) -> Result<(), ConfigError> {
        Ok(())
    }
    fn overran(&mut self) -> bool {
        false
    }
    fn take_fault(&mut self) -> Option<Cause> {
        None
    }
    fn reply(&mut self, estimated: Option<(Digest, bool)>) -> Option<FromBoard> {
        self.drained.push(estimated.is_some());
        None
    }
}

/// Parts that a test works with.
struct Bench<'a> {
    control: ControlLoop<'a, MockBoard<'a>, 1>,
    estimator: EstimateLoop<'a, 1>,
    host: Producer<'a, Request>,
    sent: Consumer<'a, FromBoard>,
    outbox: Outbox<'a>,
    outcomes: Producer<'a, Outcome>,
    findings: PendingFindings,
    status: ControlStatus,
    sequence: u16,
}

impl Bench<'_> {
    fn run(&mut self) -> Woken {
        let Self { outbox, outcomes, findings, status, .. } = self;
        let estimated = (Digest::default(), false);
        self.control.run(&mut ControlShared { outbox, outcomes, findings, status, estimated })
    }

    fn tick(&mut self, reading: Reading) {
        self.control.board.readings.push_back([reading]);
        self.run();
    }

    fn estimate(&mut self) -> u32 {
        let mut items = 0;
        while let Some(outcome) = self.estimator.estimate_one() {
            outcome.to_host.into_iter().for_each(|message| self.outbox.put(message));
            self.estimator.done();
            items += 1;
        }
        items
    }

    fn ask(&mut self, command: Command) {
        self.sequence += 1;
        self.host.enqueue((self.sequence, command)).unwrap();
    }

    /// Sends a command; returns the reply.
    fn tell(&mut self, command: Command) -> Result<Reply, Refusal> {
        self.ask(command);
        self.run();
        self.estimate();
        let mut replies = self.sent().into_iter().filter_map(|message| match message {
            FromBoard::Reply { to, result } => Some((to, result)),
            _ => None,
        });
        let (to, result) = replies.next().unwrap();
        assert_eq!((to, replies.next()), (self.sequence, None));
        result
    }

    fn sent(&mut self) -> Vec<FromBoard> {
        std::iter::from_fn(|| self.sent.dequeue()).collect()
    }

    fn set_up(&mut self) {
        let channel = Channel::new(Platinum::linear(175.0, 0.0031).unwrap(), VOLT_PER_CODE, 3e-3, 16e-3).unwrap();
        for command in [
            Command::SamplePeriod { sample_period_s: 0.01 },
            Command::Element { element: 0, config: ElementConfig { channel, limits: Limits::SPHERE_B } },
            Command::Drive { element: 0, drive: Drive::Level(Level::High) },
        ] {
            self.tell(command).unwrap();
        }
    }

    fn start(&mut self) {
        self.set_up();
        self.tell(Command::Arm { window_s: 10.0 }).unwrap();
        self.tell(Command::Start).unwrap();
        self.tick(code(Level::Low));
        assert_eq!((self.control.board.levels, self.status.state), (1, RunState::Running));
    }
}

fn with_bench(meanwhile: Option<&dyn Fn()>, interlock: &Interlock, phase: &Phase, test: impl FnOnce(&mut Bench)) {
    let (mut requests, mut orders) = (Queue::<_, 8>::new(), Queue::<_, 2>::new());
    let (mut estimates, mut outcomes) = (Queue::<EstimateJob<1>, SLOTS>::new(), Queue::<_, 2>::new());
    let mut messages = Queue::<_, 32>::new();
    let telemetry = TelemetryRequests::starting();
    let ((host, requests), (estimate_in, estimates)) = (requests.split(), estimates.split());
    let (message_in, sent) = messages.split();
    let estimates_in = Estimates::new(estimate_in);
    let links = ControlLinks {
        requests,
        orders: orders.split().1,
        estimates: estimates_in,
        interlock,
        phase,
        telemetry: &telemetry,
    };
    let board = MockBoard { meanwhile, holds: Cell::new(true), ..MockBoard::default() };
    phase.lock.give_back();
    test(&mut Bench {
        control: ControlLoop::new(&HardwareLimits::SIMULATED, Lockout::new(), board, links),
        estimator: EstimateLoop::new(estimates, &telemetry),
        host,
        sent,
        outbox: Outbox::new(message_in),
        outcomes: outcomes.split().0,
        findings: PendingFindings::of(&wire::Identity {
            firmware: Name::new(),
            board: wire::BoardKind::Virtual,
            elements: 1,
            order: 8,
            reset: wire::ResetCause::PowerOn,
            starts: 1,
            crash: None,
            unique_id: [0; 3],
        }),
        status: ControlStatus { margins: List::new(), ..ControlStatus::default() },
        sequence: 0,
    });
}

fn trip(cause: Cause) -> RunState {
    RunState::Tripped(Trip::whole(cause))
}

#[test]
fn a_timer_that_expires_while_levels_are_set_lowers_them_and_the_next_tick_trips() {
    let (interlock, phase, expires) = (Interlock::released(), Phase::starting(), Cell::new(false));
    let meanwhile = || {
        if expires.take() {
            interlock.expire();
        }
    };
    with_bench(Some(&meanwhile), &interlock, &phase, |bench| {
        bench.start();
        expires.set(true);
        bench.tick(code(Level::High));
        assert_eq!((bench.control.board.levels, bench.control.board.lowered), (0, 1));
        assert_eq!(bench.status.state, RunState::Running);
        bench.tick(code(Level::Low));
        assert_eq!((bench.control.board.levels, bench.status.state), (0, trip(Cause::Deadline)));
    });
}

#[test]
fn a_requested_trip_comes_before_the_commands_that_wait() {
    let (interlock, phase) = (Interlock::released(), Phase::starting());
    with_bench(None, &interlock, &phase, |bench| {
        bench.set_up();
        bench.tell(Command::Arm { window_s: 10.0 }).unwrap();
        interlock.trip(Cause::BrownOut);
        assert_eq!(bench.tell(Command::Start), Err(Refusal::Tripped(Trip::whole(Cause::BrownOut))));
        assert!(!interlock.forbids());
    });
}

#[test]
fn a_pin_that_does_not_hold_trips_unless_somebody_has_lowered_it() {
    let (interlock, phase) = (Interlock::released(), Phase::starting());
    with_bench(None, &interlock, &phase, |bench| {
        bench.start();
        bench.control.board.holds.set(false);
        bench.tick(code(Level::High));
        assert_eq!(bench.status.state, trip(Cause::Heater));
    });
    with_bench(None, &interlock, &phase, |bench| {
        bench.start();
        bench.control.board.holds.set(false);
        interlock.expire();
        bench.tick(code(Level::High));
        assert_eq!(bench.status.state, trip(Cause::Deadline));
    });
}

#[test]
fn a_stop_makes_void_what_waits_and_commands_wait_for_the_settings() {
    let (interlock, phase) = (Interlock::released(), Phase::starting());
    with_bench(None, &interlock, &phase, |bench| {
        bench.start();
        bench.sent();
        bench.ask(Command::Arm { window_s: 1.0 });
        interlock.stop(900);
        bench.run();
        let stopped = |to| FromBoard::Reply { to, result: Err(Refusal::Stopped) };
        let sent = bench.sent();
        assert_eq!(sent[..2], [stopped(bench.sequence), FromBoard::Reply { to: 900, result: Ok(Reply::Done) }]);
        assert_eq!((bench.control.board.levels, bench.status.state), (0, RunState::Standby));
        assert!(phase.lock.try_take(), "it is standby now");
        bench.ask(Command::Disarm);
        bench.run();
        assert_eq!(bench.sent(), []);
        phase.lock.give_back();
        bench.run();
        assert_eq!(bench.sent(), [FromBoard::Reply { to: bench.sequence, result: Ok(Reply::Done) }]);
    });
}

#[test]
fn ticks_that_find_the_queue_full_are_counted_and_the_next_one_says_so() {
    let (interlock, phase) = (Interlock::released(), Phase::starting());
    with_bench(None, &interlock, &phase, |bench| {
        bench.set_up();
        bench.estimate();
        for n in 0..SLOTS as u32 + 2 {
            bench.tick(code(Level::Low));
            assert_eq!(bench.status.missed_estimates, (n + 2).saturating_sub(SLOTS as u32));
        }
        // Nor is a command carried out, and it is not lost.
        bench.sent();
        bench.ask(Command::Disarm);
        bench.run();
        assert_eq!(bench.sent(), []);
        assert_eq!(bench.control.board.drained.last(), Some(&false), "the front end has no reply yet");
        assert_eq!(bench.estimate(), SLOTS as u32 - 1);
        bench.run();
        assert_eq!((bench.sent().len(), bench.control.board.drained.last()), (1, Some(&true)));
        for follows_gap in [true, false] {
            bench.tick(code(Level::Low));
            let (_, handover) = bench.estimator.item().unwrap();
            assert!(matches!(handover, Handover::Tick { follows_gap: is, .. } if *is == follows_gap));
            bench.estimate();
        }
        assert_eq!(bench.status.missed_estimates, 3);
    });
}

#[test]
fn estimates_come_after_the_sample_of_their_tick_and_replies_of_the_anemometer_to_who_asked() {
    let (interlock, phase) = (Interlock::released(), Phase::starting());
    with_bench(None, &interlock, &phase, |bench| {
        bench.set_up();
        let gains =
            GainsConfig { correction_w_per_k: [0.0; 8], convection_w_per_k: 0.2, weights: [1.0; 2], variance_w2: 1e-8 };
        let config = NetworkSelfHeatingConfig {
            mesh_rad_s: mesh::geometric(1.0, 400.0).unwrap(),
            r_k_per_w: [400.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            surface: [1.0; 8],
            rest_c: -53.0,
            gains,
            alarm: None,
        };
        let surface = sphere::hemispheres(0.01)[0];
        let surface = HeadSurface { element: 0, surface, gain: 1.0, windless_w_k: 0.0 };
        for command in [
            WindCommand::SelfHeating { element: 0, config },
            WindCommand::Surface { surface: 0, config: surface },
            WindCommand::Output(WindOutputConfig {
                surfaces: 1,
                diameter_m: 0.01,
                reynolds: None,
                direction_error_max_rad: 0.5,
                output_interval_ticks: 3,
                reference: None,
                smoothing_s: [0.0, 0.03],
                reference_gas_c: -54.0,
            }),
            WindCommand::Gas { pressure_pa: 700.0, temperature_c: Some(-54.0) },
        ] {
            assert_eq!(bench.tell(Command::Wind(command)), Ok(Reply::Done));
        }
        let mut last = None;
        let mut winds = 0;
        for _ in 0..9 {
            bench.tick(code(Level::Low));
            bench.estimate();
            for message in bench.sent() {
                match message {
                    FromBoard::Sample(sample) => last = Some(sample.tick),
                    FromBoard::Wind(frame) => {
                        assert_eq!((Some(frame.tick), frame.tick % 3, frame.interval_ticks), (last, 0, 3));
                        winds += 1;
                    }
                    other => panic!("{other:?}"),
                }
            }
        }
        assert_eq!(winds, 3);
        let wrong = WindCommand::Gas { pressure_pa: 0.0, temperature_c: None };
        assert!(matches!(bench.tell(Command::Wind(wrong)), Err(Refusal::Invalid { .. })));
    });
}
