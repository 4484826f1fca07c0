//! The instrument's application: tasks around a decider and an estimator.
//!
//! ```text
//! front end ──► control ──► estimate ──► outbox ──► transmit ──► host
//!                  ▲  └────────────────────┘                      │
//!                  ├───── inbox ◄──── receive ◄───────────────────┘        health: watchdog, status
//!            serve_settings ◄┘                                     serve_settings: settings in flash
//! ```
//!
//! The front end drives everything: a reading raises the vector of `control`, on the sensor board
//! by the ADC's data-ready line, on the virtual board by a frame. What the boards do not share is
//! in [`board`]; what the tasks do, as far as it needs no hardware, is in the library, with tests.
#![no_std]
#![no_main]
// Start-up may panic; the reasons are given there. `cargo xtask safety` checks the rest in the
// image.
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)]

mod board;
mod fault_entry;
mod halt;
mod mcu;
mod settings_loader;
#[cfg(feature = "emulated")]
mod stack;
mod vitals;

use defmt as _;

#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true, dispatchers = [])]
mod app {
    use super::board::table::{CONTROL, DEAD_MAN, ESTIMATE, RECEIVE, SETTINGS, TRANSMIT};
    use super::board::{self, ELEMENTS, FrontEnd, HostReceiver, HostTransmitter, Idler};
    use super::halt;
    use super::mcu::ticking;
    use super::settings_loader::SettingsLoader;
    use super::vitals::{self, CHECK_INS, Health, LoggedWind};
    use dr_core::control::Cause;
    use dr_core::{Command, Digest};
    use firmware::check_ins::Member;
    use firmware::control_loop::{ControlLinks, ControlLoop, ControlShared};
    use firmware::estimates::{self, EstimateJob, EstimateLoop, Estimates};
    use firmware::inbox::{Exchange, Inbox, Outcome, Request, SettingsJob, TelemetryRequests, Wake};
    use firmware::interlock::Interlock;
    use firmware::outbox::{Outbox, Sequence};
    use firmware::phase::Phase;
    use firmware::queue;
    use firmware::settings::{PendingFindings, SettingsServer};
    use heapless::spsc::{Consumer, Producer, Queue};
    use wire::{
        ControlStatus, FromBoard, LinkCounters, MAX_FRAME, Receiver, SettingsAnswer, SettingsRefusal, SettingsRequest,
        ToBoard, encode,
    };

    /// Messages to the host that may wait; at 1 kHz and 921 600 baud the link needs 0.7 ms for a
    /// sample.
    const TELEMETRY_SLOTS: usize = 32;

    static INTERLOCK: Interlock = Interlock::released();
    static PHASE: Phase = Phase::starting();
    static TELEMETRY_REQUESTS: TelemetryRequests = TelemetryRequests::starting();

    #[shared]
    struct Shared {
        inbox: Inbox<'static>,
        outbox: Outbox<'static>,
        outcomes: Producer<'static, Outcome>,
        host_counters: LinkCounters,
        status: Option<wire::Status>,
        /// Findings of the last self-test that are not stored yet.
        findings: PendingFindings,
        /// As it was after the last run of control. The health task copies it once a second, some
        /// 250 bytes, for which the control task waits a microsecond.
        control_status: ControlStatus,
        /// Digest after the last estimated tick, and true if the host gets its estimate.
        estimated: (Digest, bool),
        /// The last wind estimate, for the log.
        wind: Option<LoggedWind>,
    }

    #[local]
    struct Local {
        control: ControlLoop<'static, FrontEnd, ELEMENTS>,
        estimator: EstimateLoop<'static, ELEMENTS>,
        loader: SettingsLoader,
        jobs: Consumer<'static, SettingsJob>,
        answers: Producer<'static, SettingsAnswer>,
        answered: Consumer<'static, SettingsAnswer>,
        messages: Consumer<'static, FromBoard>,
        host_receiver: HostReceiver,
        host_transmitter: HostTransmitter,
        health: Health,
        idler: Idler,
        identity: wire::Identity,
    }

