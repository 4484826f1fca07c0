//! External interrupts: an edge on a pin makes an interrupt wait (RM0090, "EXTI", "SYSCFG").

/// Interrupt of EXTI lines 0 to 4, which have an interrupt each.
const FIRST_INTERRUPT: u16 = 6;
/// Interrupt of the voltage detector, which has a line of its own.
const SUPPLY_INTERRUPT: u16 = 1;
const SUPPLY_LINE: u32 = 16;

/// Lines, and which port each listens to.
#[derive(Clone, Copy, Debug, Default)]
pub struct Exti {
    mask: u32,
    event_mask: u32,
    rising: u32,
    falling: u32,
    pending: u32,
    /// SYSCFG_EXTICR1 to 4.
    ports: [u32; 4],
}

impl Exti {
    /// A pin of a port (0 is A) has changed.
    pub const fn edge(&mut self, port: u32, pin: u32, rises: bool) {
        if self.ports[(pin / 4) as usize] >> (4 * (pin % 4)) & 0xf == port {
            self.line_edge(pin, rises);
        }
    }

    /// The output of the voltage detector has changed.
    pub const fn supply_edge(&mut self, rises: bool) {
        self.line_edge(SUPPLY_LINE, rises);
    }

    const fn line_edge(&mut self, line: u32, rises: bool) {
        let edges = if rises { self.rising } else { self.falling };
        // The pending bit is set for lines that are not masked only.
        if edges >> line & 1 == 1 && self.mask >> line & 1 == 1 {
            self.pending |= 1 << line;
        }
    }

    /// The interrupt of the voltage detector, and whether it is held.
    pub const fn supply_line(&self) -> (u16, bool) {
        (SUPPLY_INTERRUPT, self.pending & self.mask & 1 << SUPPLY_LINE != 0)
    }

    /// The interrupt of a line, 0 to 4, and whether it is held.
    pub const fn line(&self, pin: u32) -> (u16, bool) {
        (FIRST_INTERRUPT + pin as u16, self.pending & self.mask & 1 << pin != 0)
    }

    /// Reads a register of EXTI.
    pub const fn load(&self, offset: u32) -> u32 {
        match offset {
            0x00 => self.mask,
            0x04 => self.event_mask,
            0x08 => self.rising,
            0x0c => self.falling,
            0x14 => self.pending,
            _ => 0,
        }
    }

    /// Writes a register of EXTI.
    pub const fn store(&mut self, offset: u32, value: u32) {
        match offset {
            0x00 => self.mask = value,
            0x04 => self.event_mask = value,
            0x08 => self.rising = value,
            0x0c => self.falling = value,
            0x10 => self.pending |= value & self.mask,
            0x14 => self.pending &= !value,
            _ => {}
        }
    }

    /// Reads a register of SYSCFG.
    pub const fn load_config(&self, offset: u32) -> u32 {
        match offset {
            0x08..0x18 => self.ports[(offset / 4 - 2) as usize],
            _ => 0,
        }
    }

    /// Writes a register of SYSCFG.
    pub const fn store_config(&mut self, offset: u32, value: u32) {
        if let 0x08..0x18 = offset {
            self.ports[(offset / 4 - 2) as usize] = value & 0xffff;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_chosen_edge_of_the_chosen_port_counts_until_it_is_cleared() {
        let mut exti = Exti::default();
        exti.store(0x00, 1 << 4);
        exti.store(0x0c, 1 << 4);
        exti.store_config(0x0c, 1);
        exti.edge(0, 4, false);
        exti.edge(1, 4, true);
        assert_eq!(exti.line(4), (10, false));
        exti.edge(1, 4, false);
        assert_eq!(exti.line(4), (10, true));
        exti.store(0x14, 1 << 4);
        assert_eq!(exti.line(4), (10, false));
    }
}
