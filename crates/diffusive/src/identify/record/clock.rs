//! Which place on a uniform grid of times each row has.
//!
//! A written time may be off its place by half a period; a row that comes later than that stands
//! behind a gap. The place of the next row follows from a running mean of the rows before, so that
//! neither jitter nor a rounded period adds up. A gap of a hundred periods at most keeps the grid
//! if the row behind it is near a place of that; behind a longer one, and in a file that does not
//! go on where another ended, a new grid begins: a run.

/// Jitter up to this part of the period is left as it is.
pub(super) const NEGLIGIBLE: f64 = 0.1;
/// Rows over which the grid is averaged, and by which it is known well enough to judge a row.
const MEMORY: u64 = 64;
const SETTLED: u64 = 8;
/// Rows by which the place of the first is found, at most.
const PHASE_ROWS: usize = 1024;
/// A row is another's, or late by a whole period, beyond half of it and what the mean may be off.
pub(super) const LATE: f64 = 0.6;
/// Missing periods through which a grid is counted on.
const LONGEST_COUNTED: f64 = 100.0;

/// A row's place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct RowPlace {
    pub run: usize,
    /// Periods since the run's first row.
    pub n: u64,
    /// Periods that no row stands for, before it.
    pub lost: u64,
}

/// Why a row has no place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ClockFault {
    DoesNotAscend,
    TooEarly,
}

#[derive(Debug, Clone, Default)]
pub(super) struct Clock {
    step_s: f64,
    due_s: f64,
    last_s: Option<f64>,
    /// Runs so far, and rows of this one.
    runs: usize,
    seen: u64,
    n: u64,
    jitter: f64,
}

impl Clock {
    /// Begins a file whose first times are given, and which usual step they have. Whether it goes
    /// on where the one before ended, on the same grid: a logger that begins a new file every hour
    /// loses no row by it.
    pub(super) fn begin_file(&mut self, head: &[f64], step_s: f64) -> bool {
        let Some(&first_s) = head.iter().find(|time_s| time_s.is_finite()) else { return false };
        let apart_s = (step_s - self.step_s).abs() * head.len() as f64;
        if self.last_s.is_some() && (first_s - self.due_s).abs().max(apart_s) <= 0.5 * step_s {
            return true;
        }
        (self.step_s, self.last_s, self.seen) = (step_s, None, 0);
        self.runs += 1;
        // The first row may be off its place itself: the mean of where the others are on the
        // circle of a period.
        let turns =
            head.iter().take((head.len() / 4).clamp(SETTLED as usize, PHASE_ROWS)).filter(|time_s| time_s.is_finite());
        let turns = turns.map(|time_s| std::f64::consts::TAU * ((time_s - first_s) / step_s).fract());
        let (sin, cos) = turns.fold((0.0, 0.0), |(sin, cos), turn| (sin + libm::sin(turn), cos + libm::cos(turn)));
        self.due_s = first_s + libm::atan2(sin, cos) / std::f64::consts::TAU * step_s;
        false
    }

    /// The usual step, s.
    pub(super) const fn step_s(&self) -> f64 {
        self.step_s
    }

    /// Time of the row before, in its file.
    pub(super) const fn last_s(&self) -> Option<f64> {
        self.last_s
    }

    /// The largest distance of a row from its place so far, in periods; behind usual steps it does
    /// not count.
    pub(super) const fn jitter(&self) -> f64 {
        self.jitter
    }

    /// Gives the next row its place.
    pub(super) fn place(&mut self, now_s: f64) -> Result<RowPlace, ClockFault> {
        if self.last_s.is_some_and(|last_s| now_s <= last_s) {
            return Err(ClockFault::DoesNotAscend);
        }
        let step_s = now_s - self.last_s.replace(now_s).unwrap_or(f64::NEG_INFINITY);
        let is_first = step_s.is_infinite();
        let off = (now_s - self.due_s) / self.step_s;
        // Steps that are as usual drift at most, which the grid of the whole run shows.
        let is_usual = is_first || (step_s / self.step_s - 1.0).abs() <= NEGLIGIBLE;
        let lost = if is_usual || off.abs() <= LATE { 0.0 } else { off.signum() * (off.abs() - LATE + 0.5).round() };
        if lost < 0.0 && self.seen >= SETTLED {
            return Err(ClockFault::TooEarly);
        }
        let (lost, off) = (lost.max(0.0), off - lost);
        let counts_on = lost <= LONGEST_COUNTED && off.abs() <= NEGLIGIBLE.max(1.2 * self.jitter);
        if lost > 0.0 && !counts_on {
            (self.runs, self.seen, self.n, self.due_s) = (self.runs + 1, 1, 0, now_s + self.step_s);
            return Ok(RowPlace { run: self.runs - 1, n: 0, lost: lost as u64 });
        }
        if self.seen >= SETTLED && !is_usual {
            self.jitter = self.jitter.max(off.abs());
        }
        self.seen += 1;
        self.n = if is_first { 0 } else { self.n + 1 + lost as u64 };
        self.due_s += self.step_s * (1.0 + lost + off / self.seen.min(MEMORY) as f64);
        Ok(RowPlace { run: self.runs - 1, n: self.n, lost: lost as u64 })
    }
}

/// The rows of a run: where they stand and when, for a straight line through them.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct RunTimes {
    first_s: f64,
    first_n: u64,
    last_s: f64,
    last_n: u64,
    rows: f64,
    sum_n: f64,
    sum_s: f64,
    sum_nn: f64,
    sum_ns: f64,
}

