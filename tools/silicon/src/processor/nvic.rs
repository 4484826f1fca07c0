//! Exceptions that wait and run, and their order (ARMv7-M architecture, "Exception model").
//!
//! Exceptions go by their numbers: 2 NMI, 3 hard fault, 14 PendSV, 15 SysTick, 16 + n interrupt n.
//! A lower priority value goes first; of equal ones, the lower number. The STM32F405 keeps the
//! upper four bits of a priority. There is no grouping into sub-priorities: the firmware asks for
//! none.
//!
//! An interrupt's line may be held high by its peripheral; it then waits again as soon as its
//! handler has returned.

/// Exceptions: 16 of the core, 82 interrupts.
const EXCEPTIONS: usize = 16 + 96;

/// Number of the non-maskable interrupt.
pub const NMI: u16 = 2;
/// Number of the hard fault.
pub const HARD_FAULT: u16 = 3;
/// Number of PendSV.
pub const PENDSV: u16 = 14;
/// Number of SysTick.
pub const SYSTICK: u16 = 15;
/// Number of the first interrupt.
pub const FIRST_INTERRUPT: u16 = 16;

/// Priority of a core that handles nothing: below all others.
pub const THREAD_PRIORITY: i32 = 256;

/// Exceptions that wait, run and may run.
#[derive(Clone, Debug)]
pub struct Nvic {
    enabled: u128,
    pending: u128,
    /// Lines that a peripheral holds high.
    lines: u128,
    priority: [u8; EXCEPTIONS],
    /// The last one runs, the others were interrupted.
    active: Vec<u16>,
    /// Exceptions that have been entered and left, if somebody wants it.
    pub trace: Option<Vec<ExceptionStep>>,
}

/// A handler begins or returns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExceptionStep {
    /// That of this exception begins.
    Enter(u16),
    /// It returns.
    Leave(u16),
}

impl Default for Nvic {
    fn default() -> Self {
        Self { enabled: 0xffff, pending: 0, lines: 0, priority: [0; EXCEPTIONS], active: Vec::new(), trace: None }
    }
}

impl Nvic {
    /// An exception waits from now on.
    pub const fn pend(&mut self, exception: u16) {
        self.pending |= 1 << exception;
    }

    /// A peripheral holds its line high, or lets it go. A line that rises makes its interrupt wait.
    pub const fn set_line(&mut self, interrupt: u16, high: bool) {
        let bit = 1 << (FIRST_INTERRUPT + interrupt);
        if high {
            self.pending |= bit & !self.lines;
            self.lines |= bit;
        } else {
            self.lines &= !bit;
        }
    }

    /// Returns true if a peripheral holds its line high.
    pub const fn line(&self, interrupt: u16) -> bool {
        self.lines >> (FIRST_INTERRUPT + interrupt) & 1 == 1
    }

    /// The exception whose handler runs; 0 if none does.
    pub fn handled(&self) -> u16 {
        self.active.last().copied().unwrap_or(0)
    }

    /// Priority of what runs.
    pub fn running_priority(&self) -> i32 {
        self.active.iter().map(|&exception| self.priority_of(exception)).min().unwrap_or(THREAD_PRIORITY)
    }

    /// Tells whether something waits that would wake a sleeping core.
    pub const fn wakes(&self) -> bool {
        self.pending & self.enabled != 0
    }

    /// The first of those that wait, if it goes before `priority`.
    pub fn next_before(&self, priority: i32) -> Option<u16> {
        let mut waiting = self.pending & self.enabled;
        let mut first: Option<(i32, u16)> = None;
        while waiting != 0 {
            let exception = waiting.trailing_zeros() as u16;
            waiting &= waiting - 1;
            let candidate = (self.priority_of(exception), exception);
            first = Some(first.map_or(candidate, |first| first.min(candidate)));
        }
        first.filter(|first| first.0 < priority).map(|first| first.1)
    }

    /// Its handler begins.
    pub fn enter(&mut self, exception: u16) {
        self.pending &= !(1 << exception);
        self.active.push(exception);
        self.trace.iter_mut().for_each(|trace| trace.push(ExceptionStep::Enter(exception)));
    }

