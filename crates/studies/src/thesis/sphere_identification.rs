//! Why sphere A answers with a tail and sphere B does not, read off models that were identified
//! open loop.

use anyhow::Result;
use std::f64::consts::TAU;

use dr_core::sensor::Level;

use super::findings::StudyFindings;
use super::identified::for_a_loop;
use super::lab::StudyLab;
use super::record::StudyRecord;
use super::settling::{SHARES, StepResponse};
use super::sphere_response::{FAST_PERIOD_S, of_a, of_b_repeated};
use diffusive::identify::InitialState;
use diffusive::identify::record::RecordTable;
use diffusive::model::Model;
use diffusive::model::pair_class::PairClass;
use diffusive::predict::analysis::{Analysis, LoopConditions, analyse};
use diffusive::predict::loop_model::LoopModel;
use host_sim::experiment::Experiment;
use nalgebra::{Complex, ComplexField as _};
use plot::{Chart, Scale, Trace, brief};

/// The spheres' set-point, °C.
const TARGET_C: f64 = -23.15;
/// Time at the beginning of each wind that belongs to the wind before and to warming up, s.
const FORGOTTEN_S: f64 = 400.0;
/// A zero whose weight in the power is less than this share of its steady value is no tail.
const MATTERS: f64 = 0.02;

/// One prototype.
struct ThesisSphere {
    letter: char,
    prbs: &'static str,
    step: &'static str,
    parts: &'static [&'static str],
    /// Rates of the parts together, and of the front part by itself.
    poles: (usize, usize),
    /// The thesis found it so.
    fast: bool,
}

const A: ThesisSphere = ThesisSphere {
    letter: 'A',
    prbs: "sphere-a-prbs",
    step: "sphere-a-step",
    parts: &["hemisphere1", "hemisphere2"],
    poles: (3, 4),
    fast: false,
};
const B: ThesisSphere = ThesisSphere {
    letter: 'B',
    prbs: "sphere-b-prbs",
    step: "sphere-b-step",
    parts: &["sector1", "sector2", "sector3", "sector4"],
    poles: (2, 3),
    fast: true,
};

/// A sphere with what its winds show.
struct IdentifiedSphere {
    sphere: &'static ThesisSphere,
    winds: Vec<SphereInWind>,
}

/// Result in one wind.
struct SphereInWind {
    label: String,
    /// Mean temperature of the parts under the power that each gets.
    together: IdentifiedLoop,
    /// Temperature of the front part under the same power.
    front: IdentifiedLoop,
}

/// Loop of a model, and its symbol over Hz.
struct IdentifiedLoop {
    analysis: Analysis,
    points: Vec<(f64, f64)>,
}

pub fn run(lab: &StudyLab, findings: &mut StudyFindings) -> Result<()> {
    let spheres = [IdentifiedSphere::of(lab, &A)?, IdentifiedSphere::of(lab, &B)?];
    findings.fill("poles_and_zeros", poles_and_zeros(&spheres));
    let names = [["wind_a", "verdict_a", "front_verdict_a"], ["wind_b", "verdict_b", "front_verdict_b"]];
    for ([wind, verdict, front], of) in names.into_iter().zip(&spheres) {
        findings.fill(wind, of.fastest().label.clone());
        findings.fill(verdict, of.fastest().together.analysis.verdict(&[]));
        findings.fill(front, of.fastest().front.analysis.verdict(&[]));
    }
    judge(findings, &spheres);
    let slow_period_s = lab.experiment(A.step)?.sample_period_s;
    let fast = of_b_repeated(lab, &lab.experiment(B.step)?, FAST_PERIOD_S)?;
    let measured = [(of_a(lab)?, slow_period_s), (fast, FAST_PERIOD_S)];
    for (of, (measured, period_s)) in spheres.iter().zip(&measured) {
        predicted(findings, of, measured, *period_s);
    }
    let charts = |what: fn(&ThesisSphere) -> &'static str, of: fn(&SphereInWind) -> &IdentifiedLoop| {
        let chart = |IdentifiedSphere { sphere, winds }: &IdentifiedSphere| {
            let stems = winds.iter().map(|wind| Trace::stems(wind.label.clone(), of(wind).points.clone()));
            let chart = Chart::new(format!("Sphere {}, {}", sphere.letter, what(sphere)), "K/W");
            chart.x(Scale::Log, "Hz").height(38.0).traces(stems)
        };
        spheres.iter().map(chart).collect()
    };
    findings.picture(
        "Spheres A and B: why one is slow and one is fast",
        [charts(|_| "parts together", |wind| &wind.together), charts(|sphere| sphere.parts[0], |wind| &wind.front)],
    );
    Ok(())
}

