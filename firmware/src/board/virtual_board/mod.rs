//! The virtual board: the application under `qemu-system-arm -M netduinoplus2`, its front end a
//! link to the host.
//!
//! Two links, chosen by what the host offers:
//!
//! - **USART**: USART2 is the host link, as on the sensor board; USART1 brings readings and takes
//!   heater levels.
//! - **FIFO**: if `to-board.fifo` exists in the emulator's folder, everything goes through it and
//!   `from-board.fifo` by semihosting. Some thirty times faster, for long runs; the bytes are the
//!   same.
//!
//! What the emulator lacks is left out: no PLL (its RCC does not respond), no DMA, no transmit
//! interrupts (so sending is polled, which costs nothing there), no watchdog, no cycle counter, no
//! timer: the host measures the silence of the front end. A reset is a real one: RAM stays, as on
//! the sensor board.

pub mod table;

pub use crate::mcu::emulated::file_flash::FileFlash as SettingsFlash;
pub use table::{CLOCK_HZ, ELEMENTS, HARDWARE_LIMITS, IS_VIRTUAL, KIND, NAME};

use super::BoardParts;
use crate::mcu::emulated::file_flash;
use crate::mcu::emulated::semihosting::{self, File};
use core::sync::atomic::{AtomicU32, AtomicUsize, Ordering::Relaxed};
use cortex_m::peripheral::SCB;
use cortex_m_semihosting::nr;
use dr_core::ConfigError;
use dr_core::control::{Cause, Heaters, Tick};
use dr_core::sensor::{FrontEndInput, Reading};
use dr_core::{Decider, Digest};
use firmware::control_loop::ControlBoard;
use firmware::crash_record::CrashRecord;
use firmware::dead_man::DeadManCounter;
use firmware::inbox::Exchange;
use firmware::outbox::Sequence;
use heapless::spsc::Consumer;
use stm32f4xx_hal::pac::{self, USART1, USART2};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Config;
use stm32f4xx_hal::serial::{Config as SerialConfig, Rx, Serial, Tx};
use table::BAUD;
use wire::{FromBoard, HeaterFrame, MAX_FRAME, Provocation, ResetCause, encode};

/// Stands in for the heaters' pins.
static PINS: AtomicUsize = AtomicUsize::new(0);
static DEAD_MAN: DeadManCounter = DeadManCounter::stopped();
/// Sequence number of the silence that needs a reply, plus one; 0 if there is none.
static SILENCE: AtomicU32 = AtomicU32::new(0);

/// Sets up the links.
#[expect(clippy::expect_used, reason = "start-up, before any heater is raised")]
pub fn init(
    device: pac::Peripherals,
    _: &mut cortex_m::Peripherals,
    exchanges: Consumer<'static, Exchange>,
) -> BoardParts {
    let mut rcc = device.RCC.freeze(Config::hsi());
    let gpioa = device.GPIOA.split(&mut rcc);
    let config = SerialConfig::default().baudrate(BAUD.bps());
    let bench: Serial<USART1> = Serial::new(device.USART1, (gpioa.pa9, gpioa.pa10), config, &mut rcc)
        .expect("921 600 baud can be made from 16 MHz");
    let host: Serial<USART2> = Serial::new(device.USART2, (gpioa.pa2, gpioa.pa3), config, &mut rcc)
        .expect("921 600 baud can be made from 16 MHz");
    let (bench_tx, mut bench_rx) = bench.split();
    let (host_tx, mut host_rx) = host.split();
    bench_rx.listen();
    host_rx.listen();

    let fifos = Fifos::open();
    BoardParts {
        front_end: FrontEnd {
            exchanges,
            replying_to: None,
            digest: Digest::default(),
            input: FrontEndInput::Element,
            usart: fifos.is_none().then_some((bench_tx, Sequence::new())),
        },
        host_receiver: HostReceiver(host_rx),
        host_transmitter: fifos
            .map_or(HostTransmitter::Usart(host_tx), |fifos| HostTransmitter::Fifo(fifos.from_board)),
        watchdog: Watchdog,
        idler: Idler { fifos, buffer: [0; 256] },
        settings: SettingsFlash::open(),
        // The emulated RCC does not keep the flags; the crash record in RAM shows whether there was
        // a reset.
        reset: ResetCause::Software,
    }
}

