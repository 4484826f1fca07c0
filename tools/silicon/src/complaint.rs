//! Complaints: where the firmware breaks what the manuals ask for.
//!
//! A model goes on after a complaint as silicon might, or as if nothing had happened; what counts
//! is the complaint, since no test may end with one.

use std::fmt;

/// A rule of a manual that was broken: RM0090 for the processor, SBAS561 for the converter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BrokenRule {
    /// Complaint of the clock tree.
    #[error("a peripheral answers only while its clock is enabled")]
    ClockOff,
    /// Complaint of the clock tree.
    #[error("a peripheral answers only some cycles after its clock was enabled: read back, or DSB")]
    ClockJustOn,
    /// Complaint of the regulator.
    #[error("above 144 MHz the regulator needs its scale 1: VOS in PWR_CR")]
    VoltageScale,
    /// Nothing stands at the address, or nothing is modelled.
    #[error("nothing is modelled at {0:#010x}")]
    Unmodelled(u32),
    /// Complaint of the PLL.
    #[error("the PLL takes 1 to 2 MHz in, runs at 100 to 432 MHz, and its source must be ready before it is started")]
    PllRange,
    /// Complaint of the PLL.
    #[error("PLLCFGR is not written while the PLL runs")]
    PllChangedWhileOn,
    /// Complaint of the clock switch.
    #[error("a clock is taken for the core only once it is ready")]
    ClockNotReady,
    /// Complaint of the buses.
    #[error("the core runs at 168 MHz at the most, APB1 at 42, APB2 at 84")]
    ClockTooFast,
    /// Complaint of the memory protection.
    #[error("a region has 32 bytes or more, a power of two, and begins at a multiple of its size")]
    MpuRegion,
    /// Complaint of the flash.
    #[error("{needed} wait states are needed at this clock and supply, {set} are set")]
    WaitStates {
        /// By the table of the manual.
        needed: u32,
        /// In FLASH_ACR.
        set: u32,
    },
    /// Complaint of the flash.
    #[error("the flash is unlocked by its two keys in their order; anything else locks it until the next reset")]
    FlashKey,
    /// Complaint of the flash.
    #[error("a control register of the flash is written while it is locked, or while the flash is busy")]
    FlashLocked,
    /// Complaint of the flash.
    #[error("a store to the flash needs PG, and the width that PSIZE says")]
    FlashProgramming,
    /// Complaint of the flash.
    #[error("erasing, and programming by words, need a supply of 2.7 V")]
    ProgrammingSupply,
    /// Complaint of the flash.
    #[error("programming clears bits: what is not erased cannot be written")]
    FlashNotErased,
    /// Complaint of the flash.
    #[error("the data cache is reset only while it is off")]
    CacheResetWhileOn,
    /// Complaint of the flash.
    #[error("the data cache still holds what stood there before the erase: reset it")]
    StaleCache,
    /// Complaint of the converter's bus.
    #[error("the converter is read in SPI mode 1: clock low at rest, data taken at the falling edge")]
    SpiMode,
    /// Complaint of the bus.
    #[error("the pins of the bus are not connected to it: alternate function 5")]
    SpiPins,
    /// Complaint of the bus.
    #[error(
        "the pin of SCK is too slow for APB2: the last bit of a byte may be that of the byte before (ES0182, 2.12.4)"
    )]
    SpiClockPin,
    /// Complaint of the bus.
    #[error("SPI_DR is written while the bus is off or its buffer full")]
    SpiWrite,
    /// Complaint of the bus.
    #[error("SPI_CR1 is changed while a byte is on its way")]
    SpiChangedWhileBusy,
    /// Complaint of the bus.
    #[error("a byte was not read before the next one came")]
    SpiOverrun,
    /// Complaint of the converter.
    #[error("chip select changes in the middle of a byte")]
    SelectInsideByte,
    /// Complaint of the converter.
    #[error("SCLK is 20 MHz at the most")]
    AdcClock,
    /// Complaint of the converter.
    #[error("four t_CLK pass between the bytes of a command, and before chip select rises")]
    AdcDecodeTime,
    /// Complaint of the converter.
    #[error("chip select stays high for two t_CLK between commands")]
    AdcSelectTime,
    /// Complaint of the converter.
    #[error("a reset pulse lasts two t_CLK, 18 t_CLK pass after it, and the first one comes 2^18 t_CLK after power")]
    AdcResetTime,
    /// Complaint of the converter.
    #[error("registers are read and written in SDATAC only")]
    AdcRegisterWhileStreaming,
    /// Complaint of the converter.
    #[error("there is no such command or register")]
    AdcCommand,
    /// Complaint of the converter.
    #[error("data are read before the first conversion is there")]
    AdcNoData,
    /// Complaint of the converter.
    #[error("a frame is read once, after data-ready has fallen")]
    AdcNotReady,
    /// Complaint of the converter.
    #[error("a frame is read across the update by the next conversion")]
    AdcFrameAcrossUpdate,
    /// Complaint of the converter.
    #[error("the reference needs 150 ms to settle before a conversion counts")]
    AdcReference,
    /// Complaint of the line to the host.
    #[error("a byte came and nobody took the one before")]
    UsartOverrun,
    /// Complaint of the line to the host.
    #[error("the baud rate is beyond 2 % of the host's")]
    UsartBaud,
    /// Complaint of the line to the host.
    #[error("the pins of the line are not connected to it: alternate function 7")]
    UsartPins,
    /// Complaint of the DMA.
    #[error("a stream's registers are not changed while it runs")]
    DmaChangedWhileOn,
    /// Complaint of the DMA.
    #[error("a stream's flags are cleared before it is enabled")]
    DmaFlagsStand,
    /// Complaint of the DMA.
    #[error("stream, channel, direction and address fit no peripheral that asks for them")]
    DmaRequest,
    /// Complaint of the DMA.
    #[error("memory is changed while a stream reads it")]
    DmaMemoryChanged,
    /// Complaint of the watchdog.
    #[error("IWDG_PR and IWDG_RLR are written after the key 0x5555")]
    WatchdogProtected,
    /// Complaint of the watchdog.
    #[error("IWDG_PR and IWDG_RLR are written only while PVU and RVU are clear")]
    WatchdogUpdating,
    /// Complaint of the watchdog.
    #[error("the counter is reloaded while a new reload value is not taken over yet")]
    WatchdogReloadedEarly,
    /// Complaint of the board.
    #[error("a heater is high while the board reports that none may be")]
    HeaterHigh,
    /// Complaint of the board.
    #[error("a heater is high without a valid reading of its element within two ticks")]
    HeaterUnread,
}

/// A rule that was broken: when, where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Complaint {
    /// When it was first broken.
    pub cycle: u64,
    /// By an access to this register, or on this pin.
    pub register: &'static str,
    /// The rule.
    pub rule: BrokenRule,
    /// Number of times.
    pub times: u32,
}

impl fmt::Display for Complaint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { cycle, register, rule, times } = self;
        write!(f, "{:.6} s, {register}, {times} times: {rule}", crate::time::seconds(*cycle))
    }
}

/// All complaints so far, each kind once.
#[derive(Clone, Debug, Default)]
pub struct Complaints(Vec<Complaint>);

impl Complaints {
    /// A rule was broken.
    pub fn add(&mut self, cycle: u64, register: &'static str, rule: BrokenRule) {
        match self.0.iter_mut().find(|known| known.register == register && known.rule == rule) {
            Some(known) => known.times += 1,
            None => self.0.push(Complaint { cycle, register, rule, times: 1 }),
        }
    }

    /// All complaints, in the order in which they came.
    pub fn all(&self) -> &[Complaint] {
        &self.0
    }

    /// Forgets what there is.
    pub fn clear(&mut self) {
        self.0.clear();
    }
}