    #[init(local = [
        request_queue: Queue<Request, 8> = Queue::new(),
        exchange_queue: Queue<Exchange, 4> = Queue::new(),
        estimate_queue: Queue<EstimateJob<ELEMENTS>, { estimates::SLOTS }> = Queue::new(),
        order_queue: Queue<Command, 2> = Queue::new(),
        outcome_queue: Queue<Outcome, 2> = Queue::new(),
        job_queue: Queue<SettingsJob, 3> = Queue::new(),
        answer_queue: Queue<SettingsAnswer, 3> = Queue::new(),
        telemetry_queue: Queue<FromBoard, TELEMETRY_SLOTS> = Queue::new(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let (request_in, requests) = cx.local.request_queue.split();
        let (exchange_in, exchanges) = cx.local.exchange_queue.split();
        let (estimate_in, estimates) = cx.local.estimate_queue.split();
        let (message_in, messages) = cx.local.telemetry_queue.split();
        let (order_in, orders) = cx.local.order_queue.split();
        let (outcome_in, outcomes) = cx.local.outcome_queue.split();
        let (job_in, jobs) = cx.local.job_queue.split();
        let (answer_in, answered) = cx.local.answer_queue.split();
        let mut core = cx.core;
        let parts = board::init(cx.device, &mut core, exchanges);
        ticking::start(&mut core.SYST, board::CLOCK_HZ);
        let (reset, past, lockout) = halt::begin(parts.reset);
        defmt::info!("{=str} on the {} board, started by {}", vitals::NAME, board::NAME, board::reset_name(reset));
        if let Some(cause) = past.trip(reset) {
            INTERLOCK.trip(cause);
            PHASE.lock.standby(false);
        }
        let identity = vitals::identity(reset, past);
        // The identity goes first: a host that was connected before the reset must notice the
        // reset.
        rtic::pend(TRANSMIT);
        // Before any command of the host is carried out: they wait until the instrument is set up.
        rtic::pend(SETTINGS);
        let links = ControlLinks {
            requests,
            orders,
            estimates: Estimates::new(estimate_in),
            interlock: &INTERLOCK,
            phase: &PHASE,
            telemetry: &TELEMETRY_REQUESTS,
        };
        (
            Shared {
                inbox: Inbox::new(request_in, exchange_in, job_in, &TELEMETRY_REQUESTS, board::IS_VIRTUAL),
                outbox: Outbox::new(message_in),
                outcomes: outcome_in,
                host_counters: LinkCounters::default(),
                status: None,
                findings: PendingFindings::of(&identity),
                control_status: ControlStatus { history: lockout.history(), ..ControlStatus::default() },
                estimated: (Digest::default(), false),
                wind: None,
            },
            Local {
                control: ControlLoop::new(&board::HARDWARE_LIMITS, lockout, parts.front_end, links),
                estimator: EstimateLoop::new(estimates, &TELEMETRY_REQUESTS),
                loader: SettingsLoader {
                    server: SettingsServer::new(parts.settings),
                    orders: order_in,
                    outcomes,
                    lock: &PHASE.lock,
                    telemetry: &TELEMETRY_REQUESTS,
                },
                jobs,
                answers: answer_in,
                answered,
                messages,
                host_receiver: parts.host_receiver,
                host_transmitter: parts.host_transmitter,
                health: Health::new(parts.watchdog),
                idler: parts.idler,
                identity,
            },
        )
    }

    /// Proves the dead-man timer when that is due, tests clock and memories, and sleeps until an
    /// interrupt. The virtual board waits for its host here and passes on the bytes received.
    #[idle(local = [idler, bench: Receiver = Receiver::new()], shared = [inbox, control_status])]
    // Under its own name in the image, where `cargo xtask safety` looks for it: what runs before it
    // is start-up.
    #[inline(never)]
    fn idle(mut cx: idle::Context) -> ! {
        loop {
            CHECK_INS.check_in(Member::Idle);
            PHASE.prove(|| {
                // Of what control uses, so that control waits, and the dead-man timer does not.
                cx.shared.control_status.lock(|_| INTERLOCK.prove(|| cx.local.idler.prove_dead_man()))
            });
            if let Some(cause) = cx.local.idler.check() {
                INTERLOCK.trip(cause);
                rtic::pend(CONTROL);
            }
            for &byte in cx.local.idler.wait() {
                if let Some(received) = cx.local.bench.push::<ToBoard>(byte) {
                    PHASE.host_heard.raise();
                    wake(cx.shared.inbox.lock(|inbox| inbox.accept(&received)));
                }
            }
        }
    }

