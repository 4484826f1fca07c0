//! Response times of tasks with fixed priorities.
//!
//! ```text
//! R = C + B + Σ ⌈R/T_j⌉ · C_j    over all work j of equal or higher priority
//! ```
//!
//! | symbol | meaning |
//! |---|---|
//! | C | longest time of the work itself |
//! | B | longest lock of a lower priority that it waits for |
//! | T_j | shortest time from one beginning of j to the next |
//!
//! Source: Joseph and Pandya, "Finding response times in a real-time system", 1986, with the
//! blocking of the immediate ceiling protocol, which RTIC's locks are. The least solution is found
//! by repetition from C + B.

/// Work that interrupts other work, or goes before it. All times in one unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interference {
    /// C_j.
    pub takes: u64,
    /// T_j.
    pub period: u64,
}

/// Response time of work that takes `takes` and is blocked for `blocked` at most; none if it is
/// longer than `limit`.
pub fn response(takes: u64, blocked: u64, others: &[Interference], limit: u64) -> Option<u64> {
    let mut response = takes + blocked;
    while response <= limit {
        let demand: u64 = others.iter().map(|other| response.div_ceil(other.period) * other.takes).sum();
        let next = takes + blocked + demand;
        if next == response {
            return Some(response);
        }
        response = next;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn other(takes: u64, period: u64) -> Interference {
        Interference { takes, period }
    }

    #[test]
    fn the_example_of_the_textbooks_has_its_response_times() {
        // C = 3, 3, 5; T = 7, 12, 20 (Burns and Wellings).
        assert_eq!(response(3, 0, &[], 100), Some(3));
        assert_eq!(response(3, 0, &[other(3, 7)], 100), Some(6));
        assert_eq!(response(5, 0, &[other(3, 7), other(3, 12)], 100), Some(20));
    }

    #[test]
    fn a_lock_delays_and_more_work_than_time_has_no_response() {
        assert_eq!(response(3, 1, &[other(3, 7)], 100), Some(7));
        assert_eq!(response(3, 2, &[other(3, 7)], 100), Some(11));
        assert_eq!(response(1, 0, &[other(7, 7)], 1_000), None);
    }
}
