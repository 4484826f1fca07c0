//! Assignment of data-ready edges to conversions by a clock of the processor.
//!
//! A tick is a number of conversions ([`TickPlan`](super::tick_plan::TickPlan)), and an edge that
//! nobody saw would make it longer without a trace. So each conversion has a time at which it is
//! due, one period after the one before:
//!
//! ```text
//! d_(k+1) = d_k + P + min((t_k − d_k)/8, P/64)    if t_k ≥ d_k
//! d_(k+1) = t_k + P                               if t_k < d_k
//! conversion k is lost if it has not been seen by d_k + P, or if it is seen after d_k + P − F
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | P | conversion period of the ADC, nominal | counts |
//! | d_k | when conversion k is due | counts |
//! | t_k | when its edge was served | counts |
//! | F | what reading its frame takes | counts |
//!
//! An edge is never served before it has come, so an early one is taken for the truth at once,
//! while a late one may only have waited and moves the due time by an eighth of its lateness, P/64
//! at the most. The ADC's clock and the processor's may thus differ by 1.5 % without anything being
//! taken for lost; the tick keeps following the ADC's. N conversions in a row that are served late
//! move the due time by N P/64, and the next one in time puts it right.
//!
//! Lost conversions still count in their tick, as
//! [`SettledMean::conversion`](super::settled_mean::SettledMean::conversion) of `None`. That covers
//! both ways of losing them: an edge that was overwritten by the next because it was not served in
//! time, and an ADC that has fallen silent, for which time then goes on in ticks whose readings are
//! missing.
//!
//! A frame that is read across the update by the next conversion is half of each, and its mark does
//! not show it: what is served too late for its frame is not read.
//!
//! Limits: the clock must be polled at least once in half of the time in which it wraps, and d_k is
//! wrong by some lateness of before, which F must allow for. An edge that is not one of the ADC's
//! (a disturbance on the line) counts as a conversion.

/// Half periods from a start to the first conversion: the ADC's filter has to fill.
const FIRST: u32 = 9;

/// The largest part of a period by which a late service moves the due time.
const LARGEST_CORRECTION: i32 = 64;

/// The expected course of data-ready edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DataReady {
    period: u32,
    frame: u32,
    due: u32,
}

/// What to do about a conversion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Due {
    /// Nothing: the next one is not due, or not overdue.
    Wait,
    /// Count it as lost, and ask again.
    Lost,
    /// Its edge has come: read it.
    Read,
    /// Its edge has come, and the next one would come before its frame is out: count it as lost.
    Late,
}

impl DataReady {
    /// Conversions of `period` counts from an ADC that was started at `now`, whose frames take
    /// `frame` counts.
    pub const fn new(period: u32, frame: u32, now: u32) -> Self {
        Self { period, frame, due: now.wrapping_add(FIRST * period / 2) }
    }

    /// Whether `counts` are left at `now` before the next conversion.
    pub const fn leaves(&self, now: u32, counts: u32) -> bool {
        self.due.wrapping_sub(now).cast_signed() >= counts.cast_signed()
    }

    /// How long ago at `now` the conversion that is due had its edge.
    pub fn lateness(&self, now: u32) -> u32 {
        now.wrapping_sub(self.due).cast_signed().max(0).cast_unsigned()
    }

