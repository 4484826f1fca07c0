//! How a check of a wind refuses: the first number that is out of its range.

/// No gust, sine or dust devil may add more than this, m/s.
pub(super) const HIGHEST_M_S: f64 = 100.0;

/// What a check refuses: the key in its entry, its value, what would be right.
pub(super) type Refused = (&'static str, f64, &'static str);

/// Refuses the first that is not so.
pub(super) fn first_refused(cases: impl IntoIterator<Item = (bool, Refused)>) -> Result<(), Refused> {
    cases.into_iter().find(|(right, _)| !right).map_or(Ok(()), |(_, refused)| Err(refused))
}
