//! The sensor board: STM32F405, six heated elements, an ADS131E06, the host on USART2. Its circuit
//! is in `docs/reference/board.md`.
//!
//! | file | what |
//! |---|---|
//! | `background_checks.rs` | proof tests in the idle task |
//! | `clock_check.rs` | that of crystal and slow oscillator |
//! | `clocks.rs` | 8 MHz crystal to 168 MHz, waiting by the cycle counter |
//! | `dead_man.rs` | heaters low unless their levels are decided anew |
//! | `dead_man_proof.rs` | proof test of that at every start and self-test |
//! | `front_end.rs` | ADC and heater pins: readings in, levels out |
//! | `heater_pin.rs` | one switch of a heater's level |
//! | `host_link.rs` | frames to the host and bytes from it, both by DMA |
//! | `memory_protection.rs` | what may be written and executed where |
//! | `settings_flash.rs` | three sectors of the processor's flash |
//! | `stopwatch.rs` | time that goes on while the core sleeps |
//! | `supply.rs` | brown-out level, and heaters low as the supply falls |
//! | `watchdog.rs` | reset unless everybody is well |
//! | `watchdog_proof.rs` | proof test of that after power-on and reset pin |
//!
//! Nothing of this has run on a board yet. What the emulator cannot show (DMA, EXTI, PLL, watchdog)
//! is argued beside the code from the reference manual RM0090. `HAL.md` compares each register that
//! the HAL touches, too; `ERRATA.md` goes through the chip's errata.

mod background_checks;
mod clock_check;
mod clocks;
mod dead_man;
mod dead_man_proof;
mod front_end;
mod heater_pin;
mod host_link;
mod memory_protection;
mod settings_flash;
mod stopwatch;
mod supply;
mod watchdog;
mod watchdog_proof;

pub use self::InterruptIdler as Idler;
pub use clocks::CLOCK_HZ;
pub use dead_man::acknowledge_dead_man;
pub use front_end::{AdcFrontEnd as FrontEnd, ELEMENTS};
pub use host_link::{
    DmaReceiver as HostReceiver, DmaTransmitter as HostTransmitter, acknowledge_received, acknowledge_sent,
};
pub use settings_flash::SectorFlash as SettingsFlash;
pub use supply::{acknowledge as acknowledge_supply, is_low as is_supply_low};
pub use watchdog::HardwareWatchdog as Watchdog;

use super::parts::BoardParts;
use background_checks::BackgroundChecks;
use cortex_m::peripheral::SCB;
use dead_man::DeadManTimer;
use defmt_rtt as _;
use dr_core::control::{Cause, HardwareLimits};
use firmware::crash_record::CrashRecord;
use firmware::drivers::heater_pins::HeaterPins;
use firmware::drivers::reset_flags;
use front_end::AdcFrontEnd;
use front_end::{AdcPins, FIRST_PERIOD_US, HEATER_MASK};
use heapless::spsc::Consumer;
use heater_pin::HeaterPin;
use host_link::{DmaReceiver, DmaTransmitter};
use settings_flash::SectorFlash;
use stm32f4xx_hal::gpio::PinState;
use stm32f4xx_hal::pac::{self, GPIOC};
use stm32f4xx_hal::prelude::*;
use watchdog::HardwareWatchdog;
use wire::{BoardKind, ResetCause};

/// For the log.
pub const NAME: &str = "sensor";
/// For the host.
pub const KIND: BoardKind = BoardKind::Sensor;
/// This board reads for itself.
pub const IS_VIRTUAL: bool = false;
/// What no message can lift.
pub static HARDWARE_LIMITS: HardwareLimits = HardwareLimits::SENSOR_BOARD;