    /// The dead-man timer expires: levels have not been updated for two ticks. Priority 6, above
    /// all others, so that neither a silent front end nor the control task can delay it. Uses
    /// nothing that other tasks own.
    #[task(binds = TIM5, priority = 6)]
    fn dead_man(_: dead_man::Context) {
        board::heaters_low();
        board::acknowledge_dead_man();
        INTERLOCK.expire();
    }

    /// The supply falls: brown-out and reset may follow. Priority 6, as the dead-man timer. Raised
    /// by the voltage detector, and by `health` as long as the supply is low.
    #[cfg(feature = "stm32f4")]
    #[task(binds = PVD, priority = 6)]
    fn supply_low(_: supply_low::Context) {
        board::heaters_low();
        board::acknowledge_supply();
        INTERLOCK.trip(Cause::BrownOut);
        rtic::pend(CONTROL);
    }

    /// Owns the decider ([`ControlLoop`]). Priority 5: only the dead-man timer and a falling supply
    /// interrupt a decision.
    ///
    /// Deadline: the next reading; on the sensor board the next conversion, which would otherwise
    /// still see the old levels. A missed deadline counts as a late tick; the heaters keep their
    /// levels until this tick is through, at most for two ticks: then the dead-man timer lowers
    /// them, and this task trips. Never logs, never waits: replies and samples go into a queue, and
    /// what does not fit is dropped and counted. What it shares no other task of its priority has,
    /// so that its locks cost nothing.
    #[task(binds = EXTI4, priority = 5, local = [control], shared = [outbox, outcomes, findings, control_status, estimated])]
    fn control(cx: control::Context) {
        CHECK_INS.check_in(Member::Control);
        let control::SharedResources { outbox, outcomes, findings, control_status, estimated, .. } = cx.shared;
        let woken = (outbox, outcomes, findings, control_status, estimated).lock(
            |outbox, outcomes, findings, status, estimated| {
                cx.local.control.run(&mut ControlShared { outbox, outcomes, findings, status, estimated: *estimated })
            },
        );
        if woken.acknowledged {
            halt::acknowledge();
        }
        if woken.lockout {
            halt::write_lockout(&cx.local.control.kept_lockout);
        }
        for (is_woken, vector) in [(woken.transmit, TRANSMIT), (woken.estimate, ESTIMATE), (woken.settings, SETTINGS)] {
            if is_woken {
                rtic::pend(vector);
            }
        }
    }

    /// Estimates the wind of the ticks that control has decided ([`EstimateLoop`]), and answers the
    /// commands that concern it. Priority 2, below the links: the wind decides nothing. As many
    /// ticks may wait as the queue has room for; one that finds it full is lost and counted, and the
    /// estimate is starting anew.
    #[task(binds = UART5, priority = 2, local = [estimator], shared = [outbox, outcomes, estimated, wind])]
    fn estimate(mut cx: estimate::Context) {
        CHECK_INS.check_in(Member::Estimate);
        while let Some(outcome) = cx.local.estimator.estimate_one() {
            if board::IS_VIRTUAL {
                let has_wind = matches!(outcome.to_host, Some(FromBoard::Wind(_)));
                let digest = cx.local.estimator.digest(outcome.wind.as_ref());
                cx.shared.estimated.lock(|estimated| *estimated = (digest, has_wind));
            }
            if let Some(wind) = &outcome.wind {
                cx.shared.wind.lock(|last| *last = Some(LoggedWind::of(wind)));
            }
            if outcome.has_flipped {
                INTERLOCK.trip(Cause::BitFlip);
                rtic::pend(CONTROL);
            }
            if let Some(message) = outcome.to_host {
                cx.shared.outbox.lock(|outbox| outbox.put(message));
                rtic::pend(TRANSMIT);
            }
            if let Some(result) = outcome.to_loader {
                cx.shared.outcomes.lock(|outcomes| queue::put(outcomes, result)).ok();
            }
            cx.local.estimator.done();
        }
        if board::IS_VIRTUAL {
            // Its front end gets a reply when all is estimated.
            rtic::pend(CONTROL);
        }
    }

