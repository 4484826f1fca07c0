//! Which estimates count in a statistic.
//!
//! A flag disqualifies where the vector may be another than the wind's. Estimates beyond the
//! calibration count: left out, they would take just the strongest gusts, or the calms, from the
//! statistics.

use dr_core::wind::QualityFlags;

/// With one of these an estimate counts in nothing.
const DISQUALIFYING: [QualityFlags; 7] = [
    QualityFlags::FAILED,
    QualityFlags::AMBIGUOUS,
    QualityFlags::UNCALIBRATED,
    QualityFlags::NO_GAS,
    QualityFlags::NOT_RUNNING,
    QualityFlags::STARTING,
    QualityFlags::INCONSISTENT,
];

/// Whether the speed of an estimate counts.
pub fn speed_counts(flags: QualityFlags) -> bool {
    !DISQUALIFYING.iter().any(|flag| flags.has(*flag))
}

/// Of estimates, the name of the flag for which most of them do not count; none if all do.
pub fn most_left_out(flags: impl Iterator<Item = QualityFlags>) -> Option<&'static str> {
    let mut counts = [0_u64; DISQUALIFYING.len()];
    for of in flags {
        counts.iter_mut().zip(DISQUALIFYING).for_each(|(count, flag)| *count += u64::from(of.has(flag)));
    }
    let (flag, _) = DISQUALIFYING.into_iter().zip(counts).filter(|(_, count)| *count > 0).max_by_key(|of| of.1)?;
    QualityFlags::NAMES.iter().find(|(named, _)| *named == flag).map(|(_, name)| *name)
}

/// Whether its vector counts, too: a head of one axis does not determine it.
pub fn vector_counts(flags: QualityFlags) -> bool {
    speed_counts(flags) && !flags.has(QualityFlags::UNDETERMINED)
}

/// Whether its direction counts by itself.
pub fn direction_counts(flags: QualityFlags) -> bool {
    vector_counts(flags) && !flags.has(QualityFlags::NO_DIRECTION)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_depends_on_the_statistic() {
        let counts = |flags| [speed_counts(flags), vector_counts(flags), direction_counts(flags)];
        assert_eq!(counts(QualityFlags::EXTRAPOLATED), [true; 3]);
        assert_eq!(counts(QualityFlags::NO_DIRECTION), [true, true, false]);
        assert_eq!(counts(QualityFlags::UNDETERMINED), [true, false, false]);
        assert_eq!(counts(QualityFlags::COLD.with(QualityFlags::STARTING, true)), [false; 3]);
    }

    #[test]
    fn the_flag_of_most_estimates_that_do_not_count_is_named() {
        let (starting, both) = (QualityFlags::STARTING, QualityFlags::STARTING.with(QualityFlags::FAILED, true));
        assert_eq!(most_left_out([starting, both, QualityFlags::COLD].into_iter()), Some("starting"));
        assert_eq!(most_left_out([QualityFlags::COLD].into_iter()), None);
    }
}
