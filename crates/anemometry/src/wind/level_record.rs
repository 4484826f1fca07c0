//! Which elements stay at one level throughout a recording: at constant current no loop holds them.

use dr_core::control::{MOST_ELEMENTS, RunState, Tick};

/// A loop changes its level far more often than this; the first tick may precede the heating.
const MOST_CHANGES: u32 = 1;

/// Counts changes of the heater levels.
#[derive(Debug, Clone, Default)]
pub struct LevelRecord {
    last: Option<usize>,
    changes: Vec<u32>,
}

impl LevelRecord {
    /// Adds a tick; those without a run count for nothing.
    pub fn add(&mut self, tick: &Tick<MOST_ELEMENTS>) {
        if tick.state != RunState::Running {
            return;
        }
        let changed = self.last.map_or(0, |last| last ^ tick.heaters.0);
        self.changes.resize(tick.elements.into(), 0);
        for (i, count) in self.changes.iter_mut().enumerate() {
            *count += (changed >> i & 1) as u32;
        }
        self.last = Some(tick.heaters.0);
    }

    /// Whether an element stayed at its level all the time.
    pub fn is_constant(&self, element: usize) -> bool {
        self.last.is_some() && self.changes.get(element).is_some_and(|changes| *changes <= MOST_CHANGES)
    }
}

#[cfg(test)]
mod tests {
    use super::super::moment::{ElementReading, Ticks};
    use super::*;

    #[test]
    fn an_element_that_no_loop_holds_stays_at_its_level() {
        let (mut ticks, mut levels) = (Ticks::new(0.01), LevelRecord::default());
        assert!(!levels.is_constant(0));
        for n in 0..100 {
            // The first at the high level from the second tick on, the other with a loop.
            let readings = [n > 0, n % 3 == 0];
            let readings =
                readings.map(|is_high| ElementReading { temperature_c: 20.0, power_w: 0.0, is_high }).into_iter();
            levels.add(&ticks.tick(0.01 * f64::from(n), RunState::Running, readings));
        }
        assert!(levels.is_constant(0) && !levels.is_constant(1));
    }
}
