//! Why slow errors cannot be found, and what would let them be.

use super::halves::LEAST_SWING;

/// Why slow errors cannot be found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SlowErrorsUnknown {
    /// The head has as many surfaces as unknowns, or more than one to spare, or is a card.
    #[error(
        "slow errors are found by the number that four surfaces round a body have to spare: this head has another form"
    )]
    NothingToSpare,
    /// Too few winds say anything.
    #[error(
        "slow errors take {least} winds that differ by 17° or 30 % of speed, and the recording has fewer: record more of them"
    )]
    FewWinds {
        /// So many it takes.
        least: usize,
    },
    /// The overheat changes, but not in halves that count.
    #[error(
        "the overheat changes, but fewer than six halves of it count, and there are too few winds without them: let it alternate between overheats at least {:.0} % apart, for longer at each than the head takes to cool (its estimates are `saturated` meanwhile), and for a multiple of that",
        100.0 * LEAST_SWING
    )]
    NoHalves,
    /// The winds do not say which surface is wrong.
    #[error(
        "the winds of the recording do not say which surface is wrong, so nothing can be corrected: record winds of more directions and speeds, or seek offsets or gains alone in place of both"
    )]
    WindsAlike,
    /// No estimate has a wind with a direction.
    #[error(
        "slow errors show in winds that have a direction, and the recording has none: record winds of many directions"
    )]
    NoWind,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sentence_on_halves_states_the_swing_that_counts() {
        let sentence = SlowErrorsUnknown::NoHalves.to_string();
        assert!(sentence.contains(&format!("at least {:.0} % apart", 100.0 * LEAST_SWING)), "{sentence}");
    }
}