/// Puts all heaters at the low level at once.
pub fn heaters_low() {
    PINS.store(0, Relaxed);
}

/// A new start, with the RAM as it is. The emulator's links stay open.
pub fn restart() -> ! {
    heaters_low();
    SCB::sys_reset()
}

/// The host counts the time; there is no interrupt to clear.
pub const fn acknowledge_dead_man() {}

/// The front end was silent for a tick; returns whether the dead-man timer expires.
pub fn silence(sequence: u16) -> bool {
    SILENCE.store(u32::from(sequence) + 1, Relaxed);
    DEAD_MAN.tick_passed()
}

/// The emulated processor has none.
pub const fn unique_id() -> [u32; 3] {
    [0; 3]
}

/// Why it started, by what is remembered.
pub fn reset_as_remembered(_: ResetCause, life: &CrashRecord) -> ResetCause {
    match (life.starts, &life.crash) {
        (1, _) => ResetCause::PowerOn,
        (_, Some(_)) if life.requested => ResetCause::Software,
        _ => ResetCause::Pin,
    }
}

/// Provokes a fault.
#[inline(never)]
pub fn provoke(what: Provocation) {
    const RAM: usize = 0x2000_0000;
    const RAM_BYTES: u32 = 128 * 1024;
    match what {
        #[expect(clippy::panic, reason = "the host requests it")]
        Provocation::Panic => panic!("as the host has asked"),
        // SAFETY: nothing is there, which is what is wanted: a bus fault, and from it a hard fault.
        Provocation::Fault => drop(unsafe { core::ptr::read_volatile(0xd000_0000 as *const u32) }),
        Provocation::Reset => restart(),
        Provocation::BitFlip { offset, bit } if offset < RAM_BYTES && bit < 8 => {
            let byte = (RAM + offset as usize) as *mut u8;
            // SAFETY: none, and that is the point: it stands for a particle that hits this byte. It
            // is in RAM.
            unsafe { byte.write_volatile(byte.read_volatile() ^ 1 << bit) };
        }
        Provocation::BitFlip { .. } => {}
        Provocation::CutPower { after_bytes } => file_flash::cut_after(after_bytes),
    }
}

/// The run is over.
pub fn finish(code: u8) -> ! {
    let (used, size) = crate::stack::used();
    defmt::info!("{=u32} of {=u32} bytes of stack have been in use", used, size);
    semihosting::exit(code.into())
}

/// The two FIFOs of the fast link.
#[derive(Clone, Copy)]
struct Fifos {
    to_board: File,
    from_board: File,
}

impl Fifos {
    /// Opens them if the host has made them. The order is the host's as well: each side waits for
    /// the other.
    fn open() -> Option<Self> {
        Some(Self {
            to_board: File::open(c"to-board.fifo", nr::open::R_BINARY)?,
            from_board: File::open(c"from-board.fifo", nr::open::W_TRUNC_BINARY)?,
        })
    }
}

/// Readings from a queue that the link fills, heater levels back over the link.
pub struct FrontEnd {
    exchanges: Consumer<'static, Exchange>,
    replying_to: Option<u16>,
    digest: Digest,
    input: FrontEndInput,
    /// Its own transmitter. Without it the replies go out with all other messages.
    usart: Option<(Tx<USART1>, Sequence)>,
}

impl FrontEnd {
    fn reply_levels(&mut self, to: u16, (wind_digest, has_wind): (Digest, bool)) -> Option<FromBoard> {
        let heaters = Heaters(PINS.load(Relaxed));
        let (digest, wind_digest) = (self.digest.value(), wind_digest.value());
        let frame = HeaterFrame { to, heaters, input: self.input, digest, wind_digest, has_wind };
        let reply = FromBoard::Heaters(frame);
        let Some((usart, sequence)) = &mut self.usart else { return Some(reply) };
        let mut buffer = [0; MAX_FRAME];
        if let Ok(frame) = encode(sequence.next(0), &reply, &mut buffer) {
            // The emulated transmitter is always ready.
            usart.bwrite_all(frame).ok();
        }
        None
    }
}

impl ControlBoard<ELEMENTS> for FrontEnd {
    fn poll(&mut self) -> Option<[Reading; ELEMENTS]> {
        let (sequence, readings) = self.exchanges.peek()?;
        self.replying_to = Some(*sequence);
        let readings = readings.readings();
        self.exchanges.dequeue();
        Some(readings)
    }

