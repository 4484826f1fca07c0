//! Bus of the processor: the peripherals, as it sees them.

use super::fault::FaultStatus;
use super::mpu::Mpu;
use super::nvic::Nvic;

/// Nothing answers at this address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusFault(pub u32);

/// Work of a peripheral on the memory by itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MemoryJob {
    /// A byte that a stream of the DMA has brought.
    Store {
        /// Where it goes.
        address: u32,
        /// Byte that is written.
        byte: u8,
    },
    /// Bytes that a stream of the DMA takes; they are handed to [`ProcessorBus::fetched`].
    Fetch {
        /// Address of the first.
        address: u32,
        /// Number of bytes.
        length: u32,
    },
}

/// Peripherals and time.
pub trait ProcessorBus {
    /// A load by the core.
    ///
    /// # Errors
    /// If nothing answers.
    fn load(&mut self, address: u32, size: usize) -> Result<u32, BusFault>;

    /// A store by the core.
    ///
    /// # Errors
    /// If nothing answers.
    fn store(&mut self, address: u32, size: usize, value: u32) -> Result<(), BusFault>;

    /// Tells whether the core holds all interrupts back, said before each of its stores.
    fn holds_back(&mut self, _: bool) {}

    /// The core waits until all its stores have arrived (DSB).
    fn barrier(&mut self) {}

    /// Exceptions.
    fn nvic(&mut self) -> &mut Nvic;

    /// Why the core has faulted.
    fn faults(&mut self) -> &mut FaultStatus;

    /// Rights to read, write and execute.
    fn mpu(&self) -> &Mpu;

    /// Where the vectors stand.
    fn vector_table(&self) -> u32;

    /// The time.
    fn now(&self) -> u64;

    /// The core has spent cycles of its own clock.
    fn spend(&mut self, core_cycles: u32);

    /// The core sleeps or stands still until this time.
    fn pass(&mut self, until: u64, asleep: bool);

    /// Carries out all that is due.
    fn settle(&mut self);

    /// When something is due next.
    fn next_event(&self) -> u64;

    /// Tells whether something may have begun to wait, or to be due, since the last time of asking.
    fn needs_attention(&self) -> bool;

    /// Somebody has looked.
    fn attended(&mut self);

    /// Until when the core stands still: its flash is busy, or it has no clock.
    fn stalled_until(&self) -> Option<u64>;

    /// Tells whether the processor is to be reset.
    fn wants_reset(&self) -> bool;

    /// Tells whether whoever runs the processor wants to look at something.
    fn wants_pause(&self) -> bool;

    /// Jobs that wait for the memory.
    fn memory_jobs(&mut self) -> Vec<MemoryJob>;

    /// Bytes that a job has fetched.
    fn fetched(&mut self, bytes: &[u8]);
}
