//! The instrument's application: five tasks around one controller.
//!
//! ```text
//! front end ──► control ──► outbox ──► transmit ──► host
//!                  ▲                                 │
//!                  ├───── inbox ◄──── receive ◄──────┘        health: watchdog, status
//!            serve_settings ◄┘                         serve_settings: settings in flash
//! ```
//!
//! The front end drives everything: a reading raises the vector of `control`, on the sensor board
//! by the ADC's data-ready line, on the virtual board by a frame. What the boards do not share is
//! in [`board`].
#![no_std]
#![no_main]
// Start-up may panic; the reasons are given there. `cargo xtask safety` checks the rest in the
// image.
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)]

mod board;
mod crash_memory;
mod fault_entry;
mod halt;
mod settings_loader;
#[cfg(feature = "virtual-board")]
mod stack;
mod ticking;
mod vitals;

use defmt as _;

#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true, dispatchers = [])]
mod app {
    use super::board::{self, ELEMENTS, FrontEnd, HostReceiver, HostTransmitter, Idler};
    use super::settings_loader::{Outcome, SettingsLoader};
    use super::vitals::{self, CHECK_INS, Health, LoggedWind};
    use super::{crash_memory, halt, ticking};
    use core::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};
    use dr_core::control::{Cause, Lockout, LockoutWords, Margins, Refusal, RunState, TripHistory};
    use dr_core::{Command, Instrument};
    use firmware::check_ins::Member;
    use firmware::crash_record::CrashTrip;
    use firmware::cut_off::CutOff;
    use firmware::inbox::{Exchange, Inbox, Request, SettingsJob, TelemetryRequests, Wake};
    use firmware::outbox::{Outbox, Sequence, Unsent};
    use firmware::queue;
    use firmware::settings::{PendingFindings, SettingsServer, StandbyLock};
    use heapless::spsc::{Consumer, Producer, Queue};
    use rtic::Mutex;
    use stm32f4xx_hal::pac::Interrupt;
    use wire::{
        Event, FromBoard, LinkCounters, List, MAX_FRAME, Receiver, SettingsAnswer, SettingsRefusal, SettingsRequest,
        ToBoard, encode,
    };

    /// The vector of `control`. On the sensor board the ADC's data-ready line raises it.
    const CONTROL: Interrupt = Interrupt::EXTI4;
    /// The vector of `receive`.
    const RECEIVE: Interrupt = Interrupt::USART2;
    /// The vector of `transmit`: of a peripheral that no board uses, raised by software alone.
    ///
    /// An asynchronous task would be spawned by name. But it is compiled into a machine that panics
    /// when it is polled behind its end, which RTIC's executor does not do and the compiler cannot
    /// see.
    const TRANSMIT: Interrupt = Interrupt::SPI3;
    /// The vector of `serve_settings`, of a peripheral that no board uses either.
    const SETTINGS: Interrupt = Interrupt::SPI2;

    /// The vector of the dead-man timer. On the sensor board the timer raises it.
    const DEAD_MAN: Interrupt = Interrupt::TIM5;

    /// Messages to the host that may wait; at 1 kHz and 921 600 baud the link needs 0.7 ms for a
    /// sample.
    const TELEMETRY_SLOTS: usize = 32;

    /// The platinum is to lose its supply.
    static CUT: AtomicBool = AtomicBool::new(false);
    static TELEMETRY_REQUESTS: TelemetryRequests = TelemetryRequests::starting();
    static UNSENT: Unsent = Unsent::none();
    static LATE_TICKS: AtomicU32 = AtomicU32::new(0);
    static LOST_CONVERSIONS: AtomicU32 = AtomicU32::new(0);
    static CONTROL_CYCLES_MAX: AtomicU32 = AtomicU32::new(0);
    static TICK_CYCLES: AtomicU32 = AtomicU32::new(0);
    /// The dead-man timer has expired, and the controller has not tripped yet.
    static OUTPUT_TIMED_OUT: AtomicBool = AtomicBool::new(false);
    /// Sequence number of a `Stop`, and in the upper half its complement; 0 if there is none. A bit
    /// that flips makes none.
    static STOP: AtomicU32 = AtomicU32::new(0);
    static DEADLINES: AtomicU32 = AtomicU32::new(0);
    /// The dead-man timer is to be proved, as soon as all heaters are low.
    static PROOF_IS_DUE: AtomicBool = AtomicBool::new(true);
    static FLIPPABLE: AtomicU32 = AtomicU32::new(0);
    static ARMED: AtomicBool = AtomicBool::new(false);
    /// The crash of an earlier start has been acknowledged.
    static ACKNOWLEDGED: AtomicBool = AtomicBool::new(false);
    /// Trip for the end of the last run of the firmware, for a failed proof test or a falling
    /// supply, until the controller has taken it.
    static CRASH_TRIP: CrashTrip = CrashTrip::none();
    static STANDBY_LOCK: StandbyLock = StandbyLock::starting();
    /// `serve_settings` must set the instrument up before anything else; true after a start.
    static SET_UP: AtomicBool = AtomicBool::new(true);
    /// A host has sent a frame since the last run of control.
    static HOST_HEARD: AtomicBool = AtomicBool::new(false);
    /// The instrument has been set up.
    static IS_SET_UP: AtomicBool = AtomicBool::new(false);

    #[shared]
    struct Shared {
        inbox: Inbox<'static>,
        host_counters: LinkCounters,
        status: Option<wire::Status>,
        /// Findings of the last self-test that are not stored yet.
        findings: PendingFindings,
        /// Of each element, to the levels. The health task copies them once a second, some 200
        /// bytes, for which the control task waits a microsecond.
        margins: List<Option<Margins>>,
        /// Trips so far, for the status.
        history: TripHistory,
        /// The last wind estimate, for the log.
        wind: Option<LoggedWind>,
        /// As it was after the last run of control.
        run_state: RunState,
    }

    #[local]
    struct Local {
        instrument: Instrument<ELEMENTS>,
        /// As the last start left it, until the instrument has it. Not given to it at the start,
        /// where the stack would hold the instrument more than once.
        lockout_before: Option<Lockout>,
        /// The trip counter as RAM keeps it across a reset.
        kept_lockout: LockoutWords,
        front_end: FrontEnd,
        requests: Consumer<'static, Request>,
        orders: Consumer<'static, Command>,
        outcomes: Producer<'static, Outcome>,
        loader: SettingsLoader,
        jobs: Consumer<'static, SettingsJob>,
        answers: Producer<'static, SettingsAnswer>,
        answered: Consumer<'static, SettingsAnswer>,
        outbox: Outbox<'static>,
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
        order_queue: Queue<Command, 2> = Queue::new(),
        outcome_queue: Queue<Outcome, 2> = Queue::new(),
        job_queue: Queue<SettingsJob, 3> = Queue::new(),
        answer_queue: Queue<SettingsAnswer, 3> = Queue::new(),
        telemetry_queue: Queue<FromBoard, TELEMETRY_SLOTS> = Queue::new(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let (request_in, requests) = cx.local.request_queue.split();
        let (exchange_in, exchanges) = cx.local.exchange_queue.split();
        let (message_in, messages) = cx.local.telemetry_queue.split();
        let (order_in, orders) = cx.local.order_queue.split();
        let (outcome_in, outcomes) = cx.local.outcome_queue.split();
        let (job_in, jobs) = cx.local.job_queue.split();
        let (answer_in, answered) = cx.local.answer_queue.split();
        let mut core = cx.core;
        let parts = board::init(cx.device, &mut core, exchanges);
        ticking::start(&mut core.SYST, board::CLOCK_HZ);
        let (reset, past) = halt::update_record(parts.reset);
        defmt::info!("{=str} on the {} board, started by {}", vitals::NAME, board::NAME, board::reset_name(reset));
        let lockout = halt::lockout_after(reset, &past);
        if let Some(cause) = past.trip(reset) {
            CRASH_TRIP.put(cause);
            STANDBY_LOCK.standby(false);
        }
        let identity = vitals::identity(reset, past);
        // The identity goes first: a host that was connected before the reset must notice the
        // reset.
        rtic::pend(TRANSMIT);
        // Before any command of the host is carried out: they wait until the instrument is set up.
        rtic::pend(SETTINGS);
        (
            Shared {
                inbox: Inbox::new(request_in, exchange_in, job_in, &TELEMETRY_REQUESTS, board::IS_VIRTUAL),
                host_counters: LinkCounters::default(),
                status: None,
                findings: PendingFindings::of(&identity),
                margins: List::new(),
                history: lockout.history(),
                wind: None,
                run_state: RunState::Standby,
            },
            Local {
                instrument: Instrument::new(&board::HARDWARE_LIMITS),
                lockout_before: Some(lockout),
                kept_lockout: lockout.words(),
                front_end: parts.front_end,
                requests,
                orders,
                outcomes: outcome_in,
                loader: SettingsLoader::new(SettingsServer::new(parts.settings), order_in, outcomes),
                jobs,
                answers: answer_in,
                answered,
                outbox: Outbox::new(message_in, &UNSENT),
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
    #[idle(local = [idler, bench: Receiver = Receiver::new()], shared = [inbox, findings])]
    // Under its own name in the image, where `cargo xtask safety` looks for it: what runs before it
    // is start-up.
    #[inline(never)]
    fn idle(mut cx: idle::Context) -> ! {
        loop {
            CHECK_INS.check_in(Member::Idle);
            if PROOF_IS_DUE.load(Relaxed) {
                // Of what control uses, so that control waits, and the dead-man timer does not.
                cx.shared.findings.lock(|_| {
                    let (has_timed_out, deadlines) = (OUTPUT_TIMED_OUT.load(Relaxed), DEADLINES.load(Relaxed));
                    PROOF_IS_DUE.store(!cx.local.idler.prove_dead_man(), Relaxed);
                    OUTPUT_TIMED_OUT.store(has_timed_out, Relaxed);
                    DEADLINES.store(deadlines, Relaxed);
                });
            }
            if let Some(cause) = cx.local.idler.check() {
                CRASH_TRIP.put(cause);
                rtic::pend(CONTROL);
            }
            for &byte in cx.local.idler.wait() {
                if let Some(received) = cx.local.bench.push::<ToBoard>(byte) {
                    HOST_HEARD.store(true, Relaxed);
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
        OUTPUT_TIMED_OUT.store(true, Relaxed);
        DEADLINES.store(DEADLINES.load(Relaxed).wrapping_add(1), Relaxed);
    }

    /// The supply falls: brown-out and reset may follow. Priority 6, as the dead-man timer. Raised
    /// by the voltage detector, and by `health` as long as the supply is low.
    #[cfg(feature = "sensor-board")]
    #[task(binds = PVD, priority = 6)]
    fn supply_low(_: supply_low::Context) {
        board::heaters_low();
        board::acknowledge_supply();
        CRASH_TRIP.put(Cause::BrownOut);
        rtic::pend(CONTROL);
    }

    /// Owns the instrument: controller and anemometer. Priority 5: only the dead-man timer and a
    /// falling supply interrupt a decision.
    ///
    /// Deadline: the next reading; on the sensor board the next conversion, which would otherwise
    /// still see the old levels. A missed deadline counts as a late tick; the heaters keep their
    /// levels until this tick is through, at most for two ticks: then the dead-man timer lowers
    /// them, and this task trips. Never logs, never waits: replies and samples go into a queue, and
    /// what does not fit is dropped and counted.
    #[task(binds = EXTI4, priority = 5, local = [instrument, lockout_before, kept_lockout, front_end, requests, orders, outcomes, outbox, cut_off: CutOff = CutOff::open()], shared = [findings, margins, history, wind, run_state])]
    fn control(mut cx: control::Context) {
        let control::LocalResources {
            instrument,
            lockout_before,
            kept_lockout,
            front_end,
            requests,
            orders,
            outcomes,
            outbox,
            cut_off,
            ..
        } = cx.local;
        let mut started = board::cycles();
        CHECK_INS.check_in(Member::Control);
        // Before any trip and any command.
        if let Some(lockout) = lockout_before.take() {
            instrument.restore_lockout(lockout);
            instrument.expect_host();
        }
        if let Some(cause) = CRASH_TRIP.take() {
            instrument.trip(cause);
        }
        if HOST_HEARD.load(Relaxed) {
            HOST_HEARD.store(false, Relaxed);
            instrument.host_heard();
        }
        if matches!(instrument.controller().state(), RunState::Running | RunState::Testing) {
            // Nothing holds the lock while the instrument runs; a flipped bit in it must not block
            // `Stop`.
            STANDBY_LOCK.give_back();
        }
        while let Some(command) = orders.dequeue() {
            // It has room for one, and the loader takes each outcome before its next order.
            let result = handle(instrument, front_end, &mut cx.shared.margins, command);
            queue::put(outcomes, result.map(drop)).ok();
        }
        let stop = STOP.swap(0, Relaxed);
        let sequence = stop as u16;
        if stop == stop_word(sequence) {
            // What waited is void: nothing starts behind it.
            while let Some((to, _)) = requests.dequeue() {
                outbox.put(FromBoard::Reply { to, result: Err(Refusal::Stopped) });
            }
            let result = handle(instrument, front_end, &mut cx.shared.margins, Command::Stop);
            outbox.put(FromBoard::Reply { to: sequence, result });
        }
        // While settings are written or loaded, the host's commands wait: nothing starts then.
        while !STANDBY_LOCK.is_taken()
            && let Some((sequence, command)) = requests.dequeue()
        {
            let result = handle(instrument, front_end, &mut cx.shared.margins, command);
            outbox.put(FromBoard::Reply { to: sequence, result });
        }

        // One tick or none; several if the front end was silent.
        while let Some(readings) = front_end.poll() {
            // Before the reasons for which others have lowered them.
            let held = front_end.holds_levels();
            if OUTPUT_TIMED_OUT.load(Relaxed) {
                OUTPUT_TIMED_OUT.store(false, Relaxed);
                instrument.trip(Cause::Deadline);
            }
            if !held && !CRASH_TRIP.waits() {
                instrument.trip(Cause::Heater);
            }
            let tick = instrument.tick(&readings);
            // The heaters first: the wind decides nothing.
            let applied = front_end.apply(&tick);
            // If the timer has expired since, these levels are too old; the next tick trips. If the
            // supply has fallen since, this task is pending again, and trips then. Either may have
            // lowered a pin while it was raised, which is no fault of the pin.
            if OUTPUT_TIMED_OUT.load(Relaxed) || CRASH_TRIP.waits() {
                board::heaters_low();
            } else if !applied {
                instrument.trip(Cause::Heater);
            }
            let tripped = matches!(tick.state, RunState::Tripped(_));
            CUT.store(cut_off.judge(tripped, &readings), Relaxed);
            front_end.select(instrument.input());
            let wind = instrument.sense(&tick);
            if let Some(wind) = &wind {
                cx.shared.wind.lock(|last| *last = Some(LoggedWind::of(wind)));
            }
            if let Some(test) = instrument.take_self_test() {
                test.findings().iter().for_each(|finding| outbox.put(FromBoard::Tested(*finding)));
                cx.shared.findings.lock(|findings| findings.take(test.unix_s(), test.findings()));
                rtic::pend(SETTINGS);
            }
            if let Some(reply) = front_end.reply(instrument, &tick, wind.as_ref()) {
                outbox.put(reply);
            }
            if TELEMETRY_REQUESTS.wants_sample(tick.tick) {
                outbox.put(FromBoard::of_tick(&tick, wind.as_ref()));
            }
            if front_end.overran() {
                LATE_TICKS.store(LATE_TICKS.load(Relaxed).wrapping_add(1), Relaxed);
            }
            let ended = board::cycles();
            let cycles = ended.wrapping_sub(started);
            CONTROL_CYCLES_MAX.store(CONTROL_CYCLES_MAX.load(Relaxed).max(cycles), Relaxed);
            started = ended;
        }

        if let Some(cause) = front_end.take_fault() {
            board::heaters_low();
            instrument.trip(cause);
        }
        if let Some(reply) = front_end.reply_to_silence() {
            outbox.put(reply);
        }
        LOST_CONVERSIONS.store(front_end.lost_conversions(), Relaxed);
        FLIPPABLE.store(instrument.controller().bit_flips(), Relaxed);
        ARMED.store(instrument.controller().is_armed(), Relaxed);

        let lockout = instrument.controller().lockout();
        if lockout.words() != *kept_lockout {
            // Once a second, and with each trip.
            *kept_lockout = lockout.words();
            crash_memory::write_lockout(kept_lockout);
            cx.shared.history.lock(|history| *history = lockout.history());
        }
        let state = instrument.controller().state();
        STANDBY_LOCK.standby(state == RunState::Standby);
        if cx.shared.run_state.lock(|last| core::mem::replace(last, state)) != state {
            outbox.put(FromBoard::Event(Event { tick: instrument.controller().ticks(), state }));
        }
        if outbox.waits() {
            rtic::pend(TRANSMIT);
        }
    }

    /// A `Stop` of this number, on its way to the controller.
    const fn stop_word(sequence: u16) -> u32 {
        sequence as u32 | (!sequence as u32) << 16
    }

    /// Carries out a command, and passes on what the front end needs of it.
    fn handle(
        instrument: &mut Instrument<ELEMENTS>,
        front_end: &mut FrontEnd,
        margins: &mut impl Mutex<T = List<Option<Margins>>>,
        command: Command,
    ) -> Result<dr_core::Reply, Refusal> {
        if let (Command::SamplePeriod { sample_period_s }, RunState::Standby) =
            (command, instrument.controller().state())
        {
            front_end.set_sample_period(sample_period_s).map_err(|error| Refusal::Invalid { element: None, error })?;
            TICK_CYCLES.store((sample_period_s * board::CLOCK_HZ as f32) as u32, Relaxed);
        }
        let is_lowered = matches!(command, Command::Stop) && front_end.lower();
        let reply = instrument.handle(command)?;
        if is_lowered {
            instrument.lowered();
        }
        margins.lock(|margins| {
            margins.clear();
            for of_element in instrument.controller().margins() {
                margins.push(of_element).ok();
            }
        });
        match command {
            // Not before: a start that is refused must not disturb the run.
            Command::Start => front_end.restart(),
            Command::SelfTest(_) => PROOF_IS_DUE.store(true, Relaxed),
            Command::Acknowledge => {
                halt::acknowledge();
                ACKNOWLEDGED.store(true, Relaxed);
                if !IS_SET_UP.load(Relaxed) || instrument.controller().sample_period_s().is_none() {
                    // It has not been set up yet, or a bit flip has cleared its settings.
                    STANDBY_LOCK.take();
                    SET_UP.store(true, Relaxed);
                    rtic::pend(SETTINGS);
                }
            }
            _ => {}
        }
        Ok(reply)
    }

    /// Takes the host's bytes. Priority 3; bytes wait in the receiver's buffer meanwhile (5.5 ms of
    /// them on the sensor board), and those that come later still are lost, which their frame's
    /// checksum shows.
    #[task(binds = USART2, priority = 3, local = [host_receiver, link: Receiver = Receiver::new()], shared = [inbox, host_counters])]
    fn receive(mut cx: receive::Context) {
        CHECK_INS.check_in(Member::Receive);
        let foreign = cx.local.link.counters().foreign;
        while let Some(byte) = cx.local.host_receiver.read() {
            if let Some(received) = cx.local.link.push::<ToBoard>(byte) {
                HOST_HEARD.store(true, Relaxed);
                wake(cx.shared.inbox.lock(|inbox| inbox.accept(&received)));
            }
        }
        if let Some(version) = cx.local.link.foreign_version()
            && cx.local.link.counters().foreign != foreign
        {
            // Any frame of ours shows such a host our version.
            TELEMETRY_REQUESTS.ask_identity();
            rtic::pend(TRANSMIT);
            defmt::warn!(
                "the host speaks version {=u8} of the wire protocol, this board {=u8}",
                version,
                wire::VERSION
            );
        }
        cx.shared.host_counters.lock(|counters| *counters = cx.local.link.counters());
    }

    /// Takes the simulated front end's bytes. Priority 4: a reading comes before a command.
    #[cfg(feature = "virtual-board")]
    #[task(binds = USART1, priority = 4, local = [bench: Receiver = Receiver::new()], shared = [inbox])]
    fn bench(mut cx: bench::Context) {
        while let Some(byte) = board::read_bench_byte() {
            if let Some(received) = cx.local.bench.push::<ToBoard>(byte) {
                HOST_HEARD.store(true, Relaxed);
                wake(cx.shared.inbox.lock(|inbox| inbox.accept(&received)));
            }
        }
    }

    /// Sends what waits. Priority 2; 31 messages may wait meanwhile, and what finds it full is
    /// counted.
    #[task(binds = SPI3, priority = 2, local = [messages, answered, host_transmitter, identity, sequence: Sequence = Sequence::new()], shared = [status])]
    fn transmit(mut cx: transmit::Context) {
        let transmit::LocalResources { messages, answered, host_transmitter, identity, sequence, .. } = cx.local;
        if host_transmitter.is_well() {
            CHECK_INS.check_in(Member::Transmit);
        }
        while host_transmitter.is_free() {
            let mut number = || sequence.next(UNSENT.count());
            if TELEMETRY_REQUESTS.take_identity() {
                if ACKNOWLEDGED.load(Relaxed) {
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
            if SET_UP.load(Relaxed) {
                SET_UP.store(false, Relaxed);
                set_up(loader);
            }
            while STANDBY_LOCK.try_take() {
                let record = cx.shared.findings.lock(PendingFindings::take_one);
                if let Some(record) = &record {
                    loader.server.keep(record);
                }
                resume();
                if record.is_none() {
                    break;
                }
            }
            let Some((to, request)) = jobs.dequeue() else { break };
            // Reading needs the lock as well: the settings store may panic, which must not happen
            // with a heater high.
            let answer = if STANDBY_LOCK.try_take() {
                if request == SettingsRequest::Load {
                    set_up(loader);
                }
                if request == SettingsRequest::EraseAll {
                    loader.server.start_anew(board::settings_flash);
                }
                let answer = loader.server.answer(to, &request);
                resume();
                let left_undone = request == SettingsRequest::Load && !IS_SET_UP.load(Relaxed);
                if left_undone { SettingsAnswer { to, result: Err(SettingsRefusal::NotInStandby) } } else { answer }
            } else {
                SettingsAnswer { to, result: Err(SettingsRefusal::NotInStandby) }
            };
            // A host that does not wait for replies loses some of them.
            queue::put(answers, answer).ok();
            rtic::pend(TRANSMIT);
        }
    }

    fn set_up(loader: &mut SettingsLoader) {
        let done = loader.set_up(&STANDBY_LOCK, &TELEMETRY_REQUESTS, || rtic::pend(CONTROL));
        IS_SET_UP.store(done, Relaxed);
        resume();
    }

    /// The host's commands go on.
    fn resume() {
        STANDBY_LOCK.give_back();
        rtic::pend(CONTROL);
    }

    /// Twenty times a second: feeds the watchdog if every task has checked in, and clears the
    /// check-ins. Once a second: status. Priority 2; late by more than the watchdog's half second
    /// resets the board.
    #[task(binds = SysTick, priority = 2, local = [health], shared = [status, host_counters, inbox, margins, history, wind, run_state])]
    fn health(mut cx: health::Context) {
        if cx.local.health.beat(CUT.load(Relaxed)) {
            let link = cx.shared.host_counters.lock(|counters| *counters);
            let refused = cx.shared.inbox.lock(|inbox| inbox.refused);
            let status = wire::Status {
                uptime_s: cx.local.health.uptime_s(),
                link,
                refused,
                unsent: UNSENT.count(),
                late_ticks: LATE_TICKS.load(Relaxed),
                lost_conversions: LOST_CONVERSIONS.load(Relaxed),
                deadlines: DEADLINES.load(Relaxed),
                bit_flips: FLIPPABLE.load(Relaxed),
                armed: ARMED.load(Relaxed),
                control_cycles_max: CONTROL_CYCLES_MAX.load(Relaxed),
                tick_cycles: TICK_CYCLES.load(Relaxed),
                margins: cx.shared.margins.lock(|margins| margins.clone()),
                history: cx.shared.history.lock(|history| *history),
                state: cx.shared.run_state.lock(|state| *state),
            };
            cx.shared.status.lock(|slot| *slot = Some(status));
            if let Some(wind) = cx.shared.wind.lock(Option::take) {
                wind.log();
            }
        }
        #[cfg(feature = "sensor-board")]
        if board::is_supply_low() {
            rtic::pend(Interrupt::PVD);
        }
        rtic::pend(CONTROL);
        rtic::pend(RECEIVE);
        rtic::pend(TRANSMIT);
        rtic::pend(SETTINGS);
    }

    /// Half of the sensor board's receive buffer is full, and the host is still speaking. Priority
    /// 3, as `receive`.
    #[cfg(feature = "sensor-board")]
    #[task(binds = DMA1_STREAM5, priority = 3)]
    fn filled(_: filled::Context) {
        board::acknowledge_received();
        rtic::pend(RECEIVE);
    }

    /// The sensor board's transmitter has sent its frame: there may be more. Priority 2, as
    /// `transmit`.
    #[cfg(feature = "sensor-board")]
    #[task(binds = DMA1_STREAM6, priority = 2)]
    fn sent(_: sent::Context) {
        board::acknowledge_sent();
        rtic::pend(TRANSMIT);
    }

    fn wake(who: Wake) {
        match who {
            Wake::Control => rtic::pend(CONTROL),
            Wake::Stop(sequence) => {
                STOP.store(stop_word(sequence), Relaxed);
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
