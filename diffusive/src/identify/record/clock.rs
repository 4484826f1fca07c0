//! Whether the time written in the rows is uniform.
//!
//! Two conditions, for a lost row must not pass, nor a rate that drifts, while a rounded time may:
//! every step lies within 10 % of the usual one, |t_n − t_{n−1} − ΔT| ≤ 0.1 ΔT, and every time
//! within half a period of its place, |t_n − t_0 − n T| ≤ T/2.
//!
//! T is the mean of all steps, so a gap makes it too long, and the rows before the gap seem to
//! drift. Hence a drift is only told once the rest of the record was searched for a gap
//! ([`Clock::gap`]).

use recording::text::tidy;

/// What part of the usual step a step may be off.
const STEP_TOLERANCE: f64 = 0.1;

/// Why a record's time is not uniform.
#[derive(Debug)]
pub(super) struct ClockFault {
    pub sentence: String,
    pub is_drift: bool,
}

#[derive(Debug, Clone)]
pub(super) struct Clock {
    pub first_s: f64,
    pub period_s: f64,
    /// The median of the first steps: a written time may be rounded, so it is not quite the period.
    pub step_s: f64,
    /// Time of the row before.
    last_s: Option<f64>,
    rows: u64,
}

impl Clock {
    pub(super) fn new(first_s: f64, period_s: f64, step_s: f64) -> Self {
        Self { first_s, period_s, step_s, last_s: None, rows: 0 }
    }

    pub(super) fn restart(&mut self) {
        self.last_s = None;
        self.rows = 0;
    }

    /// How many rows have passed.
    pub(super) fn rows(&self) -> u64 {
        self.rows
    }

    /// Checks the times of the next rows.
    ///
    /// # Errors
    /// A sentence that names the row (counted from 1) and the column, and whether a gap further on
    /// may be to blame.
    pub(super) fn pass(&mut self, column: &str, time_s: &[f64]) -> Result<(), ClockFault> {
        let mut last_s = self.last_s.unwrap_or(self.first_s - self.step_s);
        let (low_s, high_s) = (self.step_s * (1.0 - STEP_TOLERANCE), self.step_s * (1.0 + STEP_TOLERANCE));
        let half_s = 0.5 * self.period_s;
        for (at, &now_s) in time_s.iter().enumerate() {
            let step_s = now_s - last_s;
            let due_s = self.first_s + (self.rows + at as u64) as f64 * self.period_s;
            // Written so that a NaN fails.
            if !(step_s >= low_s && step_s <= high_s && (now_s - due_s).abs() <= half_s) {
                return Err(self.fault(column, at, last_s, now_s));
            }
            last_s = now_s;
        }
        self.last_s = time_s.last().copied().or(self.last_s);
        self.rows += time_s.len() as u64;
        Ok(())
    }

    /// The first step that is off the usual one, whatever the mean period, as a sentence; `from` is
    /// where its rows begin.
    pub(super) fn gap(&self, column: &str, from: u64, last_s: Option<f64>, time_s: &[f64]) -> Option<String> {
        let before = last_s.into_iter().chain(time_s.iter().copied());
        let skipped = usize::from(last_s.is_none());
        let mut steps = before.zip(&time_s[skipped..]).enumerate();
        steps
            .find_map(|(at, (last_s, &now_s))| self.step_fault(column, from + (at + skipped) as u64 + 1, last_s, now_s))
    }

    /// What is wrong with one step, whatever the mean period.
    fn step_fault(&self, column: &str, row: u64, last_s: f64, now_s: f64) -> Option<String> {
        if !now_s.is_finite() {
            return Some(format!("row {row}, column `{column}`: the time is missing; cut the record there"));
        }
        if row > 1 && now_s <= last_s {
            return Some(format!(
                "row {row}: `{column}` goes from {last_s} s to {now_s} s, but time must ascend; cut the record there"
            ));
        }
        let is_off = (now_s - last_s - self.step_s).abs() > STEP_TOLERANCE * self.step_s;
        is_off.then(|| {
            format!(
                "row {row}: `{column}` moves on by {} s, by {} s elsewhere; resample the record or cut it there",
                tidy(now_s - last_s),
                tidy(self.step_s)
            )
        })
    }

    fn fault(&self, column: &str, at: usize, last_s: f64, now_s: f64) -> ClockFault {
        let row = self.rows + at as u64 + 1;
        if let Some(sentence) = self.step_fault(column, row, last_s, now_s) {
            return ClockFault { sentence, is_drift: false };
        }
        let sentence = format!(
            "row {row}: `{column}` is {now_s} s where {} s is due after {} periods of {} s: its rate drifts; resample the record \
             to uniform times",
            tidy(self.first_s + (row - 1) as f64 * self.period_s),
            row - 1,
            tidy(self.period_s)
        );
        ClockFault { sentence, is_drift: true }
    }
}
