//! Reset and clock control: crystal, PLL, prescalers, clock gates, reset flags (RM0090, "RCC").
//!
//! ```text
//! f_VCO = f_source / PLLM · PLLN,   f_PLL = f_VCO / PLLP
//! ```

use super::access::{Access, Clocks};
use crate::complaint::BrokenRule;
use crate::time::us;

/// The crystal of the board, and the oscillator that the core starts on.
const CRYSTAL_HZ: u64 = 8_000_000;
const INTERNAL_HZ: u64 = 16_000_000;
/// Start-up of the crystal, 2 ms typical in the data sheet; lock time of the PLL, 75 to 200 µs.
const CRYSTAL_STARTS: u64 = us(2_000);
const PLL_LOCKS: u64 = us(150);

const HSEON: u32 = 1 << 16;
const HSERDY: u32 = 1 << 17;
const CSSON: u32 = 1 << 19;
const PLLON: u32 = 1 << 24;
const PLLRDY: u32 = 1 << 25;
const CSSF: u32 = 1 << 7;
const CSSC: u32 = 1 << 23;
const RMVF: u32 = 1 << 24;
/// The clock of the core's own memory, on after a reset.
const CORE_MEMORY: u32 = 1 << 20;
const LSION: u32 = 1;
const LSIRDY: u32 = 1 << 1;

/// Why the processor was reset, as its flags say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResetSource {
    /// The supply has risen, from nothing.
    PowerOn,
    /// The supply has dipped, and the detector for that was on.
    BrownOut,
    /// The reset pin.
    Pin,
    /// The firmware has asked for it.
    Software,
    /// The independent watchdog.
    Watchdog,
}

impl ResetSource {
    /// Flags in RCC_CSR: every reset pulls the pin. That of the power-on stays clear after a mere
    /// brown-out, as the bit's description has it; the register's reset value has both.
    const fn flags(self) -> u32 {
        const PIN: u32 = 1 << 26;
        match self {
            Self::PowerOn => PIN | 1 << 25 | 1 << 27,
            Self::BrownOut => PIN | 1 << 25,
            Self::Pin => PIN,
            Self::Software => PIN | 1 << 28,
            Self::Watchdog => PIN | 1 << 29,
        }
    }
}

/// The controller.
#[derive(Clone, Debug)]
pub struct Rcc {
    control: u32,
    pll: u32,
    config: u32,
    interrupt: u32,
    resets: [u32; 3],
    gates: [u32; 3],
    status: u32,
    crystal_ready_at: u64,
    pll_ready_at: u64,
    crystal_hz: u64,
    crystal_failed: bool,
}

impl Rcc {
    /// After a reset; flags of earlier ones are in `before`.
    pub const fn after(source: ResetSource, before: u32) -> Self {
        let kept = match source {
            ResetSource::PowerOn | ResetSource::BrownOut => 0,
            _ => before & 0xfe00_0000,
        };
        Self {
            control: 0x83,
            pll: 0x2400_3010,
            config: 0,
            interrupt: 0,
            resets: [0; 3],
            gates: [CORE_MEMORY, 0, 0],
            status: source.flags() | kept,
            crystal_ready_at: 0,
            pll_ready_at: 0,
            crystal_hz: CRYSTAL_HZ,
            crystal_failed: false,
        }
    }

    /// RCC_CSR.
    pub const fn status(&self) -> u32 {
        self.status
    }

    /// Clock gates of AHB1, APB1, APB2.
    pub const fn gates(&self) -> [u32; 3] {
        self.gates
    }

    /// Peripherals held in reset, of the same buses.
    pub const fn resets(&self) -> [u32; 3] {
        self.resets
    }

    /// The crystal that is fitted, Hz.
    pub const fn crystal_hz(&self) -> u64 {
        self.crystal_hz
    }

    /// Another crystal is fitted.
    pub const fn fit_crystal(&mut self, crystal_hz: u64) {
        self.crystal_hz = crystal_hz;
    }

    /// The crystal runs again.
    pub const fn mend_crystal(&mut self) {
        self.crystal_failed = false;
    }

    /// The crystal stops. Returns whether the clock security system notices, which then takes the
    /// internal oscillator and raises the non-maskable interrupt.
    pub const fn fail_crystal(&mut self) -> bool {
        self.crystal_failed = true;
        let notices = self.control & CSSON != 0;
        if notices {
            self.control &= !(HSEON | PLLON);
            self.config &= !3;
            self.interrupt |= CSSF;
        }
        notices
    }

    /// Tells whether the clock security system holds the non-maskable interrupt.
    pub const fn security_interrupt(&self) -> bool {
        self.interrupt & CSSF != 0
    }

    const fn pll_source_hz(&self) -> u64 {
        match (self.pll >> 22 & 1, self.crystal_failed) {
            (0, _) => INTERNAL_HZ,
            (_, false) => self.crystal_hz,
            (_, true) => 0,
        }
    }

    const fn pll_input_hz(&self) -> u64 {
        match self.pll_source_hz().checked_div((self.pll & 0x3f) as u64) {
            Some(input_hz) => input_hz,
            None => 0,
        }
    }

    const fn pll_hz(&self) -> u64 {
        self.pll_input_hz() * (self.pll >> 6 & 0x1ff) as u64 / (2 * (self.pll >> 16 & 3) as u64 + 2)
    }