impl IdentifiedSphere {
    fn of(lab: &StudyLab, sphere: &'static ThesisSphere) -> Result<Self> {
        let loops = lab.experiment(sphere.step)?;
        let (experiment, record) = lab.run(sphere.prbs)?;
        let ends = experiment.wind.iter().skip(1).map(|wind| wind.start_s).chain([experiment.duration_s()]);
        let of = |(wind, to_s): (&host_sim::sensor::WindEntry, f64)| {
            let identified = |output: &[&str], poles: usize| {
                let span_s = (wind.start_s + FORGOTTEN_S, to_s);
                let model = for_a_loop(mean_of(&record, sphere.parts, output, span_s)?, poles, InitialState::Free)?;
                anyhow::Ok(IdentifiedLoop { analysis: analysed(&model, &loops)?, points: points(&model) })
            };
            let together = identified(sphere.parts, sphere.poles.0)?;
            Ok(SphereInWind {
                label: wind.label.clone(),
                together,
                front: identified(&sphere.parts[..1], sphere.poles.1)?,
            })
        };
        let winds = experiment.wind.iter().zip(ends).map(of).collect::<Result<_>>()?;
        Ok(Self { sphere, winds })
    }

    /// In the last wind.
    fn fastest(&self) -> &SphereInWind {
        &self.winds[self.winds.len() - 1]
    }
}

/// The mean power of some elements as the input, the mean temperature of some as the output.
fn mean_of(record: &StudyRecord, inputs: &[&str], outputs: &[&str], (from_s, to_s): (f64, f64)) -> Result<RecordTable> {
    let tick = |time_s: f64| (time_s / record.sample_period_s).round() as usize;
    let span = tick(from_s)..tick(to_s).min(record.ticks());
    let mean = |columns: Vec<&[f64]>| -> Vec<f64> {
        let count = columns.len() as f64;
        span.clone().map(|n| columns.iter().map(|column| column[n]).sum::<f64>() / count).collect()
    };
    let powers = inputs.iter().map(|name| record.power_w(name)).collect::<Result<_, _>>()?;
    let celsius = outputs.iter().map(|name| record.temperature_c(name)).collect::<Result<_, _>>()?;
    let input = ("power_w_sphere".to_owned(), mean(powers));
    let output = ("temperature_c_sphere".to_owned(), mean(celsius));
    Ok(RecordTable::new(record.sample_period_s, vec![input], vec![output])?)
}

fn points(model: &Model) -> Vec<(f64, f64)> {
    let pair = &model.pairs[0];
    let r = pair.classes.values().next().into_iter().flat_map(|class| &class.r_k_per_w);
    pair.mesh_rad_s.iter().map(|rate| rate / TAU).zip(r.copied()).collect()
}

/// The loop of the step experiment around such a model.
fn analysed(model: &Model, loops: &Experiment) -> Result<Analysis> {
    let part = PairClass::find(model, None, None)?;
    let loop_model = LoopModel::of(&part, None)?;
    let level = |level: Level| loops.head.elements[0].power_w(TARGET_C, level);
    let conditions = LoopConditions {
        target_c: TARGET_C,
        power_low_w: level(Level::Low),
        power_high_w: level(Level::High),
        sample_period_s: loops.sample_period_s,
    };
    Ok(analyse(&loop_model, Some(conditions)))
}

/// The slowest zero that weighs something, rad/s.
fn slowest(analysis: &Analysis) -> Option<(f64, f64)> {
    let weighty = analysis.zeros.iter().filter(|(_, weight)| weight.modulus() >= MATTERS);
    weighty.map(|(rate, weight)| (rate.re, weight.re)).min_by(|a, b| a.0.total_cmp(&b.0))
}

fn poles_and_zeros(spheres: &[IdentifiedSphere]) -> String {
    let row = |(sphere, wind): (&ThesisSphere, &SphereInWind)| {
        let IdentifiedLoop { analysis, points } = &wind.together;
        let seconds: Vec<String> = analysis.poles_rad_s.iter().map(|rate| brief(1.0 / rate)).collect();
        let r: Vec<String> = points.iter().map(|(_, r)| brief(*r)).collect();
        let zero =
            |(rate, weight): &(Complex<f64>, Complex<f64>)| format!("{} ({})", brief(1.0 / rate.re), brief(weight.re));
        let zeros: Vec<String> = analysis.zeros.iter().map(zero).collect();
        let name = format!("{}, {}", sphere.letter, wind.label);
        format!("| {name} | {} | {} | {} |", seconds.join(", "), r.join(", "), zeros.join(", "))
    };
    let winds = spheres.iter().flat_map(|of| of.winds.iter().map(|wind| (of.sphere, wind)));
    winds.map(row).collect::<Vec<_>>().join("\n")
}

