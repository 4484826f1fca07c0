//! Margins to the levels, from the control task to the task that reports them.
//!
//! The control task must not wait, and shares nothing but queues and words: every number is a word
//! of its own, whole at any time. A status in the middle of a command may hold one element's old
//! and new number side by side; the next one does not.

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use dr_core::control::Margins;
use wire::List;

/// A board for up to N elements.
pub struct MarginBoard<const N: usize> {
    /// How many there are.
    elements: AtomicU32,
    /// Of every element the bits of both numbers; NaN where there is none.
    margins: [[AtomicU32; 2]; N],
}

impl<const N: usize> MarginBoard<N> {
    /// Of no element.
    pub const fn new() -> Self {
        let margins = [const { [const { AtomicU32::new(f32::NAN.to_bits()) }; 2] }; N];
        Self { elements: AtomicU32::new(0), margins }
    }

    /// Puts up what holds from now on, of as many elements as there are.
    pub fn put(&self, margins: impl Iterator<Item = Option<Margins>>) {
        let mut elements = 0;
        for ([low, high], margins) in self.margins.iter().zip(margins) {
            let none = Margins { above_low_w: f32::NAN, below_high_w: f32::NAN };
            let Margins { above_low_w, below_high_w } = margins.unwrap_or(none);
            low.store(above_low_w.to_bits(), Relaxed);
            high.store(below_high_w.to_bits(), Relaxed);
            elements += 1;
        }
        self.elements.store(elements, Relaxed);
    }

    /// Reads it.
    pub fn read(&self) -> List<Option<Margins>> {
        let number = |word: &AtomicU32| f32::from_bits(word.load(Relaxed));
        let mut read = List::new();
        for [low, high] in self.margins.iter().take(self.elements.load(Relaxed) as usize) {
            let margins = Margins { above_low_w: number(low), below_high_w: number(high) };
            let known = !margins.above_low_w.is_nan() && !margins.below_high_w.is_nan();
            // No board has more elements than a list has room for.
            read.push(known.then_some(margins)).ok();
        }
        read
    }
}

impl<const N: usize> Default for MarginBoard<N> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_what_was_put_up_last() {
        let board = MarginBoard::<4>::new();
        assert_eq!(board.read(), []);
        let mut margins = [None; 3];
        margins[1] = Some(Margins { above_low_w: 0.01, below_high_w: 0.03 });
        board.put(margins.into_iter());
        assert_eq!(board.read(), margins);
        board.put([None; 2].into_iter());
        assert_eq!(board.read(), [None; 2]);
    }
}