    /// Frequencies of all buses now.
    pub fn clocks(&self) -> Clocks {
        let system = match self.config & 3 {
            0 => INTERNAL_HZ,
            1 if self.crystal_failed => 0,
            1 => self.crystal_hz,
            _ => self.pll_hz(),
        };
        let ahb_divider = match self.config >> 4 & 0xf {
            0..=7 => 1,
            n @ 8..=11 => 2 << (n - 8),
            n => 64 << (n - 12),
        };
        let apb_divider = |bits: u32| if bits & 4 == 0 { 1 } else { 2 << (bits & 3) };
        let core = system / ahb_divider;
        let (one, two) = (apb_divider(self.config >> 10 & 7), apb_divider(self.config >> 13 & 7));
        Clocks {
            core_hz: core,
            apb1_hz: core / one,
            apb2_hz: core / two,
            // Timers run at twice a bus that is divided.
            timers1_hz: core / one * if one == 1 { 1 } else { 2 },
        }
    }

    /// Reads a register.
    pub fn load(&self, offset: u32, access: &mut Access<'_>) -> u32 {
        match offset {
            0x00 => {
                let crystal = self.control & HSEON != 0 && !self.crystal_failed && access.now >= self.crystal_ready_at;
                let pll = self.control & PLLON != 0 && access.now >= self.pll_ready_at && self.pll_source_hz() != 0;
                self.control | if crystal { HSERDY } else { 0 } | if pll { PLLRDY } else { 0 }
            }
            0x04 => self.pll,
            0x08 => self.config | (self.config & 3) << 2,
            0x0c => self.interrupt,
            0x10 => self.resets[0],
            0x20 => self.resets[1],
            0x24 => self.resets[2],
            0x30 => self.gates[0],
            0x40 => self.gates[1],
            0x44 => self.gates[2],
            0x74 if self.status & LSION != 0 => self.status | LSIRDY,
            0x74 => self.status,
            _ => 0,
        }
    }

    /// Writes a register; `wait_states` are those of the flash.
    pub fn store(&mut self, offset: u32, value: u32, wait_states: u32, access: &mut Access<'_>) {
        match offset {
            0x00 => self.set_control(value, access),
            0x04 => {
                if self.control & PLLON != 0 {
                    access.complain("RCC_PLLCFGR", BrokenRule::PllChangedWhileOn);
                }
                self.pll = value;
            }
            0x08 => self.set_config(value, wait_states, access),
            0x0c => self.interrupt &= !if value & CSSC != 0 { CSSF } else { 0 },
            0x10 => self.resets[0] = value,
            0x20 => self.resets[1] = value,
            0x24 => self.resets[2] = value,
            0x30 => self.gates[0] = value,
            0x40 => self.gates[1] = value,
            0x44 => self.gates[2] = value,
            0x74 => {
                let kept = if value & RMVF != 0 { 0 } else { self.status & 0xfe00_0000 };
                self.status = kept | value & 1;
            }
            _ => {}
        }
    }

    fn set_control(&mut self, value: u32, access: &mut Access<'_>) {
        let rises = value & !self.control;
        if rises & HSEON != 0 {
            self.crystal_ready_at = access.now + CRYSTAL_STARTS;
        }
        if rises & PLLON != 0 {
            self.pll_ready_at = access.now + PLL_LOCKS;
            let from_crystal = self.pll >> 22 & 1 == 1;
            let is_ready = !from_crystal || value & HSEON != 0 && access.now >= self.crystal_ready_at;
            let vco_hz = self.pll_input_hz() * u64::from(self.pll >> 6 & 0x1ff);
            let fits =
                (1_000_000..=2_000_000).contains(&self.pll_input_hz()) && (100_000_000..=432_000_000).contains(&vco_hz);
            if !is_ready || !fits {
                access.complain("RCC_CR", BrokenRule::PllRange);
            }
        }
        self.control = value & !(HSERDY | PLLRDY);
    }

    fn set_config(&mut self, value: u32, wait_states: u32, access: &mut Access<'_>) {
        self.config = value & !0xc;
        let is_ready = match value & 3 {
            0 => true,
            1 => self.control & HSEON != 0 && access.now >= self.crystal_ready_at,
            _ => self.control & PLLON != 0 && access.now >= self.pll_ready_at,
        };
        if !is_ready {
            access.complain("RCC_CFGR", BrokenRule::ClockNotReady);
        }
        let clocks = self.clocks();
        if clocks.core_hz > 168_000_000 || clocks.apb1_hz > 42_000_000 || clocks.apb2_hz > 84_000_000 {
            access.complain("RCC_CFGR", BrokenRule::ClockTooFast);
        }
        check_wait_states(clocks.core_hz, wait_states, "RCC_CFGR", access);
    }
}

/// Wait states that a clock needs at 2.7 V and more: one for each 30 MHz begun (RM0090, table
/// "Number of wait states according to CPU clock frequency").
pub fn check_wait_states(core_hz: u64, set: u32, register: &'static str, access: &mut Access<'_>) {
    let needed = (core_hz.div_ceil(30_000_000) as u32).saturating_sub(1);
    if set < needed {
        access.complain(register, BrokenRule::WaitStates { needed, set });
    }
}
