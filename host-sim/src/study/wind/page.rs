//! The page of the wind's numbers, `wind.md`: the bars with what was measured, and tables by bandwidth.

use std::fmt::Write as _;

use super::Measured;
use super::directions::SETTLE_S;
use crate::answer::errors::Errors;
use crate::thesis::{Finding, Findings};

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
pub fn findings(of: &Measured) -> Findings {
    let mut found = Findings::default();
    directions(of, &mut found);
    steps(of, &mut found);
    turbulence(of, &mut found);
    let swing = &of.swing;
    let ours = format!("{} at worst, {} rms", percent(swing.speed_worst, 2), percent(swing.speed_rms, 2));
    found.push(
        Finding::told(
            format!("speed, gas swinging by {} K, means of 10 s", swing.kelvin),
            format!("raw conductance swings by {}", percent(swing.raw_span, 1)),
            ours,
        )
        .judged(format!("at most {}", percent(SWING, 0)), swing.speed_worst <= SWING),
    );
    found
}

/// Errors in unseen winds, at the bandwidth with the least.
fn directions(of: &Measured, found: &mut Findings) {
    let rms = |errors: &Errors| errors.speed_rms().unwrap_or(f64::NAN);
    let Some(best) = of.directions.iter().min_by(|a, b| rms(&a.errors).total_cmp(&rms(&b.errors))) else { return };
    let direction_deg = best.errors.direction_rms_deg();
    let at = format!("{} unseen winds, {}", best.winds, best.mode);
    if let Some(direction_deg) = direction_deg.filter(|_| of.sphere.whole) {
        let linear = best.errors.linear_rms_deg().map_or(String::new(), |deg| format!("linear inverse {deg:.2}°"));
        found.push(
            Finding::told(format!("direction, {at}"), linear, format!("{direction_deg:.2}° rms"))
                .judged(format!("at most {DIRECTION_DEG}° rms"), direction_deg <= DIRECTION_DEG),
        );
    }
    let speed = rms(&best.errors);
    let ours =
        format!("{} rms, {} at worst", percent(speed, 2), percent(best.errors.speed_worst().unwrap_or(f64::NAN), 2));
    found.push(
        Finding::told(format!("speed, {at}"), "", ours)
            .judged(format!("at most {} rms", percent(SPEED, 1)), speed <= SPEED),
    );
}

fn steps(of: &Measured, found: &mut Findings) {
    let judged = of.steps.iter().find(|steps| steps.mode == of.sphere.judged);
    let raw_s = of.drift.raw_response_s;
    for (place, words) in ["2 to 6 m/s", "6 to 2 m/s"].into_iter().enumerate() {
        let Some(way) = judged.map(|steps| &steps.ways[place]) else { continue };
        let what = format!("within 5 % for good after {words}, mean of many steps, {}", of.sphere.judged);
        let ours = format!("{:.2} s; one answer has {} of noise", way.mean_response_s, percent(way.noise, 1));
        let met = way.mean_response_s <= of.sphere.response_s;
        found.push(
            Finding::told(what, format!("raw {:.2} s", raw_s[place]), ours)
                .judged(format!("at most {} s", of.sphere.response_s), met),
        );
        let single = format!("{:.2} s; {} of the answers are outside", way.single_response_s, percent(way.outside, 1));
        found.push(Finding::told(format!("the same, median of single steps over 6 s, {words}"), "", single));
        let (drift, raw) = (of.drift.answer[place], of.drift.raw[place]);
        found.push(
            Finding::told(
                format!("drift in 10 min after {words}, {}", of.drift.mode),
                format!("raw {}", signed(raw)),
                signed(drift),
            )
            .judged(format!("at most {}", percent(DRIFT, 1)), drift.abs() <= DRIFT),
        );
    }
}

/// At the bandwidth with the greatest least coherence among those whose gain holds, or else among all.
fn turbulence(of: &Measured, found: &mut Findings) {
    let worst = |of: &super::Turbulence| {
        let bands = of.bands.iter().filter(|band| band.to_hz <= FOLLOWED_HZ);
        bands.fold((1.0_f64, 0.0_f64), |(least, off), band| {
            (least.min(band.coherence), off.max((band.gain - 1.0).abs()))
        })
    };
    let key = |of: &super::Turbulence| {
        let (least, off) = worst(of);
        if off <= GAIN { 1.0 + least } else { least - off }
    };
    let Some(best) = of.turbulence.iter().max_by(|a, b| key(a).total_cmp(&key(b))) else { return };
    let (least, off) = worst(best);
    let at = format!("to {FOLLOWED_HZ} Hz, by bands, {}", best.mode);
    let coherence = Finding::told(format!("coherence with the true speed {at}"), "", format!("{least:.3} at least"));
    found.push(coherence.judged(format!("at least {COHERENCE}"), least >= COHERENCE));
    let gain = Finding::told(format!("gain {at}"), "", format!("{} off at worst", percent(off, 1)));
    found.push(gain.judged(format!("within {}", percent(GAIN, 0)), off <= GAIN));
}

