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

mod power;
mod settings_flash;

pub use self::{
    LinkFrontEnd as FrontEnd, LinkIdler as Idler, LinkReceiver as HostReceiver, LinkTransmitter as HostTransmitter,
    NoWatchdog as Watchdog,
};
pub use power::{heaters_low, restart};
pub use settings_flash::FileFlash as SettingsFlash;
use settings_flash::FileFlash;

use super::parts::BoardParts;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use cortex_m_semihosting::{nr, syscall};
use dr_core::ConfigError;
use dr_core::control::{Cause, HardwareLimits, Heaters, Tick};
use dr_core::sensor::{FrontEndInput, Reading};
use dr_core::{Decider, Digest};
use firmware::control_loop::ControlBoard;
use firmware::crash_record::CrashRecord;
use firmware::dead_man::DeadManCounter;
use firmware::inbox::Exchange;
use firmware::outbox::Sequence;
use heapless::spsc::Consumer;
use power::PINS;
use stm32f4xx_hal::pac::{self, USART1, USART2};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Config;
use stm32f4xx_hal::serial::{Config as SerialConfig, Rx, Serial, Tx};
use wire::{BoardKind, FromBoard, HeaterFrame, MAX_FRAME, Provocation, ResetCause, encode};

/// For the log.
pub const NAME: &str = "virtual";
/// For the host.
pub const KIND: BoardKind = BoardKind::Virtual;
/// As many as a message has room for.
pub const ELEMENTS: usize = wire::MOST_ELEMENTS;

/// This board's front end is a link.
pub const IS_VIRTUAL: bool = true;
/// What no message can lift.
pub static HARDWARE_LIMITS: HardwareLimits = HardwareLimits::SIMULATED;
/// The emulator's core clock.
pub const CLOCK_HZ: u32 = 168_000_000;

const BAUD: u32 = 921_600;

static DEAD_MAN: DeadManCounter = DeadManCounter::stopped();
/// Sequence number of the silence that needs a reply, plus one; 0 if there is none.
static SILENCE: AtomicU32 = AtomicU32::new(0);

/// Sets up the links.
#[expect(clippy::expect_used, reason = "start-up, before any heater is raised")]
pub fn init(
    device: pac::Peripherals,
    _: &mut cortex_m::Peripherals,
    exchanges: Consumer<'static, Exchange>,
) -> BoardParts<LinkFrontEnd, LinkReceiver, LinkTransmitter, NoWatchdog, LinkIdler, FileFlash> {
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
        front_end: LinkFrontEnd {
            exchanges,
            replying_to: None,
            digest: Digest::default(),
            input: FrontEndInput::Element,
            usart: fifos.is_none().then_some((bench_tx, Sequence::new())),
        },
        host_receiver: LinkReceiver(host_rx),
        host_transmitter: fifos
            .map_or(LinkTransmitter::Usart(host_tx), |fifos| LinkTransmitter::Fifo(fifos.from_board)),
        watchdog: NoWatchdog,
        idler: LinkIdler { fifos, buffer: [0; 256] },
        settings: FileFlash::open(),
        // The emulated RCC does not keep the flags; the crash record in RAM shows whether there was
        // a reset.
        reset: ResetCause::Software,
    }
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
        Provocation::CutPower { after_bytes } => settings_flash::cut_after(after_bytes),
    }
}

/// The run is over.
pub fn finish(code: u8) -> ! {
    let (used, size) = crate::stack::used();
    defmt::info!("{=u32} of {=u32} bytes of stack have been in use", used, size);
    leave(code)
}

/// Leaves the emulator with an exit code.
fn leave(code: u8) -> ! {
    /// ADP_Stopped_ApplicationExit, the reason that carries a code.
    const APPLICATION_EXIT: u32 = 0x2_0026;
    /// The call that carries it; the crate knows only the one without a code.
    const SYS_EXIT_EXTENDED: usize = 0x20;
    let block = [APPLICATION_EXIT, u32::from(code)];
    // SAFETY: SYS_EXIT_EXTENDED reads the two words of the block and does not come back.
    unsafe { cortex_m_semihosting::syscall1(SYS_EXIT_EXTENDED, block.as_ptr() as usize) };
    loop {
        cortex_m::asm::nop();
    }
}

/// The two FIFOs of the fast link.
#[derive(Clone, Copy)]
struct Fifos {
    to_board: usize,
    from_board: usize,
}

impl Fifos {
    /// Opens them if the host has made them. The order is the host's as well: each side waits for
    /// the other.
    fn open() -> Option<Self> {
        let open = |name: &core::ffi::CStr, mode: usize| {
            // SAFETY: SYS_OPEN reads a zero-terminated name of the given length.
            let handle = unsafe { syscall!(OPEN, name.as_ptr(), mode, name.count_bytes()) };
            (handle != usize::MAX).then_some(handle)
        };
        Some(Self {
            to_board: open(c"to-board.fifo", nr::open::R_BINARY)?,
            from_board: open(c"from-board.fifo", nr::open::W_TRUNC_BINARY)?,
        })
    }
}

/// Readings from a queue that the link fills, heater levels back over the link.
pub struct LinkFrontEnd {
    exchanges: Consumer<'static, Exchange>,
    replying_to: Option<u16>,
    digest: Digest,
    input: FrontEndInput,
    /// Its own transmitter. Without it the replies go out with all other messages.
    usart: Option<(Tx<USART1>, Sequence)>,
}

impl LinkFrontEnd {
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

impl ControlBoard<ELEMENTS> for LinkFrontEnd {
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
pub struct LinkReceiver(Rx<USART2>);

impl LinkReceiver {
    /// The next byte that has come.
    pub fn read(&mut self) -> Option<u8> {
        self.0.read().ok()
    }
}

/// Frames to the host.
pub enum LinkTransmitter {
    /// By cable.
    Usart(Tx<USART2>),
    /// By the fast link; its handle.
    Fifo(usize),
}

impl LinkTransmitter {
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
            Self::Usart(usart) => {
                // The emulated transmitter is always ready.
                usart.bwrite_all(frame).ok();
            }
            Self::Fifo(handle) => {
                // SAFETY: SYS_WRITE reads `frame.len()` bytes.
                unsafe { syscall!(WRITE, *handle, frame.as_ptr(), frame.len()) };
            }
        }
    }
}

/// The emulator has no watchdog; a timeout of the host replaces it.
pub struct NoWatchdog;

impl NoWatchdog {
    /// Nothing to feed.
    pub const fn feed(&mut self, _: bool) {}
}

/// Waits for the host on the fast link, for an interrupt otherwise.
pub struct LinkIdler {
    fifos: Option<Fifos>,
    buffer: [u8; 256],
}

impl LinkIdler {
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
        // SAFETY: SYS_READ writes at most `len` bytes into the buffer and gives the number that it
        // did not.
        let unread = unsafe { syscall!(READ, fifos.to_board, self.buffer.as_mut_ptr(), self.buffer.len()) };
        match self.buffer.len().checked_sub(unread) {
            Some(read) if read > 0 => self.buffer.get(..read).unwrap_or(&[]),
            // The host has closed its end: there is nothing left to run for.
            _ => finish(0),
        }
    }
}
