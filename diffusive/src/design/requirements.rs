//! What a loop shall do, and which requirement cannot be met.

/// What a loop shall do.
#[derive(Debug, Clone, PartialEq)]
pub struct Requirements {
    /// Lowest and highest set-point that would do, K above the first wind's temperature without
    /// heating.
    pub rise_k: (f64, f64),
    /// Low level that is given, W.
    pub power_low_w: Option<f64>,
    /// High level that is given, W.
    pub power_high_w: Option<f64>,
    /// How far the levels shall stay from u_Q, as a share of it: between 0 and 1.
    pub margin: f64,
    /// Swing of the temperature that is allowed, from peak to peak, K.
    pub ripple_k: f64,
    /// After a change of the wind the power shall be within 2 % of the change in this time, s.
    pub response_s: Option<f64>,
    /// From rest the set-point shall be reached in this time, s.
    pub reach_s: Option<f64>,
}

/// Which requirement cannot be met, in which wind, and what could be had.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the sentence of a variant names its fields")]
pub enum DesignError {
    /// Nothing to design for.
    #[error("there is no wind to design for: name one class at least")]
    NoWind,
    /// A set-point that is none.
    #[error("the set-point {} K must be one number above zero, or two that ascend", range(.0))]
    SetPoint((f64, f64)),
    /// A margin that is no share.
    #[error("the margin {0} must lie between 0 and 1: it is a share of the power")]
    Margin(f64),
    /// A requirement that is not above zero.
    #[error("the {name} {value} {unit} must be greater than zero")]
    Positive { name: &'static str, value: f64, unit: &'static str },
    /// A level below zero.
    #[error("the {name} level {power_w} W must not be negative")]
    NegativeLevel { name: &'static str, power_w: f64 },
    /// Levels in the wrong order.
    #[error("the low level is {low_w} W and the high level {high_w} W: the high one must be above")]
    Levels { low_w: f64, high_w: f64 },
    /// A class that no loop holds.
    #[error("class `{0}` has a zero in the right half plane: no loop can hold it for long")]
    RunsAway(String),
    /// Levels between which the set-point is not held: what is in the way, and what they could
    /// hold.
    #[error("{rise_k} K cannot be held: {}{could}", .objection.as_ref().map_or(String::new(), ToString::to_string))]
    NotHeld { rise_k: f64, objection: Option<LevelObjection>, could: HeldRange },
    /// A set-point that is too far away.
    #[error("{rise_k} K cannot be reached in {reach_s} s by any power")]
    NotReached { rise_k: f64, reach_s: f64 },
    /// A high level that is too low to be in time.
    #[error(
        "{rise_k} K is not reached in {reach_s} s: the high level of {given_w} W takes {takes_s:.3} s; it must be {needed_w:.5} W or more"
    )]
    Late { rise_k: f64, reach_s: f64, given_w: f64, takes_s: f64, needed_w: f64 },
    /// A set-point that one wind keeps out of reach.
    #[error("in `{0}` the set-point is never reached")]
    Never(String),
    /// A response that the structure is too slow for.
    #[error(
        "a response in {response_s} s cannot be had: from `{from}` to `{to}` the power takes {takes_s:.3} s to within 2 % of the change, whatever the levels and the sample period. {TAIL}"
    )]
    Tail { response_s: f64, from: String, to: String, takes_s: f64 },
    /// A response that a level is in the way of: with which levels it would take how long.
    #[error(
        "a response in {response_s} s cannot be had between {:.5} and {:.5} W: from `{from}` to `{to}` the power takes {takes_s:.3} s to within 2 % of the change. {}",
        levels_w.0,
        levels_w.1,
        .remedy.as_ref().map_or(TAIL.to_owned(), |(lacks, wide_s)| format!("With {lacks} it would be {wide_s:.3} s"))
    )]
    Response {
        response_s: f64,
        levels_w: (f64, f64),
        from: String,
        to: String,
        takes_s: f64,
        remedy: Option<(String, f64)>,
    },
    /// A response of fewer samples than are needed.
    #[error("the response is too short: ten samples of the shortest period, {shortest_s} s, take {} s", 10.0 * shortest_s)]
    Short { shortest_s: f64 },
    /// A swing that even the shortest period exceeds.
    #[error(
        "a swing of {ripple_k} K cannot be kept: levels {range_w:.5} W apart swing by {least_k:.4} K at {shortest_s} s, the shortest period. Allow that, or bring the levels nearer (a smaller margin, fewer winds, more time to reach the set-point)"
    )]
    Swing { ripple_k: f64, range_w: f64, least_k: f64, shortest_s: f64 },
}

const TAIL: &str = "That tail is the structure's; allow that long, or take it out by the observer (`observe`)";

fn range((least, most): &(f64, f64)) -> String {
    if least == most { least.to_string() } else { format!("{least}..{most}") }
}

/// Why given levels cannot hold a set-point.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the sentence of a variant names its fields")]
pub enum LevelObjection {
    /// It would have to be cooled.
    #[error("in `{0}` it is no warmer than without heating, and a heater cannot cool")]
    NoHeat(String),
    /// The low level is too warm.
    #[error(
        "in `{wind}` it takes {takes_w:.5} W, and the low level of {given_w} W leaves less than {percent} % of that: it must be {bound_w:.5} W or less"
    )]
    Low { wind: String, takes_w: f64, given_w: f64, percent: f64, bound_w: f64 },
    /// The high level is too cold.
    #[error(
        "in `{wind}` it takes {takes_w:.5} W, and the high level of {given_w} W leaves less than {percent} % beyond: it must be {bound_w:.5} W or more"
    )]
    High { wind: String, takes_w: f64, given_w: f64, percent: f64, bound_w: f64 },
}

/// Rises in K that given levels could hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldRange {
    /// The lowest.
    pub least_k: f64,
    /// The highest; infinite where no high level is given.
    pub most_k: f64,
}

impl std::fmt::Display for HeldRange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { least_k, most_k } = self;
        if least_k < most_k && *most_k < f64::INFINITY {
            write!(f, "; the given levels hold {least_k:.3} to {most_k:.3} K")
        } else if least_k < most_k {
            write!(f, "; the given low level holds {least_k:.3} K and more")
        } else {
            Ok(())
        }
    }
}