fn percent(share: f64, digits: usize) -> String {
    format!("{:.digits$} %", 100.0 * share)
}

fn signed(share: f64) -> String {
    format!("{:+.2} %", 100.0 * share)
}

/// All of it.
pub fn page(all: &[Measured]) -> String {
    let mut text = "# From powers to wind: what is reached\n\nMade by `anemo study wind`, from the experiments in [`experiments/wind`](../../experiments/wind). Each simulated head is identified in still gas, calibrated in 120 winds, and then\njudged in winds, steps, turbulence and a gas that it has not seen: 220 K, 10 mbar of CO2, 4 µV of noise, 24 bit, platinum of class A.\nNothing here knows the truth but the errors. *Raw* is power over overheat, without the network: its speed is that of the power law through its own two settled values.\nAn observer keeps its bandwidth until the wind jumps, and is quick for a while after that; where it says *fixed*, it stays.\n".to_owned();
    for of in all {
        section(&mut text, of);
    }
    text
}

// Writing to a String cannot fail.
fn section(text: &mut String, of: &Measured) {
    let found = findings(of);
    let _ = write!(text, "\n## {}\n\nCalibration: {}.\n\n", of.sphere.title, of.made_from);
    let _ = writeln!(text, "| what | bar | measured | beside it | |\n|---|---|---|---|---|");
    for finding in &found.findings {
        let met = finding.met.map_or("", |met| if met { "met" } else { "**not met**" });
        let _ =
            writeln!(text, "| {} | {} | {} | {} | {met} |", finding.what, finding.bar, finding.ours, finding.published);
    }
    let _ = write!(
        text,
        "\nUnseen winds of 1 to 13 m/s outside 20° around the stem, by bandwidth; {SETTLE_S} s of each 6 s are left out:\n\n| bandwidth | speed rms | mean | worst | direction rms | worst | linear inverse rms |\n|---|---|---|---|---|---|---|\n"
    );
    for row in &of.directions {
        let errors = &row.errors;
        let degrees = |deg: Option<f64>| deg.map_or("–".to_owned(), |deg| format!("{deg:.2}°"));
        let share = |share: Option<f64>| share.map_or("–".to_owned(), |share| percent(share, 2));
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} |",
            row.mode,
            share(errors.speed_rms()),
            share(errors.speed_bias()),
            share(errors.speed_worst()),
            degrees(errors.direction_rms_deg()),
            degrees(errors.direction_worst_deg()),
            degrees(errors.linear_rms_deg())
        );
    }
    let _ = write!(
        text,
        "\nSteps of 2 to 6 m/s and back, 60 of each, by bandwidth: until within 5 % of the new speed for good, of the mean of all and as the median of single ones;\nnoise of single answers, and how many of them it puts outside:\n\n| bandwidth | to | mean of all | single | noise | outside 5 % |\n|---|---|---|---|---|---|\n"
    );
    for steps in &of.steps {
        for way in &steps.ways {
            let _ = writeln!(
                text,
                "| {} | {} m/s | {:.2} s | {:.2} s | {} | {} |",
                steps.mode,
                way.to_m_s,
                way.mean_response_s,
                way.single_response_s,
                percent(way.noise, 2),
                percent(way.outside, 1)
            );
        }
    }
    let _ = write!(
        text,
        "\nTurbulence about 5 m/s, von Kármán's, 20 %, 10 m: coherence and gain of the speed by band:\n\n| bandwidth |"
    );
    for band in of.turbulence.first().map_or(&[][..], |first| &first.bands) {
        let _ = write!(text, " {} to {} Hz |", band.from_hz, band.to_hz);
    }
    let _ = write!(text, "\n|---|{}\n", "---|".repeat(of.turbulence.first().map_or(0, |first| first.bands.len())));
    for row in &of.turbulence {
        let _ = write!(text, "| {} |", row.mode);
        for band in &row.bands {
            let _ = write!(text, " {:.3}, {:.3} |", band.coherence, band.gain);
        }
        let _ = writeln!(text);
    }
    let _ = write!(
        text,
        "\nNoise of a part's conductance, 30 K warmer than the gas, at 1 kHz:\n\n| bandwidth | noise |\n|---|---|\n"
    );
    for (bandwidth_hz, noise_w_k) in &of.noise_w_k {
        let _ = writeln!(text, "| {bandwidth_hz} Hz | {:.1} µW/K |", 1e6 * noise_w_k);
    }
}
