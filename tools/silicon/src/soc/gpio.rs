//! Ports A, B and C (RM0090, "General-purpose I/Os").
//!
//! A pin that is no output floats, and reads as what is connected to it or as its pull says.

/// Registers of a port, by their offset in words.
#[derive(Clone, Copy, Debug, Default)]
pub struct GpioPort {
    modes: u32,
    others: [u32; 3],
    output: u32,
    lock: u32,
    alternate: [u32; 2],
}

impl GpioPort {
    /// Port A: the debug pins, JTMS and JTDI pulled up, JTCK down.
    pub const PORT_A: Self = Self::after_reset(0xa800_0000, 0x0c00_0000, 0x6400_0000);
    /// Port B: JTDO, and JTRST pulled up.
    pub const PORT_B: Self = Self::after_reset(0x280, 0xc0, 0x100);

    /// Offset of the register that has the levels at the pins.
    pub const INPUT: u32 = 0x10;

    const fn after_reset(modes: u32, speeds: u32, pulls: u32) -> Self {
        Self { modes, others: [0, speeds, pulls], output: 0, lock: 0, alternate: [0; 2] }
    }

    /// Pins that drive themselves high; all other outputs are low, the rest floats.
    pub fn driven_high(&self) -> u32 {
        (0..16).fold(0, |high, pin| high | u32::from(self.is_output(pin) && self.output >> pin & 1 == 1) << pin)
    }

    /// Pins that nothing in the port drives or pulls: inputs, and analogue ones.
    pub fn floating(&self) -> u32 {
        let floats = |pin| !self.is_output(pin) && self.others[2] >> (2 * pin) & 3 == 0;
        (0..16).fold(0, |pins, pin| pins | u32::from(floats(pin)) << pin)
    }

    /// Tells whether a pin drives itself.
    pub const fn is_output(&self, pin: u32) -> bool {
        self.modes >> (2 * pin) & 3 == 1
    }

    /// Tells whether a pin is driven low by its own output.
    pub const fn drives_low(&self, pin: u32) -> bool {
        self.is_output(pin) && self.output >> pin & 1 == 0
    }

    /// Tells whether a pin belongs to this alternate function.
    pub const fn has_function(&self, pin: u32, function: u32) -> bool {
        self.modes >> (2 * pin) & 3 == 2 && self.alternate[(pin / 8) as usize] >> (4 * (pin % 8)) & 0xf == function
    }

    /// OSPEEDR of a pin.
    pub const fn speed(&self, pin: u32) -> usize {
        (self.others[1] >> (2 * pin) & 3) as usize
    }

    /// Levels at the pins; `outside` are those that somebody else drives high.
    fn levels(&self, outside: u32) -> u32 {
        (0..16).fold(0, |levels, pin| {
            let high = match self.is_output(pin) {
                true => self.output >> pin & 1 == 1,
                false => outside >> pin & 1 == 1 || self.others[2] >> (2 * pin) & 3 == 1,
            };
            levels | u32::from(high) << pin
        })
    }

    /// Reads a register. Bits of `outside` are driven high by somebody else, those of `low` low.
    pub fn load(&self, offset: u32, outside: u32, low: u32) -> u32 {
        match offset {
            0x00 => self.modes,
            0x04..0x10 => self.others[(offset / 4 - 1) as usize],
            Self::INPUT => self.levels(outside) & !low,
            0x14 => self.output,
            0x1c => self.lock,
            0x20 | 0x24 => self.alternate[(offset / 4 - 8) as usize],
            _ => 0,
        }
    }

    /// Writes a register.
    pub const fn store(&mut self, offset: u32, value: u32) {
        match offset {
            0x00 => self.modes = value,
            0x04 | 0x08 | 0x0c => self.others[(offset / 4 - 1) as usize] = value,
            0x14 => self.output = value & 0xffff,
            // Setting wins over clearing.
            0x18 => self.output = self.output & !(value >> 16) | value & 0xffff,
            0x1c => self.lock = value,
            0x20 | 0x24 => self.alternate[(offset / 4 - 8) as usize] = value,
            _ => {}
        }
    }
}