    /// What is due at `now`, if an edge waits to be served or not.
    pub fn next(&mut self, now: u32, edge: bool) -> Due {
        let late = now.wrapping_sub(self.due).cast_signed();
        if late >= self.period.cast_signed() {
            self.due = self.due.wrapping_add(self.period);
            return Due::Lost;
        }
        if !edge {
            return Due::Wait;
        }
        let largest = self.period.cast_signed() / LARGEST_CORRECTION;
        let correction = if late < 0 { late } else { largest.min(late / 8) };
        self.due = self.due.wrapping_add_signed(correction).wrapping_add(self.period);
        if late > self.period.wrapping_sub(self.frame).cast_signed() { Due::Late } else { Due::Read }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 4 kSPS at 168 MHz.
    const PERIOD: u32 = 42_000;
    /// A fifth of it.
    const FRAME: u32 = 8_400;

    /// Serves the edges at these times (in periods) and gives the number of conversions read and
    /// lost.
    fn served(data_ready: &mut DataReady, times: impl IntoIterator<Item = f64>, start: u32) -> (u32, u32) {
        let (mut read, mut lost) = (0, 0);
        for time in times {
            let now = start.wrapping_add((time * f64::from(PERIOD)) as u32);
            loop {
                match data_ready.next(now, true) {
                    Due::Lost => lost += 1,
                    Due::Read => break read += 1,
                    Due::Late => break lost += 1,
                    Due::Wait => panic!("an edge that waits must be served"),
                }
            }
        }
        (read, lost)
    }

    #[test]
    fn edges_in_time_are_all_read_also_over_a_wrap_of_the_counter() {
        let start = u32::MAX - 20 * PERIOD;
        let mut data_ready = DataReady::new(PERIOD, FRAME, start);
        assert_eq!(served(&mut data_ready, (0..100).map(|k| 4.5 + f64::from(k)), start), (100, 0));
    }

    #[test]
    fn clocks_may_differ_by_a_percent_and_a_half() {
        // The steady lateness is 8 times the difference of the periods: 0.12 of one, and less than
        // one is not lost. A fast ADC is followed at once.
        for ratio in [0.95, 0.985, 0.999_9, 1.000_1, 1.015] {
            let mut data_ready = DataReady::new(PERIOD, FRAME, 0);
            assert_eq!(served(&mut data_ready, (0..5_000).map(|k| 4.5 + f64::from(k) * ratio), 0), (5_000, 0));
        }
    }

    #[test]
    fn a_late_service_loses_nothing_if_the_next_edge_has_not_come() {
        let mut data_ready = DataReady::new(PERIOD, FRAME, 0);
        let times = (0..300).map(|k| 4.5 + f64::from(k) + if k % 3 == 1 { 0.7 } else { 0.0 });
        assert_eq!(served(&mut data_ready, times, 0), (300, 0));
    }

    /// Frames take a twelfth of a period really, and the rest of the margin is for errors of the due
    /// time: none may be read that the next conversion cuts.
    #[test]
    fn services_that_are_late_in_a_row_spoil_no_frame() {
        let (margin, frame) = (PERIOD * 60 / 250, PERIOD * 20 / 250);
        for in_a_row in 1..=10 {
            let mut data_ready = DataReady::new(PERIOD, margin, 0);
            for k in 0..1_000 {
                let edge = 9 * PERIOD / 2 + k * PERIOD;
                let is_late = k % 20 < in_a_row;
                // 0.74 of a period is in time for a frame, the last ones are not.
                let lateness = if !is_late {
                    0
                } else if k % 20 + 1 < in_a_row {
                    PERIOD * 74 / 100
                } else {
                    PERIOD * 93 / 100
                };
                let due = data_ready.next(edge + lateness, true);
                let fits = lateness + frame <= PERIOD;
                assert!(due != Due::Read || fits, "{in_a_row} in a row, conversion {k}");
                assert!(due == Due::Read || lateness > 0, "{in_a_row} in a row, conversion {k}: {due:?}");
            }
        }
    }

    #[test]
    fn an_edge_that_is_served_too_late_for_its_frame_is_lost_alone() {
        let mut data_ready = DataReady::new(PERIOD, FRAME, 0);
        let times = (0..300).map(|k| 4.5 + f64::from(k) + if k % 10 == 5 { 0.81 } else { 0.0 });
        assert_eq!(served(&mut data_ready, times, 0), (270, 30));
        // The last one was served at 303.5.
        let at = |periods: f64| (periods * f64::from(PERIOD)) as u32;
        assert!(data_ready.leaves(at(304.0), PERIOD / 2) && !data_ready.leaves(at(304.01), PERIOD / 2));
        assert!(!data_ready.leaves(at(304.6), 1));
    }

    #[test]
    fn an_edge_that_was_overwritten_is_counted_once() {
        // Every tenth edge is served so late that the next has come as well: one service for two
        // conversions.
        let mut data_ready = DataReady::new(PERIOD, FRAME, 0);
        let times = (0..300).filter(|k| k % 10 != 5).map(|k| 4.5 + f64::from(k) + if k % 10 == 6 { 0.3 } else { 0.0 });
        assert_eq!(served(&mut data_ready, times, 0), (270, 30));
    }

    #[test]
    fn a_silent_adc_loses_its_conversions_at_their_rate() {
        let mut data_ready = DataReady::new(PERIOD, FRAME, 0);
        served(&mut data_ready, (0..10).map(|k| 4.5 + f64::from(k)), 0);
        // The last edge came at 13.5 periods. Asked as the health task does, every 200 periods (50
        // ms).
        let mut lost = 0;
        for beat in 1..=20 {
            let now = 200 * beat * PERIOD;
            while data_ready.next(now, false) == Due::Lost {
                lost += 1;
            }
            // Those due at 14.5, 15.5, … are lost when they are a whole period overdue.
            assert_eq!(lost, 200 * beat - 15);
        }
    }

    #[test]
    fn a_first_conversion_that_is_served_too_late_is_not_read() {
        let mut data_ready = DataReady::new(PERIOD, FRAME, 0);
        assert_eq!(data_ready.next(PERIOD / 10 * 53 + 1, true), Due::Late);
    }

    #[test]
    fn an_adc_that_never_starts_is_silent_from_its_first_conversion_on() {
        let mut data_ready = DataReady::new(PERIOD, FRAME, 0);
        let overdue = 11 * PERIOD / 2;
        assert_eq!(data_ready.next(overdue - 1, false), Due::Wait);
        assert_eq!(data_ready.next(overdue, false), Due::Lost);
        assert_eq!(data_ready.next(overdue, false), Due::Wait);
    }

    #[test]
    fn an_adc_that_comes_back_is_read_again() {
        let mut data_ready = DataReady::new(PERIOD, FRAME, 0);
        served(&mut data_ready, [4.5, 5.5], 0);
        // Silence until 100.2: those due at 6.5 … 98.5 have been overdue for a period or more, 99.5
        // is read late.
        assert_eq!(served(&mut data_ready, (0..50).map(|k| 100.2 + f64::from(k)), 0), (50, 93));
    }

    #[test]
    fn asking_between_edges_changes_nothing() {
        let mut data_ready = DataReady::new(PERIOD, FRAME, 0);
        served(&mut data_ready, [4.5], 0);
        let before = data_ready;
        assert_eq!(data_ready.next(5 * PERIOD, false), Due::Wait);
        assert_eq!(data_ready, before);
    }

    #[test]
    fn a_silent_adc_is_missing_within_two_ticks_and_the_health_task_s_beat() {
        use crate::drivers::settled_mean::SettledMean;
        use crate::drivers::tick_plan::TickPlan;
        use dr_core::sensor::Reading;

        // 10 ms ticks of 40 conversions; the ADC stops k conversions into its third tick.
        for k in 0..40 {
            let mut data_ready = DataReady::new(PERIOD, FRAME, 0);
            let mut mean = SettledMean::<1>::new(TickPlan::new(10_000).unwrap());
            served(&mut data_ready, (0..80 + k).map(|n| 4.5 + f64::from(n)), 0);
            let mut ticks: Vec<_> = (0..80 + k).filter_map(|_| mean.conversion(Some(&[7]))).collect();
            // Two ticks and a timeout of one period after the last edge, at 83.5 + k. The beat that
            // finds it comes within 50 ms.
            let now = ((83.5 + f64::from(k) + 81.0) * f64::from(PERIOD)) as u32;
            while data_ready.next(now, false) == Due::Lost {
                ticks.extend(mean.conversion(None));
            }
            assert!(ticks[2..].contains(&[Reading::Missing]), "{k}: {ticks:?}");
        }
    }
}
