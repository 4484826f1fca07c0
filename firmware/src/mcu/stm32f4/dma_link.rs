//! The host on USART2, both ways by DMA.
//!
//! ```text
//! frame ─► TELEMETRY_FRAME ─► DMA1 stream 6 ─► PA2
//! PA3 ─► DMA1 stream 5 ─► TELEMETRY_RECEIVED ─► receive
//! ```
//!
//! Streams, channel and direction are checked by the compiler against the HAL's table of the
//! request map (`DMASet`).
//!
//! **Baud rate.** 42 MHz / 46 = 913 043, 0.93 % slow. A receiver that samples the middle of a bit
//! bears ±5 % over ten bits, ours is specified to bear 3.75 % (RM0090, "USART receiver's tolerance
//! to clock deviation").
//!
//! **Sending.** One frame at a time. The stream clears its own enable bit when its count is through
//! (RM0090, "DMA stream x configuration register", EN), so that bit says whether the transmitter is
//! free, and the interrupt says when to look.
//!
//! A stream that stays enabled beyond twice the time of the longest frame, since a request of the
//! USART was lost or a bit of a register has changed, is set up anew; its frame is lost. One that
//! does not recover is no longer reported as well, so that the watchdog restarts the board.
//!
//! **Receiving.** The stream runs in a circle and is never stopped, so there is no moment in which
//! a byte finds nobody. Three things call `receive`: the line falls idle after a frame (USART2),
//! half or all of the buffer is written (DMA1 stream 5), and the health task, 20 times a second. An
//! overrun, a framing or a noise error stops nothing here, but their flags hold the interrupt until
//! they are cleared by reading SR and then DR (RM0090, USART_SR). That reading of DR can take away
//! a byte that has just come before the stream fetches it, a window of some tens of ns in 10.9 µs,
//! only if the host goes on sending just as its line was found idle: that frame's checksum then
//! fails, and the host repeats.

use super::clocks::{COUNTS_PER_US, counts};
use super::has_arrived;
use core::ops::Range;
use core::sync::atomic::{AtomicU8, Ordering::Relaxed, Ordering::SeqCst, fence};
use firmware::mcu::stm32f4::circle::Circle;
use stm32f4xx_hal::dma::config::Priority;
use stm32f4xx_hal::dma::traits::{DMASet, PeriAddress};
use stm32f4xx_hal::dma::{
    DmaChannel, DmaDirection, DmaEvent, MemoryToPeripheral, PeripheralToMemory, Stream5, Stream6, StreamsTuple,
};
use stm32f4xx_hal::gpio::{PA2, PA3};
use stm32f4xx_hal::pac::{DMA1, USART2};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::serial::config::DmaConfig;
use stm32f4xx_hal::serial::{Config, Rx, Serial, Tx};
use stm32f4xx_hal::{ClearFlags, Listen};
use wire::MAX_FRAME;

/// Bytes from the host that may wait: 5.5 ms of them.
const RECEIVED: usize = 512;

/// More than twice the time of the longest frame: 256 bytes of 10.95 µs.
const LONGEST_FRAME_US: u32 = 7_000;
/// Recoveries without a frame that has left after which the transmitter is not well.
const MOST_RECOVERIES: u8 = 3;
/// Reads of a stream's enable bit, which stays until a byte under way is through.
const DISABLING_ROUNDS: u32 = 1_000;
/// FE, NF, ORE and IDLE of USART_SR, which hold the interrupt.
const HOLDING: u16 = 0b1_1110;

// Atomics, because somebody else reads and writes them: the DMA. They cost what plain bytes do.
static TELEMETRY_FRAME: [AtomicU8; MAX_FRAME] = [const { AtomicU8::new(0) }; MAX_FRAME];
static TELEMETRY_RECEIVED: [AtomicU8; RECEIVED] = [const { AtomicU8::new(0) }; RECEIVED];

/// Addresses of both buffers, which the DMA reads and writes at any time.
pub fn buffers() -> [Range<u32>; 2] {
    [&TELEMETRY_FRAME[..], &TELEMETRY_RECEIVED].map(|buffer| {
        let start = buffer.as_ptr() as u32;
        start..start + buffer.len() as u32
    })
}

/// Sets up both directions; receiving begins.
#[expect(clippy::expect_used, reason = "start-up, before any heater is raised")]
pub fn start(
    usart: USART2,
    dma: DMA1,
    (tx, rx): (PA2, PA3),
    baud: u32,
    rcc: &mut Rcc,
) -> (HostTransmitter, HostReceiver)
where
    Tx<USART2>: DMASet<Stream6<DMA1>, 4, MemoryToPeripheral>,
    Rx<USART2>: DMASet<Stream5<DMA1>, 4, PeripheralToMemory>,
{
    let config = Config::default().baudrate(baud.bps()).dma(DmaConfig::TxRx);
    let rx = rx.into_alternate().internal_resistor(stm32f4xx_hal::gpio::Pull::Up);
    let serial = Serial::<USART2>::new(usart, (tx, rx), config, rcc).expect("the baud rate can be made of 42 MHz");
    let (tx, mut rx) = serial.split();
    let streams = StreamsTuple::new(dma, rcc);

    let mut transmitter = HostTransmitter { stream: streams.6, line: tx.address(), began: counts(), recoveries: 0 };
    transmitter.set_up();

    rx.listen_idle();
    // SAFETY: nobody else uses the USART yet, and the HAL has no name for this bit: the errors
    // raise the interrupt too.
    unsafe { (*USART2::ptr()).cr3().modify(|_, w| w.eie().set_bit()) };
    let mut receiver = HostReceiver { stream: streams.5, circle: Circle::new(RECEIVED as u16) };
    configure(&mut receiver.stream, DmaDirection::PeripheralToMemory, rx.address(), &TELEMETRY_RECEIVED);
    // Before all else on this controller: a byte that waits too long is lost, a frame that waits is
    // late.
    receiver.stream.set_priority(Priority::VeryHigh);
    receiver.stream.set_circular_mode(true);
    receiver.stream.listen(DmaEvent::HalfTransfer | DmaEvent::TransferComplete | DmaEvent::TransferError);
    receiver.begin();
    (transmitter, receiver)
}

