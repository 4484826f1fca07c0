//! The instrument's application: five tasks around one controller.
//!
//! ```text
//! front end ──► control ──► outbox ──► transmit ──► host
//!                  ▲                                 │
//!                  ├───── inbox ◄──── receive ◄──────┘        health: watchdog, status
//!                clerk ◄────┘                                  clerk: settings in flash
//! ```
//!
//! The front end drives everything: a reading raises the vector of `control`, on the sensor board by the ADC's data-ready
//! line, on the virtual board by a frame. What the boards do not share is in [`board`].
#![no_std]
#![no_main]
// Start-up may panic, and says why there. What runs behind it is looked at in the image: `cargo xtask safety`.
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)]

mod board;
mod desk;
mod fault_entry;
mod halt;
#[cfg(feature = "virtual-board")]
mod stack;
mod vitals;

use defmt as _;

#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true, dispatchers = [])]
mod app {
    use super::board::{self, ELEMENTS, FrontEnd, HostReceiver, HostTransmitter, Idler};
    use super::desk::{Desk, Outcome};
    use super::halt;
    use super::vitals::{self, Health};
    use core::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};
    use dr_core::control::{Cause, Command, Refusal, RunState, Station};
    use firmware::check_ins::{CheckIns, Member};
    use firmware::inbox::{Errand, Exchange, Inbox, Questions, Request, Wake};
    use firmware::margins::MarginBoard;
    use firmware::outbox::{Outbox, Sequence, Unsent};
    use firmware::past_life::PastTrip;
    use firmware::queue;
    use firmware::settings::{Busy, Clerk, Findings};
    use heapless::spsc::{Consumer, Producer, Queue};
    use stm32f4xx_hal::pac::Interrupt;
    use wire::{
        Event, FromBoard, LinkCounters, MAX_FRAME, Receiver, SettingsAnswer, SettingsRefusal, SettingsRequest, ToBoard,
        encode,
    };

    /// The vector of `control`. On the sensor board the ADC's data-ready line raises it.
    const CONTROL: Interrupt = Interrupt::EXTI4;
    /// The vector of `receive`.
    const RECEIVE: Interrupt = Interrupt::USART2;
    /// The vector of `transmit`: of a peripheral that no board uses, raised by software alone.
    ///
    /// An asynchronous task would be spawned by name. But it is compiled into a machine that panics when it is polled behind its end,
    /// which RTIC's executor does not do and the compiler cannot see.
    const TRANSMIT: Interrupt = Interrupt::SPI3;
    /// The vector of `clerk`, likewise.
    const CLERK: Interrupt = Interrupt::SPI2;

    /// The vector of the dead man's handle. On the sensor board its timer raises it.
    const DEAD_MAN: Interrupt = Interrupt::TIM5;

    /// Messages to the host that may wait; at 1 kHz and 921 600 baud the link needs 0.7 ms for a sample.
    const TELEMETRY_SLOTS: usize = 32;

    static QUESTIONS: Questions = Questions::new();
    static UNSENT: Unsent = Unsent::new();
    static CHECK_INS: CheckIns = CheckIns::new();
    static MARGINS: MarginBoard<ELEMENTS> = MarginBoard::new();
    static LATE_TICKS: AtomicU32 = AtomicU32::new(0);
    static CONTROL_CYCLES_MAX: AtomicU32 = AtomicU32::new(0);
    static TICK_CYCLES: AtomicU32 = AtomicU32::new(0);
    /// The dead man's handle has bitten, and the controller does not know yet.
    static BITTEN: AtomicBool = AtomicBool::new(false);
    static DEADLINES: AtomicU32 = AtomicU32::new(0);
    static UPSETS: AtomicU32 = AtomicU32::new(0);
    static ARMED: AtomicBool = AtomicBool::new(false);
    /// What a life before ended with has been acknowledged.
    static ACKNOWLEDGED: AtomicBool = AtomicBool::new(false);
    /// What the life before ended with, until the controller knows.
    static PAST_TRIP: PastTrip = PastTrip::none();
    static BUSY: Busy = Busy::starting();
    /// The clerk is to set the instrument up before anything else; so it begins.
    static SET_UP: AtomicBool = AtomicBool::new(true);
    /// It has done so.
    static IS_SET_UP: AtomicBool = AtomicBool::new(false);

    #[shared]
    struct Shared {
        inbox: Inbox<'static>,
        host_counters: LinkCounters,
        status: Option<wire::Status>,
        /// Of the last self-test, until they are kept.
        findings: Findings,
    }

    #[local]
    struct Local {
        station: Station<ELEMENTS>,
        front_end: FrontEnd,
        requests: Consumer<'static, Request>,
        orders: Consumer<'static, Command>,
        outcomes: Producer<'static, Outcome>,
        desk: Desk,
        errands: Consumer<'static, Errand>,
        answers: Producer<'static, SettingsAnswer>,
        answered: Consumer<'static, SettingsAnswer>,
        outbox: Outbox<'static>,
        last_state: RunState,
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
        errand_queue: Queue<Errand, 3> = Queue::new(),
        answer_queue: Queue<SettingsAnswer, 3> = Queue::new(),
        telemetry_queue: Queue<FromBoard, TELEMETRY_SLOTS> = Queue::new(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let (request_in, requests) = cx.local.request_queue.split();
        let (exchange_in, exchanges) = cx.local.exchange_queue.split();
        let (message_in, messages) = cx.local.telemetry_queue.split();
        let (order_in, orders) = cx.local.order_queue.split();
        let (outcome_in, outcomes) = cx.local.outcome_queue.split();
        let (errand_in, errands) = cx.local.errand_queue.split();
        let (answer_in, answered) = cx.local.answer_queue.split();
        let mut core = cx.core;
        let parts = board::init(cx.device, &mut core, exchanges);
        vitals::start_ticking(&mut core.SYST);
        let (reset, past) = halt::past_life(parts.reset);
        defmt::info!("{=str} on the {} board, started by {}", vitals::NAME, board::NAME, board::reset_name(reset));
        if let Some(cause) = past.trip(reset) {
            PAST_TRIP.put(cause);
            BUSY.standby(false);
        }
        let identity = vitals::identity(reset, past);
        // Says who it is before anything else: a host that was speaking to the life before must learn of it.
        rtic::pend(TRANSMIT);
        // Before any command of the host is carried out: they wait until the instrument is set up.
        rtic::pend(CLERK);
        (
            Shared {
                inbox: Inbox::new(request_in, exchange_in, errand_in, &QUESTIONS, board::IS_VIRTUAL),
                host_counters: LinkCounters::default(),
                status: None,
                findings: Findings::of(&identity),
            },
            Local {
                station: Station::new(),
                front_end: parts.front_end,
                requests,
                orders,
                outcomes: outcome_in,
                desk: Desk::new(Clerk::new(parts.settings), order_in, outcomes),
                errands,
                answers: answer_in,
                answered,
                outbox: Outbox::new(message_in, &UNSENT),
                last_state: RunState::Standby,
                messages,
                host_receiver: parts.host_receiver,
                host_transmitter: parts.host_transmitter,
                health: Health::new(parts.watchdog),
                idler: parts.idler,
                identity,
            },
        )
    }

    /// Sleeps until something happens. The virtual board may wait for its host here, and hands over what it said.
    #[idle(local = [idler, bench: Receiver = Receiver::new()], shared = [inbox])]
    // Under its own name in the image, where `cargo xtask safety` looks for it: what runs before it is start-up.
    #[inline(never)]
    fn idle(mut cx: idle::Context) -> ! {
        loop {
            for &byte in cx.local.idler.wait() {
                if let Some(received) = cx.local.bench.push::<ToBoard>(byte) {
                    wake(cx.shared.inbox.lock(|inbox| inbox.accept(&received)));
                }
            }
        }
    }

    /// The dead man's handle bites: levels have not been decided anew for two ticks. Priority 6, above all others: whatever holds the
    /// control task up, a silent front end or itself, cannot hold this up. Touches nothing that others own.
    #[task(binds = TIM5, priority = 6)]
    fn dead_man(_: dead_man::Context) {
        board::heaters_low();
        board::acknowledge_dead_man();
        BITTEN.store(true, Relaxed);
        DEADLINES.store(DEADLINES.load(Relaxed).wrapping_add(1), Relaxed);
    }

    /// Owns the station: controller and anemometer. Priority 5: nothing but the dead man's handle comes before a decision.
    ///
    /// Deadline: the next reading; on the sensor board the next conversion, which would otherwise still see the old levels.
    /// Missing it is counted as a late tick; the heaters stay as the tick before left them until this one is through, or until they have
    /// stood for two ticks: then the dead man's handle lowers them, and this task trips.
    /// Never logs, never waits: replies and samples go into a queue, and what does not fit is dropped and counted.
    #[task(binds = EXTI4, priority = 5, local = [station, front_end, requests, orders, outcomes, outbox, last_state], shared = [findings])]
    fn control(mut cx: control::Context) {
        let control::LocalResources { station, front_end, requests, orders, outcomes, outbox, last_state, .. } =
            cx.local;
        let mut started = board::cycles();
        CHECK_INS.check_in(Member::Control);
        // Before any command.
        if let Some(cause) = PAST_TRIP.take() {
            station.trip(cause);
        }
        if matches!(station.controller().state(), RunState::Running | RunState::Testing) {
            // It is in nobody's hands then, whatever its memory says: `Stop` must not wait for ever.
            BUSY.give_back();
        }
        while let Some(command) = orders.dequeue() {
            // It has room for one, and the clerk takes each before it gives the next order.
            queue::put(outcomes, handle(station, front_end, command).map(drop)).ok();
        }
        // While settings are written or told, the host's commands wait: nothing starts then.
        while !BUSY.is_taken()
            && let Some((sequence, command)) = requests.dequeue()
        {
            let result = handle(station, front_end, command);
            outbox.put(FromBoard::Reply { to: sequence, result });
        }

        // One tick or none, unless the front end makes up for ticks in which it was silent.
        while let Some(readings) = front_end.poll() {
            if BITTEN.load(Relaxed) {
                BITTEN.store(false, Relaxed);
                station.trip(Cause::Deadline);
            }
            let tick = station.tick(&readings);
            // The heaters first: the wind decides nothing.
            if !front_end.apply(&tick) {
                station.trip(Cause::Heater);
            }
            // If the handle has bitten since, what has just been set is too old; the next tick trips.
            if BITTEN.load(Relaxed) {
                board::heaters_low();
            }
            front_end.select(station.input());
            let wind = station.sense(&tick);
            if let Some(test) = station.take_self_test() {
                test.findings().iter().for_each(|finding| outbox.put(FromBoard::Tested(*finding)));
                cx.shared.findings.lock(|findings| findings.take(test.unix_s(), test.findings()));
                rtic::pend(CLERK);
            }
            if let Some(answer) = front_end.answer(station, &tick, wind.as_ref()) {
                outbox.put(answer);
            }
            if QUESTIONS.wants_sample(tick.tick) {
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

        if let Some(answer) = front_end.answer_silence() {
            outbox.put(answer);
        }
        UPSETS.store(station.controller().upsets(), Relaxed);
        ARMED.store(station.controller().is_armed(), Relaxed);

        let state = station.controller().state();
        BUSY.standby(state == RunState::Standby);
        if state != *last_state {
            *last_state = state;
            outbox.put(FromBoard::Event(Event { tick: station.controller().ticks(), state }));
        }
        if outbox.waits() {
            rtic::pend(TRANSMIT);
        }
    }

    /// A command is carried out by the station; what the front end must know of it, it learns here.
    fn handle(
        station: &mut Station<ELEMENTS>,
        front_end: &mut FrontEnd,
        command: Command,
    ) -> Result<dr_core::control::Reply, Refusal> {
        if let (Command::SamplePeriod { sample_period_s }, RunState::Standby) = (command, station.controller().state())
        {
            front_end.set_sample_period(sample_period_s).map_err(|error| Refusal::Invalid { element: None, error })?;
            TICK_CYCLES.store((sample_period_s * board::CLOCK_HZ as f32) as u32, Relaxed);
        }
        let reply = station.handle(command)?;
        MARGINS.put(station.controller().margins());
        match command {
            // Not before: a start that is refused must not disturb the run.
            Command::Start => front_end.restart(),
            Command::Acknowledge => {
                halt::acknowledge();
                ACKNOWLEDGED.store(true, Relaxed);
                if !IS_SET_UP.load(Relaxed) || station.controller().sample_period_s().is_none() {
                    // It has not been set up yet, or has forgotten everything since its memory was upset.
                    BUSY.take();
                    SET_UP.store(true, Relaxed);
                    rtic::pend(CLERK);
                }
            }
            _ => {}
        }
        Ok(reply)
    }

    /// Takes the host's bytes. Priority 3; bytes wait in the receiver's buffer meanwhile (5.5 ms of them on the sensor
    /// board), and those that come later still are lost, which their frame's checksum shows.
    #[task(binds = USART2, priority = 3, local = [host_receiver, link: Receiver = Receiver::new()], shared = [inbox, host_counters])]
    fn receive(mut cx: receive::Context) {
        CHECK_INS.check_in(Member::Receive);
        while let Some(byte) = cx.local.host_receiver.read() {
            if let Some(received) = cx.local.link.push::<ToBoard>(byte) {
                wake(cx.shared.inbox.lock(|inbox| inbox.accept(&received)));
            }
        }
        cx.shared.host_counters.lock(|counters| *counters = cx.local.link.counters());
    }

    /// Takes the simulated front end's bytes. Priority 4: a reading comes before a command.
    #[cfg(feature = "virtual-board")]
    #[task(binds = USART1, priority = 4, local = [bench: Receiver = Receiver::new()], shared = [inbox])]
    fn bench(mut cx: bench::Context) {
        while let Some(byte) = board::read_bench_byte() {
            if let Some(received) = cx.local.bench.push::<ToBoard>(byte) {
                wake(cx.shared.inbox.lock(|inbox| inbox.accept(&received)));
            }
        }
    }

    /// Sends what waits. Priority 2; 31 messages may wait meanwhile, and what finds it full is counted.
    #[task(binds = SPI3, priority = 2, local = [messages, answered, host_transmitter, identity, sequence: Sequence = Sequence::new()], shared = [status])]
    fn transmit(mut cx: transmit::Context) {
        let transmit::LocalResources { messages, answered, host_transmitter, identity, sequence, .. } = cx.local;
        CHECK_INS.check_in(Member::Transmit);
        while host_transmitter.is_free() {
            let mut number = || sequence.next(UNSENT.count());
            if QUESTIONS.take_identity() {
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

    /// Keeps the settings: sets the instrument up by them at a start, and does what the host asks of them. Priority 1, below all others, since it waits for the
    /// flash; of requests two may wait meanwhile. What it does to the flash and what the control task does exclude each other ([`Busy`]).
    #[task(binds = SPI2, priority = 1, local = [desk, errands, answers], shared = [findings])]
    fn clerk(mut cx: clerk::Context) {
        let clerk::LocalResources { desk, errands, answers, .. } = cx.local;
        loop {
            if SET_UP.load(Relaxed) {
                SET_UP.store(false, Relaxed);
                set_up(desk);
            }
            while BUSY.try_take() {
                let record = cx.shared.findings.lock(Findings::take_one);
                if let Some(record) = &record {
                    desk.clerk.keep(record);
                }
                resume();
                if record.is_none() {
                    break;
                }
            }
            let Some((to, request)) = errands.dequeue() else { break };
            // To read, too: what keeps the settings may panic, and nothing does while a heater may be high.
            let answer = if BUSY.try_take() {
                if request == SettingsRequest::Load {
                    set_up(desk);
                }
                if request == SettingsRequest::ForgetAll {
                    desk.clerk.start_anew(board::settings_flash);
                }
                let answer = desk.clerk.answer(to, &request);
                resume();
                let left_undone = request == SettingsRequest::Load && !IS_SET_UP.load(Relaxed);
                if left_undone { SettingsAnswer { to, result: Err(SettingsRefusal::NotInStandby) } } else { answer }
            } else {
                SettingsAnswer { to, result: Err(SettingsRefusal::NotInStandby) }
            };
            // Who asks without waiting for answers does not get all of them.
            queue::put(answers, answer).ok();
            rtic::pend(TRANSMIT);
        }
    }

    fn set_up(desk: &mut Desk) {
        let done = desk.set_up(&BUSY, &QUESTIONS, || rtic::pend(CONTROL));
        IS_SET_UP.store(done, Relaxed);
        resume();
    }

    /// The host's commands go on.
    fn resume() {
        BUSY.give_back();
        rtic::pend(CONTROL);
    }

    /// Twenty times a second: feeds the watchdog if every task has checked in, and asks them to do so again.
    /// Once a second: status. Priority 2; late by more than the watchdog's half second resets the board.
    #[task(binds = SysTick, priority = 2, local = [health], shared = [status, host_counters, inbox])]
    fn health(mut cx: health::Context) {
        if cx.local.health.beat(&CHECK_INS) {
            let link = cx.shared.host_counters.lock(|counters| *counters);
            let refused = cx.shared.inbox.lock(|inbox| inbox.refused);
            let status = wire::Status {
                uptime_s: cx.local.health.uptime_s(),
                link,
                refused,
                unsent: UNSENT.count(),
                late_ticks: LATE_TICKS.load(Relaxed),
                deadlines: DEADLINES.load(Relaxed),
                upsets: UPSETS.load(Relaxed),
                armed: ARMED.load(Relaxed),
                control_cycles_max: CONTROL_CYCLES_MAX.load(Relaxed),
                tick_cycles: TICK_CYCLES.load(Relaxed),
                margins: MARGINS.read(),
            };
            cx.shared.status.lock(|slot| *slot = Some(status));
        }
        rtic::pend(CONTROL);
        rtic::pend(RECEIVE);
        rtic::pend(TRANSMIT);
        rtic::pend(CLERK);
    }

    /// Half of the sensor board's receive buffer is full, and the host is still speaking. Priority 3, as `receive`.
    #[cfg(feature = "sensor-board")]
    #[task(binds = DMA1_STREAM5, priority = 3)]
    fn filled(_: filled::Context) {
        board::acknowledge_received();
        rtic::pend(RECEIVE);
    }

    /// The sensor board's transmitter has sent its frame: there may be more. Priority 2, as `transmit`.
    #[cfg(feature = "sensor-board")]
    #[task(binds = DMA1_STREAM6, priority = 2)]
    fn sent(_: sent::Context) {
        board::acknowledge_sent();
        rtic::pend(TRANSMIT);
    }

    fn wake(who: Wake) {
        match who {
            Wake::Control => rtic::pend(CONTROL),
            Wake::Transmit => rtic::pend(TRANSMIT),
            Wake::Clerk => rtic::pend(CLERK),
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