fn judge(findings: &mut StudyFindings, spheres: &[IdentifiedSphere]) {
    for IdentifiedSphere { sphere: ThesisSphere { letter, fast, .. }, winds } in spheres {
        let verdicts: Vec<bool> = winds.iter().map(|wind| wind.together.analysis.is_fast(&[])).collect();
        let words = |is_fast: &bool| if *is_fast { "fast" } else { "with a tail" };
        let ours = verdicts.iter().map(words).collect::<Vec<_>>().join(", ");
        let published = if *fast { "one significant pole: fast" } else { "several poles: slow" };
        let bar = if *fast { "fast in all winds" } else { "a tail in all winds" };
        findings
            .compared(format!("{letter}: verdict in 2, 4 and 6 m/s"), published, ours)
            .judged(bar, verdicts.iter().all(|is_fast| is_fast == fast));
    }
    for of in spheres {
        let letter = of.sphere.letter;
        let share = |IdentifiedLoop { analysis, points }: &IdentifiedLoop| {
            let most = points.iter().map(|(_, r)| *r).fold(0.0, f64::max);
            100.0 * most / analysis.steady_gain_k_per_w
        };
        let least = of.winds.iter().map(|wind| share(&wind.together)).fold(f64::INFINITY, f64::min);
        let what = format!("{letter}: largest pole's least share in the steady gain");
        findings.reported(what, format!("{} %", brief(least)));
        if let Some((rate, weight)) = slowest(&of.fastest().front.analysis) {
            let words = format!("{} s, weight {} %", brief(1.0 / rate), brief(100.0 * weight));
            findings.reported(format!("{letter}: slowest zero of the front part, 6 m/s"), words);
        }
    }
}

/// The rate that a zero becomes when the loop decides once a sample period: the root of H(−μ) = −S
/// between the pole below and the zero.
fn of_one_bit(points: &[(f64, f64)], zero_rad_s: f64, period_s: f64) -> f64 {
    let poles = || points.iter().map(|(hz, r)| (TAU * hz, *r));
    let s: f64 = poles().map(|(rate, r)| -r * libm::expm1(-rate * period_s)).sum();
    let sum = |mu: f64| s + poles().map(|(rate, r)| rate * r / (rate - mu)).sum::<f64>();
    let below = poles().map(|(rate, _)| rate).filter(|rate| *rate < zero_rad_s).fold(0.0, f64::max);
    let (mut low, mut high) = (below, zero_rad_s);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if sum(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    f64::midpoint(low, high)
}

/// Times to 10, 5 and 2 % from the slowest zero, beside those of the step.
fn predicted(findings: &mut StudyFindings, of: &IdentifiedSphere, measured: &StepResponse, period_s: f64) {
    let (letter, wind) = (of.sphere.letter, of.fastest());
    let Some((rate, _)) = slowest(&wind.together.analysis) else { return };
    let sampled = of_one_bit(&wind.together.points, rate, period_s);
    let mut times: [Vec<String>; 3] = Default::default();
    for share in SHARES {
        let constants = libm::log(100.0 / share);
        let (own_s, seen_s) = (constants / sampled, measured.settled_s(share));
        times[0].push(brief(constants / rate));
        times[1].push(match seen_s {
            Some(seen_s) => format!("{} ({:+.0} %)", brief(own_s), 100.0 * (own_s / seen_s - 1.0)),
            None => brief(own_s),
        });
        times[2].push(seen_s.map_or("not in this run".to_owned(), brief));
    }
    let [limit, own, seen] = times.map(|of| of.join(", "));
    findings.reported(
        format!("{letter}: times to 10, 5 and 2 %"),
        format!("limit {limit} s, bit each {} ms {own} s, measured {seen} s", 1e3 * period_s),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_loop_acts_as_a_resistance_beside_the_solder() {
        // Silver of 0.118 J/K behind 2 W/K and a chip without capacity to speak of: C (R + S) is
        // the loop's time constant.
        let points = [(0.01 / TAU, 800.0), (400.0 / TAU, 0.47)];
        let chip = 1.0 - libm::exp(-0.4);
        let s = 800.0 * 1e-5 + 0.47 * chip;
        let limit = slow_zero(&points);
        let found = of_one_bit(&points, limit, 1e-3);
        // 8/(0.01 − μ) + 0.47·400/(400 − μ) + S = 0 at the root, by its parts.
        let value = 8.0 / (0.01 - found) + 0.47 * 400.0 / (400.0 - found) + s;
        assert!(value.abs() < 1e-6 && found < limit && found > 0.5 * limit, "{found} {limit} {value}");
        // Infinitely fast, it is the zero.
        assert!((of_one_bit(&points, limit, 1e-12) / limit - 1.0).abs() < 1e-6);
    }

    /// Slow zero of two poles, in closed form: Σ η_k (ξ_other − μ) = 0.
    fn slow_zero(points: &[(f64, f64); 2]) -> f64 {
        let [(a, ra), (b, rb)] = points.map(|(hz, r)| (TAU * hz, r));
        a * b * (ra + rb) / (a * ra + b * rb)
    }
}