/// What both streams have in common: channel 4, bytes, direct mode (each byte goes through at
/// once), the stream counts.
fn configure(
    stream: &mut impl stm32f4xx_hal::dma::traits::Stream,
    direction: DmaDirection,
    peripheral: u32,
    memory: &'static [AtomicU8],
) {
    stream.set_channel(DmaChannel::Channel4);
    stream.set_direction(direction);
    stream.set_peripheral_address(peripheral);
    stream.set_memory_address(memory.as_ptr() as u32);
    stream.set_memory_increment(true);
    stream.set_fifo_enable(false);
}

/// Frames to the host.
pub struct HostTransmitter {
    stream: Stream6<DMA1>,
    /// Address of the USART's data register.
    line: u32,
    /// When the last frame began.
    began: u32,
    /// Since the last frame that has left.
    recoveries: u8,
}

impl HostTransmitter {
    /// Whether the last frame has left the buffer. A stream that is stuck is set up anew.
    pub fn is_free(&mut self) -> bool {
        if !self.stream.is_enabled() {
            return true;
        }
        if counts().wrapping_sub(self.began) > LONGEST_FRAME_US * COUNTS_PER_US {
            self.recover();
        }
        !self.stream.is_enabled()
    }

    /// Returns false if frames no longer leave.
    pub const fn is_well(&self) -> bool {
        self.recoveries < MOST_RECOVERIES
    }

    fn recover(&mut self) {
        self.recoveries = self.recoveries.saturating_add(1);
        self.began = counts();
        // SAFETY: nobody waits for the frame.
        unsafe { self.stream.disable() };
        if (0..DISABLING_ROUNDS).any(|_| !self.stream.is_enabled()) {
            self.set_up();
            // SAFETY: these bits are the transmitter's, and only this task changes the registers
            // once the link is set up.
            let usart = unsafe { &*USART2::ptr() };
            usart.cr3().modify(|_, w| w.dmat().set_bit());
            usart.cr1().modify(|_, w| w.ue().set_bit().te().set_bit());
        }
    }

    fn set_up(&mut self) {
        configure(&mut self.stream, DmaDirection::MemoryToPeripheral, self.line, &TELEMETRY_FRAME);
        self.stream.set_priority(Priority::Medium);
        self.stream.listen(DmaEvent::TransferComplete | DmaEvent::TransferError);
    }

    /// Sends a frame. Call it only when the transmitter is free; what is longer than a frame can be
    /// is cut.
    pub fn send(&mut self, frame: &[u8]) {
        if self.stream.number_of_transfers() == 0 {
            self.recoveries = 0;
        }
        self.began = counts();
        let length = frame.len().min(MAX_FRAME);
        for (to, &byte) in TELEMETRY_FRAME.iter().zip(frame) {
            to.store(byte, Relaxed);
        }
        // The stream takes no new count while flags of the last one stand (RM0090, "DMA stream
        // configuration procedure").
        self.stream.clear_all_flags();
        self.stream.set_number_of_transfers(length as u16);
        // The bytes must be in memory before the stream may look.
        fence(SeqCst);
        // SAFETY: the stream reads `length` bytes of a static that is at least that long, and that
        // nobody writes until the stream is free again.
        unsafe { self.stream.enable() };
    }
}

/// Clears the transmitter's interrupt.
pub fn acknowledge_sent() {
    // SAFETY: a flag is cleared by writing a one; zeros leave those of other streams alone.
    unsafe { (*DMA1::ptr()).hifcr().write(|w| w.bits(0x3D << 16)) };
    has_arrived();
}

/// Clears the interrupt of the receiver's stream.
pub fn acknowledge_received() {
    // SAFETY: as above.
    unsafe { (*DMA1::ptr()).hifcr().write(|w| w.bits(0x3D << 6)) };
    has_arrived();
}

/// Bytes from the host.
pub struct HostReceiver {
    stream: Stream5<DMA1>,
    circle: Circle,
}

impl HostReceiver {
    /// The next byte that has come.
    pub fn read(&mut self) -> Option<u8> {
        let index = match self.circle.next() {
            Some(index) => index,
            None => {
                self.look();
                self.circle.next()?
            }
        };
        TELEMETRY_RECEIVED.get(index).map(|byte| byte.load(Relaxed))
    }

    /// Quietens the USART, then asks the stream how far it has come: what comes after that raises
    /// the interrupt anew.
    fn look(&mut self) {
        // SAFETY: only this task reads these two registers once the link is set up.
        let usart = unsafe { &*USART2::ptr() };
        if usart.sr().read().bits() & HOLDING != 0 {
            usart.dr().read();
        }
        // Only an error on the memory bus stops a circular stream, which a fixed address in RAM
        // cannot cause.
        if !self.stream.is_enabled() {
            self.begin();
        }
        self.circle.look(self.stream.number_of_transfers());
        // In direct mode the count goes down as the byte is fetched and its store follows at once;
        // no byte is read here before the count that tells of it.
        fence(SeqCst);
    }

    fn begin(&mut self) {
        self.stream.clear_all_flags();
        self.stream.set_number_of_transfers(RECEIVED as u16);
        self.circle = Circle::new(RECEIVED as u16);
        // SAFETY: the stream writes into a static of this length, whose bytes are atomics.
        unsafe { self.stream.enable() };
    }
}