    /// The levels are part of the reply.
    fn apply(&mut self, tick: &Tick<ELEMENTS>) -> bool {
        DEAD_MAN.decided(tick.heaters.0 != 0);
        PINS.store(tick.heaters.0, Relaxed);
        true
    }

    /// It has no pins.
    fn holds_levels(&mut self) -> bool {
        true
    }

    fn heaters_low(&mut self) {
        heaters_low();
    }

    /// Its levels are those of a whole tick: they follow at the next one.
    fn lower(&mut self) -> bool {
        false
    }

    /// The input of the next readings is part of the reply as well.
    fn select(&mut self, input: FrontEndInput) {
        self.input = input;
    }

    /// A new run has a new digest.
    fn restart(&mut self) {
        self.digest = Digest::default();
    }

    /// Any period will do: the host keeps the time.
    fn set_sample_period(&mut self, _sample_period_s: f32) -> Result<(), ConfigError> {
        Ok(())
    }

    /// The host waits for each reply.
    fn overran(&mut self) -> bool {
        false
    }

    /// There is no ADC.
    fn take_fault(&mut self) -> Option<Cause> {
        None
    }

    fn decided(&mut self, decider: &Decider<ELEMENTS>, tick: &Tick<ELEMENTS>) {
        decider.controller().digest(tick, &mut self.digest);
    }

    /// Replies to a tick of silence with the present levels, to an exchange when it is estimated.
    fn reply(&mut self, estimated: Option<(Digest, bool)>) -> Option<FromBoard> {
        if let Some(number) = SILENCE.load(Relaxed).checked_sub(1) {
            SILENCE.store(0, Relaxed);
            return self.reply_levels(number as u16, estimated.unwrap_or_default());
        }
        let estimated = estimated?;
        let to = self.replying_to.take()?;
        self.reply_levels(to, estimated)
    }
}

/// A byte of the simulated front end's link.
pub fn read_bench_byte() -> Option<u8> {
    // SAFETY: only the task of this USART reads its registers once it is set up.
    let usart = unsafe { &*USART1::ptr() };
    usart.sr().read().rxne().bit_is_set().then(|| usart.dr().read().dr().bits() as u8)
}

/// Bytes from the host.
pub struct HostReceiver(Rx<USART2>);

impl HostReceiver {
    /// The next byte that has come.
    pub fn read(&mut self) -> Option<u8> {
        self.0.read().ok()
    }
}

/// Frames to the host.
pub enum HostTransmitter {
    /// By cable.
    Usart(Tx<USART2>),
    /// By the fast link.
    Fifo(File),
}

impl HostTransmitter {
    /// The host notices a broken link.
    pub const fn is_well(&self) -> bool {
        true
    }

    /// Sending is done when `send` comes back.
    pub const fn is_free(&self) -> bool {
        true
    }

    /// Sends a frame.
    pub fn send(&mut self, frame: &[u8]) {
        match self {
            // The emulated transmitter is always ready.
            Self::Usart(usart) => drop(usart.bwrite_all(frame)),
            Self::Fifo(file) => _ = file.write(frame),
        }
    }
}

/// The emulator has no watchdog; a timeout of the host replaces it.
pub struct Watchdog;

impl Watchdog {
    /// Nothing to feed.
    pub const fn feed(&mut self, _: bool) {}
}

/// Waits for the host on the fast link, for an interrupt otherwise.
pub struct Idler {
    fifos: Option<Fifos>,
    buffer: [u8; 256],
}

impl Idler {
    /// The emulator has no timer.
    pub const fn prove_dead_man(&mut self) -> bool {
        true
    }

    /// The emulator has no memory that fails.
    pub const fn check(&mut self) -> Option<Cause> {
        None
    }

    /// Waits; returns the bytes that the host has sent on the fast link.
    pub fn wait(&mut self) -> &[u8] {
        let Some(fifos) = self.fifos else {
            cortex_m::asm::wfi();
            return &[];
        };
        match fifos.to_board.read(&mut self.buffer) {
            // The host has closed its end: there is nothing left to run for.
            0 => finish(0),
            read => self.buffer.get(..read).unwrap_or(&[]),
        }
    }
}
