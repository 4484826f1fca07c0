//! Constant temperature, current and power on one head: `studies benchmark modes`.
//!
//! ```text
//! r = Σ P_i / (T_i − T_gas)       the reading of all three: a conductance
//! ```
//!
//! In constant-current (CCA) and constant-power (CPA) operation the temperature moves with the
//! wind, and the whole structure with it; in constant-temperature operation (CTA, the thermal
//! sigma-delta loop) the power does. How fast r follows a step of the wind, how much of it creeps,
//! and what a gas or a support that is 10 K warmer than believed does to it differs by the mode,
//! and by numbers of a head that nobody has published: these are varied over their range.
//!
//! | file | what |
//! |---|---|
//! | [`compared`] | a head with the same elements heated in every mode |
//! | [`jump`] | a run with a step of the wind, in one mode |
//! | [`warmer`] | steady states in a warmer gas, and on a warmer support |
//! | [`report`] | the figures as text, as JSON and as a page |

pub mod compared;
pub mod jump;
pub mod report;
pub mod warmer;

use anemometry::head::Head;
use anyhow::Result;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Uniform};

pub use compared::{ComparedHead, ModeFigures, OperatingMode};
pub use report::{HeadModes, ModesReport};

/// The figures of all modes on one head.
///
/// # Errors
/// If it cannot be simulated, or a run trips.
pub fn figures(head: &Head, overheat_k: f64) -> Result<Vec<ModeFigures>> {
    let mut compared = ComparedHead::new(head.clone(), overheat_k)?;
    let mut all = Vec::new();
    let mut of_cta_s = None;
    for mode in OperatingMode::ALL {
        let course = jump::course(&compared, mode)?;
        let response_s = course.response_s();
        let [gas_percent, support_percent] = warmer::errors(&mut compared, mode);
        all.push(ModeFigures {
            mode,
            response_s,
            creep_percent: course.left_percent(10.0 * *of_cta_s.get_or_insert(response_s)),
            gas_percent,
            support_percent,
        });
    }
    Ok(all)
}

/// The figures of a head as its file is, and of so many others within the ranges of its unknown
/// numbers: all at their least, all at their most, and log-uniform draws between.
///
/// # Errors
/// As [`figures`].
pub fn compare(head: &Head, overheat_k: f64, draws: usize, progress: &dyn Fn(&str)) -> Result<HeadModes> {
    progress(&head.name);
    let nominal = figures(head, overheat_k)?;
    let unknown = head.body.as_ref().map_or(&[][..], |body| &body.unknown);
    let mut others = Vec::new();
    if !unknown.is_empty() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let uniform = Uniform::new(0.0, 1.0).unwrap_or_else(|_| unreachable!("0 is below 1"));
        for draw in 0..draws {
            let mut share = |_: usize| match draw {
                0 => 0.0,
                1 => 1.0,
                _ => uniform.sample(&mut rng),
            };
            let values = unknown.iter().enumerate().map(|(i, of)| of.least * libm::pow(of.most / of.least, share(i)));
            let values: Vec<f64> = values.collect();
            progress(&format!("{}, draw {} of {draws}", head.name, draw + 1));
            others.push(figures(&head.with_unknown(&values)?, overheat_k)?);
        }
    }
    Ok(HeadModes::new(head, overheat_k, nominal, &others))
}

#[cfg(test)]
mod tests {
    use super::*;
    use recording::toml_file::TomlSource;

    /// One film of 50 mJ/K that obeys King's law and has nothing behind it.
    const TEXT: &str = "name = \"king\"
[adc]
full_scale_v = 8.0
bits = 24
[guard]
missing_limit_ticks = 1
unreachable_limit_s = 1000.0
[[elements]]
name = \"film\"
platinum = { characteristic = \"linear\", resistance_0c_ohm = 100.0, coefficient_per_c = 0.004 }
current_low_a = 0.003
current_high_a = 0.032
resistance_min_ohm = 50.0
resistance_max_ohm = 150.0
temperature_max_c = 90.0
[body]
nodes = [ { name = \"film\", capacity_j_k = 0.05 } ]
unknown = [ { of = \"body.nodes[0].capacity_j_k\", least = 0.02, most = 0.08 } ]
[[body.convection]]
correlation = { kind = \"king\", a_w_k = 1e-3, b_w_k = 1e-3, exponent = 0.5 }
surfaces = [ { name = \"film\" } ]
";

    #[test]
    fn modes_of_a_known_film_are_as_fast_and_as_wrong_as_theory_has_them() {
        let head = Head::from_source(TomlSource { path: "h.toml".into(), text: TEXT.to_owned() }).unwrap();
        let report = compare(&head, 30.0, 2, &|_| {}).unwrap();
        let [cta, cca, cpa] = report.nominal[..] else { panic!("three modes") };
        // The loop reads the wind from the power of the next second.
        assert!(cta.response_s <= 1.5, "{cta:?}");
        // CPA: the rise goes from P/G1 to P/G2 with C/G2, G 2.73 and 3.45 mW/K: r = P/rise has made
        // nine tenths of its change where rise is 1.0265 of its end, ln(0.264/0.0213) · 14.5 s = 34
        // s.
        let rise = |t: f64| 1.0 + (3.449 / 2.732 - 1.0) * libm::exp(-t * 3.449e-3 / 0.05_f64);
        let there = 2.732 + 0.9 * (3.449 - 2.732);
        let expected_s = (0..1000).map(|k| 0.1 * f64::from(k)).find(|&t| 3.449 / rise(t) >= there).unwrap();
        // Half the steps of the means, and bits, which make them noisy.
        assert!((cpa.response_s - expected_s).abs() < 2.0, "{cpa:?} for {expected_s}");
        assert!(cca.response_s > 0.9 * expected_s, "{cca:?}");
        // A gas 10 K warmer takes a third less of the power: r is 2/3, and a wind of r² in what is
        // beyond a; by the slope between the winds it is (2/3)^(1/0.336).
        let slope = libm::log(3.449_f64 / 2.732) / libm::log(2.0);
        let expected = 100.0 * (libm::pow(2.0_f64 / 3.0, 1.0 / slope) - 1.0);
        assert!((cta.gas_percent - expected).abs() < 0.5, "{cta:?} for {expected}");
        // Nothing leads to the support.
        assert!(cta.support_percent.abs() < 1e-6 && cca.support_percent.abs() < 1e-6);
        // Over the range of its capacity CPA is as slow as that, from 0.4 to 1.6 times.
        let [least, most] = report.ranges[2];
        assert!((least.response_s / expected_s - 0.4).abs() < 0.1, "{least:?}");
        assert!((most.response_s / expected_s - 1.6).abs() < 0.1, "{most:?}");
    }
}
