//! When symbols begin and end, and which of them were late.
//!
//! Symbol k begins at t₀ + k T_s by a clock that only goes forwards: what a symbol is late by, the
//! next one is shorter by, so that nothing adds up over hours. Behind by more than a symbol, the
//! clock begins anew.

use super::error::MeterError;
use crate::port::SymbolShape;
use std::time::{Duration, Instant};

/// Lateness that does not count, in per cent of the symbol time.
const TOLERANCE_PERCENT: f64 = 2.0;
/// Symbols before a share of late ones means something.
const ENOUGH_SYMBOLS: u64 = 20;

/// Symbols that were late.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LateSymbols {
    /// All symbols.
    pub symbols: u64,
    /// Symbols in which a part began or ended late by more than 2 % of the symbol time.
    pub late: u64,
    /// Lateness of the worst of all symbols, s.
    pub worst_s: f64,
}

#[derive(Default)]
pub(super) struct SymbolClock {
    /// When the next symbol begins; none while no run goes on.
    next: Option<Instant>,
    /// Lateness of the symbol that goes on.
    lateness: Duration,
    pub(super) counted: LateSymbols,
}

impl SymbolClock {
    pub(super) fn is_running(&self) -> bool {
        self.next.is_some()
    }

    /// The next symbol begins a run.
    pub(super) fn stop(&mut self) {
        self.next = None;
    }

    /// Begins a symbol: when it should have begun.
    pub(super) fn begin(&mut self, now: Instant, symbol_time: Duration) -> Instant {
        let due = self.next.unwrap_or(now);
        self.lateness = now.saturating_duration_since(due);
        let begins = if self.lateness > symbol_time { now } else { due };
        self.next = Some(begins + symbol_time);
        begins
    }

    /// Notes when something came that was due.
    pub(super) fn note(&mut self, now: Instant, due: Instant) {
        self.lateness = self.lateness.max(now.saturating_duration_since(due));
    }

    /// Counts the symbol.
    ///
    /// # Errors
    /// If more than `most_late`, a share, of the symbols were late. `work` is what bias and reading
    /// of a part take.
    pub(super) fn end(&mut self, shape: &SymbolShape, work: Duration, most_late: f64) -> Result<(), MeterError> {
        let lateness_s = self.lateness.as_secs_f64();
        let counted = &mut self.counted;
        counted.symbols += 1;
        counted.late += u64::from(100.0 * lateness_s > TOLERANCE_PERCENT * shape.symbol_time_s);
        counted.worst_s = counted.worst_s.max(lateness_s);
        let LateSymbols { symbols, late, worst_s } = *counted;
        if symbols < ENOUGH_SYMBOLS || late as f64 <= most_late * symbols as f64 {
            return Ok(());
        }
        // Twice the work in the shorter part. Where the work is not the reason, the caller is.
        let shorter = shape.second_share.min(1.0 - shape.second_share);
        let enough_s = (2.0 * work.as_secs_f64() / shorter).max(shape.symbol_time_s + 2.0 * worst_s);
        Err(MeterError::Other(format!(
            "{late} of {symbols} symbols were late by more than {TOLERANCE_PERCENT} % of a symbol time, the worst by {worst_s:.3} s; a symbol time of {enough_s:.2} s would do"
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPE: SymbolShape =
        SymbolShape { positive_v: 1.0, negative_v: -1.0, second_share: 0.25, symbol_time_s: 0.1 };
    const TIME: Duration = Duration::from_millis(100);
    const WORK: Duration = Duration::from_millis(5);

    #[test]
    fn symbols_keep_to_the_grid_of_the_first() {
        let (mut clock, start) = (SymbolClock::default(), Instant::now());
        for k in 0..1000 {
            // Each call comes up to 50 ms late.
            let now = start + TIME * k + if k == 0 { Duration::ZERO } else { Duration::from_millis(u64::from(k % 50)) };
            assert_eq!(clock.begin(now, TIME), start + TIME * k);
        }
        // Behind by more than a symbol: no hurry to catch up.
        let now = start + TIME * 1200;
        assert_eq!(clock.begin(now, TIME), now);
        assert_eq!(clock.begin(now + TIME, TIME), now + TIME);
    }

    #[test]
    fn late_symbols_are_counted_and_too_many_are_an_error() {
        let (mut clock, start) = (SymbolClock::default(), Instant::now());
        for k in 0..20 {
            let begins = clock.begin(start + TIME * k, TIME);
            let late = Duration::from_millis(if k >= 17 { 30 } else { 1 });
            clock.note(begins + TIME + late, begins + TIME);
            let sentence = clock.end(&SHAPE, WORK, 0.1).err().map(|error| error.to_string());
            // 3 of 20 are beyond a tenth. Twice 5 ms in a quarter are 0.04 s; the lateness wants
            // more: 0.1 s and twice 0.03 s.
            let expected = "3 of 20 symbols were late by more than 2 % of a symbol time, the worst by 0.030 s; a symbol time of 0.16 s would do";
            assert_eq!(sentence.as_deref(), (k == 19).then_some(expected));
        }
        assert_eq!((clock.counted.symbols, clock.counted.late), (20, 3));
        assert!(clock.end(&SHAPE, WORK, 1.0).is_ok(), "all may be late");
    }
}
