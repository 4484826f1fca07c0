//! What is left to the levels, from the control task to the one that reports it.
//!
//! The control task must not wait, and shares nothing but queues and words: every number is a word of its own, whole at any time. A
//! status in the middle of a command may hold one element's old and new number side by side; the next one does not.

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use dr_core::control::Margins;
use wire::ELEMENTS;

/// Of every element the bits of both numbers; NaN where there is none.
pub struct MarginBoard([[AtomicU32; 2]; ELEMENTS]);

impl MarginBoard {
    /// None of any element.
    pub const fn new() -> Self {
        Self([const { [const { AtomicU32::new(f32::NAN.to_bits()) }; 2] }; ELEMENTS])
    }

    /// Puts up what holds from now on.
    pub fn put(&self, margins: &[Option<Margins>; ELEMENTS]) {
        for ([low, high], margins) in self.0.iter().zip(margins) {
            let none = Margins { above_low_w: f32::NAN, below_high_w: f32::NAN };
            let Margins { above_low_w, below_high_w } = margins.unwrap_or(none);
            low.store(above_low_w.to_bits(), Relaxed);
            high.store(below_high_w.to_bits(), Relaxed);
        }
    }

    /// Reads it.
    pub fn read(&self) -> [Option<Margins>; ELEMENTS] {
        let number = |word: &AtomicU32| f32::from_bits(word.load(Relaxed));
        self.0.each_ref().map(|[low, high]| {
            let margins = Margins { above_low_w: number(low), below_high_w: number(high) };
            (!margins.above_low_w.is_nan() && !margins.below_high_w.is_nan()).then_some(margins)
        })
    }
}

impl Default for MarginBoard {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_what_was_put_up_last() {
        let board = MarginBoard::new();
        assert_eq!(board.read(), [None; ELEMENTS]);
        let mut margins = [None; ELEMENTS];
        margins[2] = Some(Margins { above_low_w: 0.01, below_high_w: 0.03 });
        board.put(&margins);
        assert_eq!(board.read(), margins);
        board.put(&[None; ELEMENTS]);
        assert_eq!(board.read(), [None; ELEMENTS]);
    }
}
