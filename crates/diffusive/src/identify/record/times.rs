//! Units of the times that loggers write.
//!
//! | where | is read as |
//! |---|---|
//! | moments in ISO 8601 | s since 1970 |
//! | `time_ms`, `t [min]`, or a line of units below the names | that unit |
//! | numbers above 1e8, 1e11, 1e14 or 1e17 | s, ms, µs or ns since 1970 |
//! | anything else | s |

/// A unit of time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TimeUnit {
    /// Seconds.
    #[default]
    Second,
    /// Milliseconds.
    Millisecond,
    /// Microseconds.
    Microsecond,
    /// Nanoseconds.
    Nanosecond,
    /// Minutes.
    Minute,
    /// Hours.
    Hour,
    /// Days.
    Day,
}

/// Times beyond this are counted from 1970, s: three years are more than any record has.
pub(super) const SINCE_1970_S: f64 = 1e8;

/// What units are called.
const NAMES: [(&str, TimeUnit); 20] = [
    ("s", TimeUnit::Second),
    ("sec", TimeUnit::Second),
    ("seconds", TimeUnit::Second),
    ("ms", TimeUnit::Millisecond),
    ("msec", TimeUnit::Millisecond),
    ("millis", TimeUnit::Millisecond),
    ("milliseconds", TimeUnit::Millisecond),
    ("us", TimeUnit::Microsecond),
    ("µs", TimeUnit::Microsecond),
    ("micros", TimeUnit::Microsecond),
    ("microseconds", TimeUnit::Microsecond),
    ("ns", TimeUnit::Nanosecond),
    ("nanoseconds", TimeUnit::Nanosecond),
    ("min", TimeUnit::Minute),
    ("minutes", TimeUnit::Minute),
    ("h", TimeUnit::Hour),
    ("hr", TimeUnit::Hour),
    ("hours", TimeUnit::Hour),
    ("d", TimeUnit::Day),
    ("days", TimeUnit::Day),
];

impl TimeUnit {
    /// The unit of that name, which may stand in brackets.
    pub(super) fn of_name(name: &str) -> Option<Self> {
        let name = name.trim_matches(|letter: char| "()[] ".contains(letter)).to_lowercase();
        NAMES.iter().find(|(known, _)| *known == name).map(|(_, unit)| *unit)
    }

    /// The unit that the name of a column of times states: `time_ms`, `t [min]`.
    pub(super) fn of_column(name: &str) -> Option<Self> {
        let bracketed = recording::stated_unit(name).and_then(Self::of_name);
        bracketed.or_else(|| Self::of_name(name.rsplit_once(['_', '/', ' '])?.1))
    }

    /// The unit in which a time of today would be so large.
    pub(super) fn of_size(time: f64) -> Option<Self> {
        let units = [Self::Second, Self::Millisecond, Self::Microsecond, Self::Nanosecond];
        let at_least = |unit: &Self| unit.seconds(time) >= SINCE_1970_S;
        units.into_iter().rfind(at_least)
    }

    /// So many of the unit in s.
    pub(super) fn seconds(self, time: f64) -> f64 {
        // Divided, so that 800 ms are the number nearest to 0.8.
        match self {
            Self::Second => time,
            Self::Millisecond => time / 1e3,
            Self::Microsecond => time / 1e6,
            Self::Nanosecond => time / 1e9,
            Self::Minute => time * 60.0,
            Self::Hour => time * 3600.0,
            Self::Day => time * 86_400.0,
        }
    }

    /// Its short name.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Second => "s",
            Self::Millisecond => "ms",
            Self::Microsecond => "µs",
            Self::Nanosecond => "ns",
            Self::Minute => "min",
            Self::Hour => "h",
            Self::Day => "d",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_is_told_by_the_columns_name_or_by_the_size_of_its_numbers() {
        for (name, unit) in [
            ("time_ms", Some(TimeUnit::Millisecond)),
            ("elapsed_us", Some(TimeUnit::Microsecond)),
            ("t [min]", Some(TimeUnit::Minute)),
            ("Time (hours)", Some(TimeUnit::Hour)),
            ("time/s", Some(TimeUnit::Second)),
            ("Zeit ms", Some(TimeUnit::Millisecond)),
            ("t", None),
            ("s", None),
            ("time_of_day", None),
        ] {
            assert_eq!(TimeUnit::of_column(name), unit, "{name}");
        }
        let of_size = [(9e7, None), (1.7e9, Some(TimeUnit::Second)), (1.7e12, Some(TimeUnit::Millisecond))];
        for (time, unit) in
            of_size.into_iter().chain([(1.7e15, Some(TimeUnit::Microsecond)), (1.7e18, Some(TimeUnit::Nanosecond))])
        {
            assert_eq!(TimeUnit::of_size(time), unit, "{time}");
        }
        assert_eq!(TimeUnit::Millisecond.seconds(800.0), 0.8);
    }
}