    /// Takes the host's bytes. Priority 4; bytes wait in the receiver's buffer meanwhile (5.5 ms of
    /// them on the sensor board), and those that come later still are lost, which their frame's
    /// checksum shows.
    #[task(binds = USART2, priority = 4, local = [host_receiver, link: Receiver = Receiver::new()], shared = [inbox, host_counters])]
    fn receive(mut cx: receive::Context) {
        CHECK_INS.check_in(Member::Receive);
        let foreign = cx.local.link.counters().foreign;
        while let Some(byte) = cx.local.host_receiver.read() {
            if let Some(received) = cx.local.link.push::<ToBoard>(byte) {
                PHASE.host_heard.raise();
                wake(cx.shared.inbox.lock(|inbox| inbox.accept(&received)));
            }
        }
        if let Some(version) = cx.local.link.foreign_version()
            && cx.local.link.counters().foreign != foreign
        {
            // Any frame of ours shows such a host our version.
            TELEMETRY_REQUESTS.identity.raise();
            rtic::pend(TRANSMIT);
            defmt::warn!(
                "the host speaks version {=u8} of the wire protocol, this board {=u8}",
                version,
                wire::VERSION
            );
        }
        cx.shared.host_counters.lock(|counters| *counters = cx.local.link.counters());
    }

    /// Takes the simulated front end's bytes. Priority 4, as `receive`.
    #[cfg(feature = "virtual-board")]
    #[task(binds = USART1, priority = 4, local = [bench: Receiver = Receiver::new()], shared = [inbox])]
    fn bench(mut cx: bench::Context) {
        while let Some(byte) = board::read_bench_byte() {
            if let Some(received) = cx.local.bench.push::<ToBoard>(byte) {
                PHASE.host_heard.raise();
                wake(cx.shared.inbox.lock(|inbox| inbox.accept(&received)));
            }
        }
    }

    /// Sends what waits. Priority 3; 31 messages may wait meanwhile, and what finds it full is
    /// counted.
    #[task(binds = SPI3, priority = 3, local = [messages, answered, host_transmitter, identity, sequence: Sequence = Sequence::new()], shared = [status, outbox])]
    fn transmit(mut cx: transmit::Context) {
        let transmit::LocalResources { messages, answered, host_transmitter, identity, sequence, .. } = cx.local;
        if host_transmitter.is_well() {
            CHECK_INS.check_in(Member::Transmit);
        }
        while host_transmitter.is_free() {
            let mut number = || sequence.next(cx.shared.outbox.lock(|outbox| outbox.unsent));
            if TELEMETRY_REQUESTS.identity.take() {
                if PHASE.acknowledged.is_raised() {
                    identity.crash = None;
                }
                transmit_one(host_transmitter, number(), &FromBoard::Identity(identity.clone()));
            } else if let Some(message) = messages.peek() {
                // Sent where it stands: messages have room for many elements, and are slow to move.
                transmit_one(host_transmitter, number(), message);
                messages.dequeue();
            } else if let Some(answer) = answered.dequeue() {
                transmit_one(host_transmitter, number(), &FromBoard::Setting(answer));
            } else if let Some(status) = cx.shared.status.lock(|status| status.take()) {
                transmit_one(host_transmitter, number(), &FromBoard::Status(status));
            } else {
                break;
            }
        }
    }

    fn transmit_one(transmitter: &mut HostTransmitter, number: u16, message: &FromBoard) {
        if let FromBoard::Event(event) = message {
            vitals::log_event(event);
        }
        let mut buffer = [0; MAX_FRAME];
        if let Ok(frame) = encode(number, message, &mut buffer) {
            transmitter.send(frame);
        }
    }

