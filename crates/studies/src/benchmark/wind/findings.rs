//! The bars of the wind benchmark, and what was measured.

use super::measure::MeasuredSphere;
use super::turbulence::TurbulenceResponse;
use crate::thesis::StudyFindings;
use anemometry::wind::comparison::WindComparison;

/// Bars of the whole head: direction in °, then shares.
const DIRECTION_DEG: f64 = 1.5;
const SPEED: f64 = 0.015;
const DRIFT: f64 = 0.005;
const SWING: f64 = 0.03;
const COHERENCE: f64 = 0.9;
const GAIN: f64 = 0.05;
/// Up to this frequency, Hz.
const FOLLOWED_HZ: f64 = 2.0;

/// The bars of one sphere.
pub fn findings(of: &MeasuredSphere) -> StudyFindings {
    let mut found = StudyFindings::default();
    directions(of, &mut found);
    steps(of, &mut found);
    turbulence(of, &mut found);
    let swing = &of.swing;
    let ours = format!("{} at worst, {} rms", percent(swing.speed_worst, 2), percent(swing.speed_rms, 2));
    found
        .compared(
            format!("speed, gas temperature oscillating by {} K, means of 10 s", swing.kelvin),
            format!("raw conductance {}", percent(swing.raw_span, 1)),
            ours,
        )
        .judged(format!("at most {}", percent(SWING, 0)), swing.speed_worst <= SWING);
    found
}

/// Errors in unseen winds, at the bandwidth with the least.
fn directions(of: &MeasuredSphere, found: &mut StudyFindings) {
    let rms = |errors: &WindComparison| errors.speed.rms().unwrap_or(f64::NAN);
    let Some(best) = of.directions.iter().min_by(|a, b| rms(&a.errors).total_cmp(&rms(&b.errors))) else { return };
    let direction_deg = best.errors.direction_deg.rms();
    let at = format!("{} unseen winds, {}", best.winds, best.mode);
    if let Some(direction_deg) = direction_deg.filter(|_| of.sphere.whole) {
        let linear = best.errors.linear_deg.rms().map_or(String::new(), |deg| format!("linear inverse {deg:.2}°"));
        found
            .compared(format!("direction, {at}"), linear, format!("{direction_deg:.2}° rms"))
            .judged(format!("at most {DIRECTION_DEG}° rms"), direction_deg <= DIRECTION_DEG);
    }
    let speed = rms(&best.errors);
    let ours =
        format!("{} rms, {} at worst", percent(speed, 2), percent(best.errors.speed.worst().unwrap_or(f64::NAN), 2));
    found.reported(format!("speed, {at}"), ours).judged(format!("at most {} rms", percent(SPEED, 1)), speed <= SPEED);
}

fn steps(of: &MeasuredSphere, found: &mut StudyFindings) {
    let judged = of.steps.iter().find(|steps| steps.mode == of.sphere.judged);
    let raw_s = of.drift.raw_response_s;
    for (place, words) in ["2 to 6 m/s", "6 to 2 m/s"].into_iter().enumerate() {
        let Some(way) = judged.map(|steps| &steps.ways[place]) else { continue };
        let what = format!("time to 5 %, {words}, {}", of.sphere.judged);
        let met = way.mean_response_s <= of.sphere.response_s;
        found
            .compared(what, format!("raw {:.2} s", raw_s[place]), format!("{:.2} s", way.mean_response_s))
            .judged(format!("at most {} s", of.sphere.response_s), met);
        let (drift, raw) = (of.drift.answer[place], of.drift.raw[place]);
        found
            .compared(
                format!("drift in 10 min after {words}, {}", of.drift.mode),
                format!("raw {}", signed(raw)),
                signed(drift),
            )
            .judged(format!("at most {}", percent(DRIFT, 1)), drift.abs() <= DRIFT);
    }
}

/// At the bandwidth with the greatest least coherence among those whose gain holds, or else among
/// all.
fn turbulence(of: &MeasuredSphere, found: &mut StudyFindings) {
    let worst = |of: &TurbulenceResponse| {
        let bands = of.bands.iter().filter(|band| band.to_hz <= FOLLOWED_HZ);
        bands.fold((1.0_f64, 0.0_f64), |(least, off), band| {
            (least.min(band.coherence), off.max((band.gain - 1.0).abs()))
        })
    };
    let key = |of: &TurbulenceResponse| {
        let (least, off) = worst(of);
        if off <= GAIN { 1.0 + least } else { least - off }
    };
    let Some(best) = of.turbulence.iter().max_by(|a, b| key(a).total_cmp(&key(b))) else { return };
    let (least, off) = worst(best);
    let at = format!("up to {FOLLOWED_HZ} Hz by bands, {}", best.mode);
    found
        .reported(format!("coherence {at}"), format!("{least:.3} at least"))
        .judged(format!("at least {COHERENCE}"), least >= COHERENCE);
    found
        .reported(format!("gain {at}"), format!("{} off at worst", percent(off, 1)))
        .judged(format!("within {}", percent(GAIN, 0)), off <= GAIN);
}

fn percent(share: f64, digits: usize) -> String {
    format!("{:.digits$} %", 100.0 * share)
}

fn signed(share: f64) -> String {
    format!("{:+.2} %", 100.0 * share)
}
