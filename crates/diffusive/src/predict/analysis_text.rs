//! The analysis of a loop as a summary for people.

use std::fmt::Write as _;

use dr_core::model::Reachability;

use super::analysis::{Analysis, LoopAtSetPoint, SETTLED};
use super::analysis_report::AnalysisReport;
use recording::text::four_digits as brief;

impl std::fmt::Display for AnalysisReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&summary(self))
    }
}

/// For people. Writing to a string cannot fail.
fn summary(found: &AnalysisReport) -> String {
    let analysis = &found.analysis;
    let mut text = format!("{}, class {}\n", found.pair, analysis.label);
    for note in &found.notes {
        let _ = writeln!(text, "  {note}");
    }
    let _ = writeln!(
        text,
        "\nsteady gain {} K/W, high-frequency gain {} K/J, {} °C without heating",
        brief(analysis.steady_gain_k_per_w),
        brief(analysis.gamma_k_per_j),
        brief(analysis.unheated_c)
    );
    if let Some(held) = &analysis.held {
        set_point(&mut text, held);
    }
    for other in found.others.iter().filter(|other| other.held.is_some()) {
        let _ = writeln!(text, "  in class {}: {}", other.label, other.held.as_ref().map_or(String::new(), verdict));
    }
    poles_and_zeros(&mut text, analysis);
    for (to, change) in &found.changes {
        let limited = analysis.limited(change);
        let Some(off_s) = limited.off_s else {
            let _ = writeln!(text, "\n{} → {to}: OUT OF REACH between these levels", analysis.label);
            continue;
        };
        let _ = writeln!(
            text,
            "\n{} → {to}: {} W before, {} W at once, {} W in the end; within 2 % of the change {}\n  {:.1} % of the disturbance is mismatched",
            analysis.label,
            brief(change.before_w + analysis.lost_w()),
            brief(change.at_once_w + analysis.lost_w()),
            brief(change.finally_w + analysis.lost_w()),
            within(limited.settled_s),
            100.0 * change.mismatched_share()
        );
        if off_s > 0.0 {
            let free = within(change.settled_s(SETTLED));
            let free = if free == within(limited.settled_s) {
                String::new()
            } else {
                format!(", and would be settled {free} if it could")
            };
            let _ = writeln!(
                text,
                "  a level is in the way: the temperature is off its set-point for {} s{free}",
                brief(off_s)
            );
        }
    }
    let _ = writeln!(text, "\n{}", found.verdict);
    text
}

fn within(time_s: Option<f64>) -> String {
    match time_s {
        None => "never".to_owned(),
        Some(0.0) => "at once".to_owned(),
        Some(time_s) => format!("in {} s", brief(time_s)),
    }
}

fn set_point(text: &mut String, held: &LoopAtSetPoint) {
    let conditions = &held.conditions;
    let _ = writeln!(
        text,
        "set-point {} °C, {} K up, between {} and {} W every {} s: {}",
        brief(conditions.target_c),
        brief(held.rise_k),
        brief(conditions.power_low_w),
        brief(conditions.power_high_w),
        brief(conditions.sample_period_s),
        verdict(held)
    );
    if held.lost_w > 0.0 {
        let _ = writeln!(text, "  {} W of it by losses that grow with temperature", brief(held.lost_w));
    }
    if let (Some(time_s), Some(arrival_w)) = (held.reaching_time_s, held.arrival_w) {
        let _ = writeln!(
            text,
            "  reached from rest after {} s, then with {} W; the power is within 2 % of the steady one {}",
            brief(time_s),
            brief(arrival_w),
            within(held.settled_s)
        );
        let (low_w, high_w) = conditions.levels_w();
        if !(low_w..=high_w).contains(&arrival_w) {
            text.push_str(
                "  that is beyond a level: the temperature goes on past its set-point and comes back later\n",
            );
        }
    }
    if let Some(chatter) = held.chatter {
        let _ = writeln!(
            text,
            "  readings stay between about {} mK below and {} mK above it; their mean, and so the power, is off by {:.3} % of the rise",
            brief(1e3 * chatter.below_k),
            brief(1e3 * chatter.above_k),
            // Rounded here, so that there is no -0.000.
            (1e5 * chatter.mean_k() / held.rise_k).round() / 1e3 + 0.0
        );
    }
}

fn verdict(held: &LoopAtSetPoint) -> String {
    match held.verdict {
        Reachability::Reachable { steady_power_w } => format!(
            "held with {} W, {} W above the low level and {} W below the high one",
            brief(steady_power_w),
            brief(held.margins_w.0),
            brief(held.margins_w.1)
        ),
        Reachability::LowLevelTooWarm { least_rise_k } => {
            format!("OUT OF REACH: even the low level ends {} K up", brief(least_rise_k))
        }
        Reachability::HighLevelTooCold { most_rise_k } => {
            format!("OUT OF REACH: the high level ends {} K up, and must end above the set-point", brief(most_rise_k))
        }
    }
}

fn poles_and_zeros(text: &mut String, analysis: &Analysis) {
    let poles: Vec<String> = analysis.poles_rad_s.iter().map(|rate| brief(*rate)).collect();
    let _ = writeln!(text, "\npoles, rad/s: {}", poles.join(", "));
    if analysis.zeros.is_empty() {
        text.push_str("no zeros: the loop has no time constant of its own\n");
        return;
    }
    let _ = writeln!(text, "  {:>11} {:>11}   weight in the power, of its steady value", "zero rad/s", "1/zero s");
    for (rate, weight) in &analysis.zeros {
        let both = |number: nalgebra::Complex<f64>| match number.im {
            0.0 => brief(number.re),
            imaginary => {
                format!("{} {} {}i", brief(number.re), if imaginary < 0.0 { '−' } else { '+' }, brief(imaginary.abs()))
            }
        };
        let _ = writeln!(text, "  {:>11} {:>11}   {}", both(*rate), brief(1.0 / rate.re), both(*weight));
    }
}