    /// Owns the settings in flash: sets the instrument up at a start, and carries out the host's
    /// requests. Priority 1, below all others, since it waits for the flash; two requests may wait
    /// meanwhile. It checks in with every request, setting and write. [`StandbyLock`] excludes writing to the flash while the instrument runs.
    #[task(binds = SPI2, priority = 1, local = [loader, jobs, answers], shared = [findings])]
    fn serve_settings(mut cx: serve_settings::Context) {
        let serve_settings::LocalResources { loader, jobs, answers, .. } = cx.local;
        loop {
            CHECK_INS.check_in(Member::Settings);
            if PHASE.set_up_due.take() {
                set_up(loader);
            }
            if PHASE.lock.try_take() {
                if let Some(test) = cx.shared.findings.lock(PendingFindings::take) {
                    loader.server.keep(&test);
                }
                resume();
            }
            let Some((to, request)) = jobs.dequeue() else { break };
            let mut result = Err(SettingsRefusal::NotInStandby);
            if PHASE.lock.try_take() {
                let is_load = request == SettingsRequest::Load;
                if is_load {
                    set_up(loader);
                }
                if !is_load || PHASE.set_up.is_raised() {
                    result = loader.server.answer(&request);
                }
                resume();
            }
            // A host that does not wait for replies loses some of them.
            queue::put(answers, SettingsAnswer { to, result }).ok();
            rtic::pend(TRANSMIT);
        }
    }

    fn set_up(loader: &mut SettingsLoader) {
        PHASE.set_up.set(loader.set_up());
        resume();
    }

    /// The host's commands go on.
    fn resume() {
        PHASE.lock.give_back();
        rtic::pend(CONTROL);
    }

    /// Twenty times a second: feeds the watchdog if every task has checked in, and clears the
    /// check-ins. Once a second: status. Priority 3; late by more than the watchdog's half second
    /// resets the board.
    #[task(binds = SysTick, priority = 3, local = [health], shared = [status, host_counters, inbox, outbox, control_status, wind])]
    fn health(mut cx: health::Context) {
        if cx.local.health.beat(INTERLOCK.cut.is_raised()) {
            let status = wire::Status {
                uptime_s: cx.local.health.uptime_s,
                link: cx.shared.host_counters.lock(|counters| *counters),
                refused: cx.shared.inbox.lock(|inbox| inbox.refused),
                unsent: cx.shared.outbox.lock(|outbox| outbox.unsent),
                deadlines: INTERLOCK.deadlines(),
                control: cx.shared.control_status.lock(|status| status.clone()),
            };
            cx.shared.status.lock(|slot| *slot = Some(status));
            if let Some(wind) = cx.shared.wind.lock(Option::take) {
                wind.log();
            }
        }
        #[cfg(feature = "stm32f4")]
        if board::is_supply_low() {
            rtic::pend(board::table::SUPPLY);
        }
        [CONTROL, RECEIVE, TRANSMIT, ESTIMATE, SETTINGS].into_iter().for_each(rtic::pend);
    }

    /// Half of the sensor board's receive buffer is full, and the host is still speaking. Priority
    /// 4, as `receive`.
    #[cfg(feature = "stm32f4")]
    #[task(binds = DMA1_STREAM5, priority = 4)]
    fn filled(_: filled::Context) {
        board::acknowledge_received();
        rtic::pend(RECEIVE);
    }

    /// The sensor board's transmitter has sent its frame: there may be more. Priority 3, as
    /// `transmit`.
    #[cfg(feature = "stm32f4")]
    #[task(binds = DMA1_STREAM6, priority = 3)]
    fn sent(_: sent::Context) {
        board::acknowledge_sent();
        rtic::pend(TRANSMIT);
    }

    fn wake(who: Wake) {
        match who {
            Wake::Control => rtic::pend(CONTROL),
            Wake::Stop(sequence) => {
                INTERLOCK.stop(sequence);
                rtic::pend(CONTROL);
            }
            Wake::Transmit => rtic::pend(TRANSMIT),
            Wake::SettingsServer => rtic::pend(SETTINGS),
            Wake::Finish(code) => board::finish(code),
            Wake::Silence(sequence) => {
                if board::silence(sequence) {
                    rtic::pend(DEAD_MAN);
                }
                rtic::pend(CONTROL);
            }
            Wake::Provoke(what) => board::provoke(what),
            Wake::Nobody => {}
        }
    }
}