/// HeaterPort low, clocks, link, ADC; 0.5 s, most of it the ADC's reference and offsets.
///
/// Called with interrupts disabled. An ADC that does not respond is no reason to stop: the board
/// then reports every reading as missing, and the guard keeps the heaters low.
#[expect(clippy::expect_used, reason = "start-up, before any heater is raised")]
pub fn init(
    device: pac::Peripherals,
    core: &mut cortex_m::Peripherals,
    _: Consumer<'static, firmware::inbox::Exchange>,
) -> BoardParts<AdcFrontEnd, DmaReceiver, DmaTransmitter, HardwareWatchdog, InterruptIdler, SectorFlash> {
    memory_protection::start(&core.MPU);
    let mut rcc = device.RCC.constrain();
    let gpioc = device.GPIOC.split(&mut rcc);
    let heaters = HeaterPins::new([
        HeaterPin::new(gpioc.pc0.into_push_pull_output().erase_number()),
        HeaterPin::new(gpioc.pc1.into_push_pull_output().erase_number()),
        HeaterPin::new(gpioc.pc2.into_push_pull_output().erase_number()),
        HeaterPin::new(gpioc.pc3.into_push_pull_output().erase_number()),
        HeaterPin::new(gpioc.pc4.into_push_pull_output().erase_number()),
        HeaterPin::new(gpioc.pc5.into_push_pull_output().erase_number()),
    ])
    .expect("writing a pin of this processor cannot fail");

    supply::start_detector(&device.PWR, &mut rcc);
    let flags = rcc.csr().read().bits();
    supply::ensure_brown_out_level(&device.FLASH, flags);
    let reset = reset_flags::cause(flags);
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    let (reset, watchdog_works) = watchdog_proof::prove(&device.IWDG, reset);
    watchdog::start(&device.IWDG);
    let mut rcc = clocks::start(rcc, core);

    let gpioa = device.GPIOA.split(&mut rcc);
    let gpiob = device.GPIOB.split(&mut rcc);
    let mut watchdog = HardwareWatchdog::new(device.IWDG, &device.DBGMCU, gpiob.pb1.into_push_pull_output());
    stopwatch::start(&device.TIM2, &mut rcc);
    let (host_transmitter, host_receiver) =
        host_link::start(device.USART2, device.DMA1, gpioa.pa2, gpioa.pa3, &mut rcc);
    let pins = AdcPins {
        select: gpioa.pa4.into_push_pull_output_in_state(PinState::High),
        clock: gpioa.pa5,
        data_in: gpioa.pa6,
        data_out: gpioa.pa7,
        // The pull-up that the pin had as JTAG reset stays, in case the ADC is not there to drive
        // it.
        data_ready: gpiob.pb4.into_pull_up_input(),
        reset: gpiob.pb0.into_push_pull_output_in_state(PinState::High),
    };
    supply::listen(&device.EXTI);
    let dead_man = DeadManTimer::new(device.TIM5, FIRST_PERIOD_US, &mut rcc);
    let front_end = AdcFrontEnd::start(device.SPI1, pins, device.EXTI, device.SYSCFG, heaters, dead_man, &mut rcc);
    watchdog.expect_check_ins();
    BoardParts {
        front_end,
        host_receiver,
        host_transmitter,
        watchdog,
        idler: InterruptIdler { checks: BackgroundChecks::new(), has_failed: !watchdog_works },
        settings: SectorFlash::new(device.FLASH),
        reset,
    }
}

/// Puts all heaters at the low level at once, whatever state the rest is in.
pub fn heaters_low() {
    // SAFETY: BSRR is written only, and one store changes these six pins and nothing else: no other
    // context can be disturbed half-way. Before the port has its clock the store does nothing, and
    // the pins float, pulled down.
    unsafe { (*GPIOC::ptr()).bsrr().write(|w| w.bits(HEATER_MASK << 16)) };
}

/// Waits until the last store has reached its peripheral, for handlers that clear their interrupt.
/// In the write buffer it would still be there when the handler returns, and the interrupt would be
/// taken once more (Arm DAI 0321A, "Memory barrier instructions").
fn has_arrived() {
    cortex_m::asm::dsb();
}

/// The number of this processor (RM0090, 39.1).
pub fn unique_id() -> [u32; 3] {
    const ADDRESS: *const [u32; 3] = 0x1fff_7a10 as *const _;
    // SAFETY: three aligned words that ST has programmed and nothing changes.
    unsafe { ADDRESS.read_volatile() }
}

/// Why it started, by its flags. A supply that was away so briefly that RAM has kept the crash
/// record has dipped, and was not switched on, however far it fell.
pub const fn reset_as_remembered(reset: ResetCause, record: &CrashRecord) -> ResetCause {
    match reset {
        ResetCause::PowerOn if record.starts > 1 => ResetCause::BrownOut,
        _ => reset,
    }
}

/// Restarts. After the restart the identity contains the reset cause and the crash.
pub fn restart() -> ! {
    heaters_low();
    SCB::sys_reset()
}

/// For the virtual board only: here the timer detects the silence.
pub const fn silence(_: u16) -> bool {
    false
}

/// Only the virtual board provokes faults.
pub const fn provoke(_: wire::Provocation) {}

/// Only the virtual board can leave its emulator; here it restarts.
pub fn finish(_: u8) -> ! {
    restart()
}

/// Sleeps, and tests clock and memories.
pub struct InterruptIdler {
    checks: BackgroundChecks,
    /// The dead-man timer or the watchdog has failed its proof test: until the next start.
    has_failed: bool,
}

impl InterruptIdler {
    /// Proves the dead-man timer, while the control task is held back; false if it has to wait for
    /// a heater that is high.
    pub fn prove_dead_man(&mut self) -> bool {
        let has_passed = dead_man_proof::prove_dead_man();
        self.has_failed |= has_passed == Some(false);
        has_passed.is_some()
    }

    /// Tests clock and a part of the memories, if it is time; a cause if one is defective, or if a
    /// proof test has failed. It comes again after it was acknowledged.
    pub fn check(&mut self) -> Option<Cause> {
        self.checks.check(self.has_failed)
    }

    /// Sleeps until an interrupt. There are no bytes that come without one.
    pub fn wait(&mut self) -> &[u8] {
        cortex_m::asm::wfi();
        &[]
    }
}