impl RunTimes {
    pub(super) fn add(&mut self, n: u64, now_s: f64) {
        if self.rows == 0.0 {
            (self.first_s, self.first_n) = (now_s, n);
        }
        (self.last_s, self.last_n) = (now_s, n);
        let (n, since_s) = (n as f64, now_s - self.first_s);
        self.rows += 1.0;
        self.sum_n += n;
        self.sum_s += since_s;
        self.sum_nn += n * n;
        self.sum_ns += n * since_s;
    }

    /// The period of some runs: between their ends, or by least squares where the ends jitter.
    /// `None` if no run has two rows.
    pub(super) fn period_s(runs: &[Self], has_jitter: bool) -> Option<f64> {
        let parts = runs.iter().map(|run| match has_jitter {
            false => (run.last_s - run.first_s, (run.last_n - run.first_n) as f64),
            true => (run.sum_ns - run.sum_n * run.sum_s / run.rows, run.sum_nn - run.sum_n * run.sum_n / run.rows),
        });
        let (above, below) = parts.fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
        Some(above / below).filter(|period_s| period_s.is_finite() && *period_s > 0.0)
    }

    /// Time of the run's place 0.
    pub(super) fn begin_s(&self, period_s: f64, has_jitter: bool) -> f64 {
        let mean_s = self.first_s + (self.sum_s - period_s * self.sum_n) / self.rows;
        if has_jitter { mean_s } else { self.first_s - self.first_n as f64 * period_s }
    }
}

/// The usual step between the first times of a file; `None` if there are not two of them, or if
/// most do not ascend.
pub(super) fn usual_step_s(head: &[f64]) -> Option<f64> {
    let times: Vec<f64> = head.iter().copied().filter(|time_s| time_s.is_finite()).collect();
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.is_empty() {
        return None;
    }
    let middle = steps.len() / 2;
    let median_s = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    if median_s <= 0.0 {
        return None;
    }
    // Neither is the median of steps that jitter or are rounded quite the period, nor the mean of
    // all where there are gaps.
    steps.retain(|step_s| *step_s < 1.9 * median_s);
    let mean_s = steps.iter().sum::<f64>() / steps.len() as f64;
    let (mut clock, mut runs) = (Clock::default(), Vec::new());
    clock.begin_file(&times, mean_s);
    for &now_s in &times {
        let Ok(RowPlace { run, n, .. }) = clock.place(now_s) else { break };
        runs.resize(run + 1, RunTimes::default());
        runs[run].add(n, now_s);
    }
    RunTimes::period_s(&runs, true)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The places of some times, and the clock behind them.
    fn places(times: &[f64]) -> (Vec<RowPlace>, Clock) {
        let mut clock = Clock::default();
        clock.begin_file(times, usual_step_s(times).unwrap());
        (times.iter().map(|&now_s| clock.place(now_s).unwrap()).collect(), clock)
    }

    #[test]
    fn jitter_of_nearly_half_a_period_costs_no_row() {
        // A known sequence with values from −0.45 to 0.45.
        let jitter = |n: usize| ((n * 37) % 91) as f64 / 100.0 - 0.45;
        let times: Vec<f64> = (0..5000).map(|n| 3.0 + 0.02 * (n as f64 + jitter(n))).collect();
        assert!((usual_step_s(&times).unwrap() / 0.02 - 1.0).abs() < 1e-5);
        let (places, clock) = places(&times);
        assert!(places.iter().enumerate().all(|(row, place)| *place == RowPlace { run: 0, n: row as u64, lost: 0 }));
        assert!(clock.jitter() > 0.4 && clock.jitter() < 0.6, "{}", clock.jitter());
    }

    #[test]
    fn rounded_times_are_no_jitter_and_do_not_add_up() {
        // 60 Hz in whole milliseconds: the median step is 17 ms, the period 16.67 ms.
        let times: Vec<f64> = (0..100_000).map(|n| (n as f64 / 0.06).round() / 1000.0).collect();
        let (places, clock) = places(&times);
        assert_eq!(places[99_999], RowPlace { run: 0, n: 99_999, lost: 0 });
        assert!(clock.jitter() < NEGLIGIBLE, "{}", clock.jitter());
    }

    #[test]
    fn missing_rows_leave_the_grid_and_long_or_crooked_gaps_begin_another() {
        let gap = |periods: f64| {
            let times: Vec<f64> = (0..100).map(|n| f64::from(n) + if n < 50 { 0.0 } else { periods }).collect();
            places(&times).0[50]
        };
        assert_eq!(gap(1.0), RowPlace { run: 0, n: 51, lost: 1 });
        assert_eq!(gap(30.0), RowPlace { run: 0, n: 80, lost: 30 });
        assert_eq!(gap(2.4), RowPlace { run: 1, n: 0, lost: 2 });
        assert_eq!(gap(5000.0), RowPlace { run: 1, n: 0, lost: 5000 });
    }

    #[test]
    fn times_that_fall_back_or_hurry_have_no_place() {
        let mut clock = Clock::default();
        clock.begin_file(&[0.0, 1.0, 2.0], 1.0);
        assert!((0..20).all(|n| clock.place(f64::from(n)).is_ok()));
        assert_eq!(clock.clone().place(19.0), Err(ClockFault::DoesNotAscend));
        assert_eq!(clock.place(19.2), Err(ClockFault::TooEarly));
        assert_eq!(usual_step_s(&[1.0]), None);
        assert_eq!(usual_step_s(&[3.0, 2.0, 1.0]), None);
    }
}
