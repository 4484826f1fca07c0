//! Readings that stand while the model moves: a clipped range, or a sensor that is stuck.
//!
//! A sensor that rests or is read coarsely stands as well, but there the model moves by no more than
//! its step and its noise.

/// Rows of one value that are looked at.
const FEWEST: u64 = 5;
/// Motion of the model, in steps and noises of the reading, that no reading stands through.
const FAR: f64 = 8.0;

/// Rows of one value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StuckRun {
    pub value: f64,
    /// Its first row, counted from 1, and all rows of runs of that value.
    pub first_row: u64,
    pub rows: u64,
    /// Motion of the model in the run in which it moves most.
    pub moved: f64,
    /// The value is the least or the greatest of all.
    pub is_extreme: bool,
}

/// The present run of one value, and the runs in which the model moved most.
#[derive(Debug, Clone, Default)]
pub struct StuckReadings {
    rows: u64,
    last: Option<(f64, f64)>,
    begin: u64,
    /// Least and greatest prediction of the run.
    span: [f64; 2],
    range: [f64; 2],
    /// The least step between two readings that differ, and squares of what the model leaves of steps.
    step: f64,
    left: f64,
    steps: u64,
    worst: Option<StuckRun>,
}

impl StuckReadings {
    /// Takes the next row.
    pub fn push(&mut self, measured: f64, predicted: f64) {
        self.rows += 1;
        if let Some((value, before)) = self.last
            && value == measured
        {
            self.span = [self.span[0].min(predicted), self.span[1].max(predicted)];
            self.last = Some((value, before));
            return;
        }
        self.end_run();
        if let Some((value, before)) = self.last {
            let step = (measured - value).abs();
            self.step = if self.steps == 0 { step } else { self.step.min(step) };
            self.left += (measured - value - (predicted - before)).powi(2);
            self.steps += 1;
            self.range = [self.range[0].min(measured), self.range[1].max(measured)];
        } else {
            self.range = [measured; 2];
        }
        (self.last, self.begin, self.span) = (Some((measured, predicted)), self.rows, [predicted; 2]);
    }

    fn end_run(&mut self) {
        let Some((value, _)) = self.last else { return };
        let (rows, moved) = (self.rows - self.begin, self.span[1] - self.span[0]);
        if rows < FEWEST {
            return;
        }
        match &mut self.worst {
            Some(worst) if worst.value == value => {
                worst.rows += rows;
                worst.moved = worst.moved.max(moved);
            }
            Some(worst) if worst.moved >= moved => {}
            worst => *worst = Some(StuckRun { value, first_row: self.begin, rows, moved, is_extreme: false }),
        }
    }

    /// The value that stood while the model moved most, if that is more than readings explain.
    pub fn found(&self) -> Option<StuckRun> {
        let mut ended = self.clone();
        ended.rows += 1;
        ended.end_run();
        let worst = ended.worst?;
        // Two noises make a step.
        let noise = (0.5 * self.left / (self.steps as f64).max(1.0)).sqrt();
        let is_extreme = self.range.contains(&worst.value);
        (self.steps > 0 && worst.moved > FAR * (self.step + noise)).then_some(StuckRun { is_extreme, ..worst })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sine of 10 K that a sensor reads in steps, as `read` changes it.
    fn found(step: f64, read: impl Fn(usize, f64) -> f64) -> Option<StuckRun> {
        let mut readings = StuckReadings::default();
        for n in 0..3000 {
            let predicted = 30.0 + 10.0 * libm::sin(n as f64 / 100.0);
            readings.push(read(n, (predicted / step).round() * step), predicted);
        }
        readings.found()
    }

    #[test]
    fn a_clipped_and_a_stuck_sensor_are_found_and_a_coarse_one_is_not() {
        assert_eq!(found(0.01, |_, value| value), None);
        assert_eq!(found(1.0, |_, value| value), None);
        let clipped = found(0.01, |_, value| value.min(36.0)).unwrap();
        assert!(clipped.is_extreme && clipped.value == 36.0 && clipped.first_row == 66, "{clipped:?}");
        assert!((clipped.rows as f64 / 3000.0 - 0.295).abs() < 0.02, "{clipped:?}");
        let stuck = found(0.01, |n, value| if (500..800).contains(&n) { 33.0 } else { value }).unwrap();
        assert!(!stuck.is_extreme && (stuck.first_row, stuck.rows) == (501, 300), "{stuck:?}");
        assert!(found(1.0, |n, value| if (500..800).contains(&n) { 33.0 } else { value }).is_some());
    }
}