    /// Its handler returns; a line that is still high makes it wait again.
    pub fn leave(&mut self, exception: u16) {
        self.active.retain(|&running| running != exception);
        self.trace.iter_mut().for_each(|trace| trace.push(ExceptionStep::Leave(exception)));
        self.pending |= self.lines & 1 << exception;
    }

    /// One if an exception waits, else zero.
    pub const fn waits(&self, exception: u16) -> u32 {
        (self.pending >> exception & 1) as u32
    }

    /// Reads 32 interrupts' bits: enabled ones, or waiting ones.
    pub const fn read_word(&self, word: u32, waiting: bool) -> u32 {
        let bits = if waiting { self.pending } else { self.enabled };
        (bits >> FIRST_INTERRUPT >> (32 * word)) as u32
    }

    /// Enables interrupts of a word, or disables them.
    pub const fn write_enable(&mut self, word: u32, bits: u32, enable: bool) {
        let bits = (bits as u128) << FIRST_INTERRUPT << (32 * word);
        if enable { self.enabled |= bits } else { self.enabled &= !bits }
    }

    /// Makes interrupts of a word wait, or not wait. Those whose line is high go on waiting.
    pub const fn write_pending(&mut self, word: u32, bits: u32, set: bool) {
        let bits = (bits as u128) << FIRST_INTERRUPT << (32 * word);
        if set { self.pending |= bits } else { self.pending &= !(bits & !self.lines) }
    }

    /// The priority byte of an exception, as its register holds it.
    pub const fn priority_byte(&self, exception: u16) -> u8 {
        self.priority[exception as usize]
    }

    /// Sets it; only the upper four bits are kept.
    pub const fn set_priority_byte(&mut self, exception: u16, priority: u8) {
        // Numbers that no exception has.
        if matches!(exception, 7..=10 | 13) {
            return;
        }
        self.priority[exception as usize] = priority & 0xf0;
    }

    fn priority_of(&self, exception: u16) -> i32 {
        match exception {
            NMI => -2,
            HARD_FAULT => -1,
            _ => i32::from(self.priority[usize::from(exception)]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nvic(priorities: &[(u16, u8)]) -> Nvic {
        let mut nvic = Nvic::default();
        for &(interrupt, priority) in priorities {
            nvic.set_priority_byte(FIRST_INTERRUPT + interrupt, priority);
            nvic.write_enable(u32::from(interrupt) / 32, 1 << (interrupt % 32), true);
        }
        nvic
    }

    #[test]
    fn the_lower_value_goes_first_and_of_equals_the_lower_number() {
        let mut nvic = nvic(&[(10, 0x50), (38, 0x30), (50, 0x30)]);
        for interrupt in [10, 50, 38] {
            nvic.pend(FIRST_INTERRUPT + interrupt);
        }
        for expected in [38, 50, 10] {
            let next = nvic.next_before(THREAD_PRIORITY).unwrap();
            assert_eq!(next, FIRST_INTERRUPT + expected);
            nvic.enter(next);
            nvic.leave(next);
        }
        assert_eq!(nvic.next_before(THREAD_PRIORITY), None);
    }

    #[test]
    fn only_what_goes_before_the_running_one_interrupts_it() {
        let mut nvic = nvic(&[(10, 0x50), (38, 0x30)]);
        nvic.enter(FIRST_INTERRUPT + 38);
        nvic.pend(FIRST_INTERRUPT + 10);
        assert_eq!(nvic.next_before(nvic.running_priority()), None);
        nvic.pend(NMI);
        assert_eq!(nvic.next_before(nvic.running_priority()), Some(NMI));
    }

    #[test]
    fn a_line_that_stays_high_waits_again_after_its_handler_and_a_disabled_one_never() {
        let mut nvic = nvic(&[(10, 0x50)]);
        nvic.set_line(10, true);
        nvic.set_line(11, true);
        for _ in 0..2 {
            assert_eq!(nvic.next_before(THREAD_PRIORITY), Some(26));
            nvic.enter(26);
            assert_eq!(nvic.next_before(THREAD_PRIORITY), None);
            nvic.leave(26);
        }
        nvic.enter(26);
        nvic.set_line(10, false);
        nvic.leave(26);
        assert!(!nvic.wakes());
    }
}
