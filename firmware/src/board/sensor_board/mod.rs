//! The sensor board: STM32F405, six heated elements, an ADS131E06, the host on USART2. Its circuit
//! is in `docs/reference/board.md`.
//!
//! | file | what |
//! |---|---|
//! | `table.rs` | pins, vectors, limits |
//! | `front_end.rs` | ADC and heater pins: readings in, levels out |
//!
//! Nothing of this has run on a board yet.

mod front_end;
pub mod table;

pub use crate::mcu::stm32f4::dma_link::{HostReceiver, HostTransmitter, acknowledge_received, acknowledge_sent};
pub use crate::mcu::stm32f4::{
    clocks::CLOCK_HZ, dead_man::acknowledge as acknowledge_dead_man, flash::SettingsFlash, reset_as_remembered,
    supply::acknowledge as acknowledge_supply, supply::is_low as is_supply_low, unique_id,
};
pub use front_end::FrontEnd;
pub use table::{ELEMENTS, HARDWARE_LIMITS, IS_VIRTUAL, KIND, NAME};

use super::BoardParts;
use crate::mcu::stm32f4::{clocks, dma_link, memory_protection, port, supply};
use crate::mcu::stm32f4::{dead_man, dead_man::DeadManTimer, memory_check::BackgroundChecks, watchdog};
use cortex_m::peripheral::SCB;
use dr_core::control::Cause;
use firmware::drivers::heater_pins::HeaterPins;
use firmware::mcu::stm32f4::reset_flags;
use front_end::AdcPins;
use heapless::spsc::Consumer;
use stm32f4xx_hal::gpio::PinState;
use stm32f4xx_hal::pac;
use stm32f4xx_hal::prelude::*;
use table::{FIRST_PERIOD_US, HEATER_MASK, HEATER_PORT, HOST_BAUD, HeaterPin, LedPin};

/// Resets the board unless it is fed.
pub type Watchdog = watchdog::Watchdog<LedPin>;

/// HeaterPort low, clocks, link, ADC; 0.5 s, most of it the ADC's reference and offsets.
///
/// Called with interrupts disabled. An ADC that does not respond is no reason to stop: the board
/// then reports every reading as missing, and the guard keeps the heaters low.
#[expect(clippy::expect_used, reason = "start-up, before any heater is raised")]
pub fn init(
    device: pac::Peripherals,
    core: &mut cortex_m::Peripherals,
    _: Consumer<'static, firmware::inbox::Exchange>,
) -> BoardParts {
    memory_protection::start(&core.MPU);
    let mut rcc = device.RCC.constrain();
    let gpioc = device.GPIOC.split(&mut rcc);
    let heaters = [
        gpioc.pc0.erase_number(),
        gpioc.pc1.erase_number(),
        gpioc.pc2.erase_number(),
        gpioc.pc3.erase_number(),
        gpioc.pc4.erase_number(),
        gpioc.pc5.erase_number(),
    ];
    let heaters = HeaterPins::new(heaters.map(HeaterPin::new)).expect("writing a pin of this processor cannot fail");

    supply::start_detector(&device.PWR, &mut rcc);
    let flags = rcc.csr().read().bits();
    supply::ensure_brown_out_level(&device.FLASH, flags);
    let reset = reset_flags::cause(flags);
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    let (reset, watchdog_works) = watchdog::prove(reset);
    watchdog::start();
    let mut rcc = clocks::start(rcc, core);

    let gpioa = device.GPIOA.split(&mut rcc);
    let gpiob = device.GPIOB.split(&mut rcc);
    let mut watchdog = Watchdog::new(&device.DBGMCU, gpiob.pb1.into_push_pull_output());
    clocks::start_stopwatch(&device.TIM2, &mut rcc);
    let (host_transmitter, host_receiver) =
        dma_link::start(device.USART2, device.DMA1, (gpioa.pa2, gpioa.pa3), HOST_BAUD, &mut rcc);
    let pins = AdcPins {
        select: gpioa.pa4.into_push_pull_output_in_state(PinState::High),
        bus: (gpioa.pa5, gpioa.pa6, gpioa.pa7),
        // The pull-up that the pin had as JTAG reset stays, in case the ADC is not there to drive
        // it.
        data_ready: gpiob.pb4.into_pull_up_input(),
        reset: gpiob.pb0.into_push_pull_output_in_state(PinState::High),
    };
    supply::listen(&device.EXTI);
    let dead_man = DeadManTimer::new(device.TIM5, FIRST_PERIOD_US, &mut rcc);
    let front_end = FrontEnd::start(device.SPI1, pins, device.EXTI, device.SYSCFG, heaters, dead_man, &mut rcc);
    watchdog.expect_check_ins();
    BoardParts {
        front_end,
        host_receiver,
        host_transmitter,
        watchdog,
        idler: Idler { checks: BackgroundChecks::new(), has_failed: !watchdog_works },
        settings: SettingsFlash::new(device.FLASH),
        reset,
    }
}

/// Puts all heaters at the low level at once, whatever state the rest is in.
pub fn heaters_low() {
    port::write::<HEATER_PORT>(HEATER_MASK << 16);
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
pub struct Idler {
    checks: BackgroundChecks,
    /// The dead-man timer or the watchdog has failed its proof test: until the next start.
    has_failed: bool,
}

impl Idler {
    /// Proves the dead-man timer, while the control task is held back; false if it has to wait for
    /// a heater that is high.
    pub fn prove_dead_man(&mut self) -> bool {
        let has_passed = dead_man::prove::<HEATER_PORT>(HEATER_MASK);
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
