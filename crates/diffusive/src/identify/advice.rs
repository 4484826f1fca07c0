//! What the next record of the same body should be, from what is known of it by this one.
//!
//! | part | rule |
//! |---|---|
//! | length | five times the slowest time constant that carries weight; three times this record where a steady gain is not known to a tenth |
//! | input | pseudo-random bits of 0.4 times the fastest time constant that carries weight, one sample at least; the register so long that its sequence reaches down to the slowest rate, (2ⁿ − 1) bit ≥ 2π τ (thesis 2.5) |
//! | amplitude | a response of a hundred times what the model leaves |
//! | levels | a second pair of them where losses grow with temperature, or were requested |
//! | surroundings | their temperature, where the offset moved or predictions err by much |
//!
//! A time constant carries weight where relaxations up to it make a twentieth of the steady gain.

use std::f64::consts::{PI, TAU};

use dr_core::signal::prbs::ORDERS;
use recording::text::brief;

use crate::model::{Class, Model, ModelOutput, Pair, Whiteness};

/// Share of a steady gain that carries weight.
const WEIGHT: f64 = 0.05;
/// Share of an output's motion below which a pair is not what a record is made for.
const MINOR: f64 = 0.1;
/// Time constants that a record is long, at least, and lengths of this one where that is unsure.
const TIME_CONSTANTS: f64 = 5.0;
const LENGTHS: f64 = 3.0;
/// Relative standard error of a steady gain that is unsure.
const UNSURE: f64 = 0.1;
/// Bit of the sequence, and sample period, in fastest time constants.
const BIT: f64 = 0.4;
const SAMPLE: f64 = 0.2;
/// Response in residuals.
const CLEAR: f64 = 100.0;
/// Error ahead, as a share of the output's spread, that is large.
const FAR: f64 = 0.1;

/// A sentence for every part, that of the length first. `losses_asked`: losses that grow with
/// temperature were looked for on request.
pub fn advice(model: &Model, longest_s: f64, losses_asked: bool) -> Vec<String> {
    let (slowest_s, fastest_s) = time_constants(model);
    if slowest_s == 0.0 {
        // A response of nothing says nothing of the body.
        return Vec::new();
    }
    let mut advice = vec![length(model, longest_s, slowest_s), input(model, slowest_s, fastest_s)];
    advice.extend(amplitude(model));
    if losses_asked || model.losses.is_some() {
        advice.push("levels: bits between two levels for half of the record, between one of them and a third for the rest, so that a gain that falls with temperature shows".to_owned());
    }
    advice.extend(surroundings(model));
    advice
}

fn length(model: &Model, longest_s: f64, slowest_s: f64) -> String {
    // What a segment began with hides what is slower than it.
    let in_one = if longest_s < model.provenance.duration_s { " in one piece" } else { "" };
    let unsure = weighty(model).into_iter().map(|(_, class)| uncertainty(class)).fold(0.0, f64::max);
    let least_s = TIME_CONSTANTS * slowest_s;
    if unsure > UNSURE {
        let needed = rough(least_s.max(LENGTHS * longest_s));
        let known = if unsure < 1.0 {
            format!("is known to ±{} % only", rough(100.0 * unsure))
        } else {
            "is not known at all".to_owned()
        };
        return format!(
            "length: {needed} s or more{in_one}, {LENGTHS} times the present {} s at least: a steady gain {known}, and so are slow time constants",
            brief(longest_s)
        );
    }
    let slowest = rough(slowest_s);
    if least_s > longest_s {
        let needed = rough(least_s);
        return format!(
            "length: {needed} s or more{in_one}, {TIME_CONSTANTS} times the slowest time constant that carries weight, {slowest} s"
        );
    }
    let (present, times) = (brief(longest_s), rough(longest_s / slowest_s));
    format!(
        "length: the present {present} s{in_one} are enough, {times} times the slowest time constant that carries weight, {slowest} s"
    )
}

fn input(model: &Model, slowest_s: f64, fastest_s: f64) -> String {
    let period_s = model.sample_period_s;
    let bit_s = period_s * (BIT * fastest_s / period_s).floor().max(1.0);
    let bits = libm::log2(TAU * slowest_s / bit_s + 1.0).ceil() as u8;
    let order = bits.clamp(*ORDERS.start(), *ORDERS.end());
    let sequence_s = (libm::exp2(f64::from(order)) - 1.0) * bit_s;
    let [bit, fastest, sequence] = [brief(bit_s), rough(fastest_s), rough(sequence_s)];
    let slow = if period_s > SAMPLE * fastest_s {
        format!("; sample every {} s or faster", rough(SAMPLE * fastest_s))
    } else {
        String::new()
    };
    format!(
        "input: pseudo-random bits of {bit} s for a fastest time constant that carries weight of {fastest} s, from a register of {order} bits, whose sequence lasts {sequence} s (`prbs = {{ order = {order}, bit_time_s = {bit}, seed = 1 }}`){slow}"
    )
}

/// Of the output whose response is least clear.
fn amplitude(model: &Model) -> Option<String> {
    let of = |output| Some((output, clearness(output)?));
    let (output, clear) = model.outputs.iter().filter_map(of).min_by(|a, b| a.1.total_cmp(&b.1))?;
    let (name, times) = (&output.name, rough(clear));
    if clear >= CLEAR {
        return Some(format!("amplitude: as now, the response of `{name}` is {times} times what is left"));
    }
    let but = if is_white(output) {
        ""
    } else {
        "; what is left is no noise, but a disturbance, or structure that the model lacks"
    };
    Some(format!(
        "amplitude: {} times the present one, as far as the element bears it: the response of `{name}` is {times} times what is left, and {CLEAR} would be clear{but}",
        rough(CLEAR / clear)
    ))
}

fn is_white(output: &ModelOutput) -> bool {
    output.whiteness.as_ref().is_none_or(Whiteness::is_white)
}

/// How often the residual goes into what the inputs explain of an output.
fn clearness(output: &ModelOutput) -> Option<f64> {
    let left = (1.0 - output.fit_percent / 100.0).clamp(0.0, 1.0);
    let response = output.spread_rms? * (1.0 - left * left).sqrt();
    (response > 0.0 && output.residual_rms > 0.0).then(|| response / output.residual_rms)
}

fn surroundings(model: &Model) -> Option<String> {
    if model.gas_column().is_some() {
        return None;
    }
    let reason = model.outputs.iter().find_map(|output| {
        let name = &output.name;
        match &output.drift {
            Some(drift) if !drift.is_average() => return Some(format!("the offset of `{name}` moved")),
            Some(_) if !is_white(output) => return Some(format!("the offset of `{name}` may have moved")),
            _ => {}
        }
        let (ahead, spread) = (output.forecast_rms?, output.spread_rms?);
        let share = rough(100.0 * ahead / spread);
        (ahead > FAR * spread).then(|| {
            format!("what comes after the record is predicted of `{name}` with an error of {share} % of its spread")
        })
    })?;
    Some(format!("surroundings: record their temperature in a column of its own, since {reason}"))
}

/// A number to its second digit.
fn rough(value: f64) -> String {
    let place = libm::pow(10.0, libm::log10(value.abs().max(f64::MIN_POSITIVE)).floor() - 1.0);
    brief((value / place).round() * place)
}

/// Relative standard error of a steady gain.
fn uncertainty(class: &Class) -> f64 {
    class.se_steady_gain_k_per_w / class.steady_gain_k_per_w.abs().max(f64::MIN_POSITIVE)
}

/// What makes a good part of its output's motion: pairs with one of their classes.
fn weighty(model: &Model) -> Vec<(&Pair, &Class)> {
    let effect = |(pair, class): &(&Pair, &Class)| {
        let input = model.inputs.iter().position(|input| *input == pair.input);
        let range = input.and_then(|input| model.provenance.input_range.get(input));
        class.steady_gain_k_per_w.abs() * range.map_or(1.0, |[least, most]| most - least)
    };
    let all = || model.pairs.iter().flat_map(|pair| pair.classes.values().map(move |class| (pair, class)));
    let most = |output: &str| all().filter(|(pair, _)| pair.output == output).map(|of| effect(&of)).fold(0.0, f64::max);
    all().filter(|of| effect(of) >= MINOR * most(&of.0.output)).collect()
}

/// The slowest and the fastest time constant that carry weight, s.
fn time_constants(model: &Model) -> (f64, f64) {
    let (mut slowest_s, mut fastest_s) = (0.0_f64, f64::INFINITY);
    for (pair, class) in weighty(model) {
        // Faster rates than a sample tells are heat that arrives within one.
        let told = pair.mesh_rad_s.partition_point(|rate| *rate <= 1.01 * PI / model.sample_period_s);
        let rates = || pair.mesh_rad_s[..told].iter().zip(&class.r_k_per_w);
        let weight = WEIGHT * class.steady_gain_k_per_w.abs();
        slowest_s = slowest_s.max(first_of_weight(rates(), weight));
        fastest_s = fastest_s.min(first_of_weight(rates().rev(), weight));
    }
    (slowest_s, fastest_s.min(slowest_s))
}

/// 1/rate at which a sum of resistances has so much weight, s; 0 of none.
fn first_of_weight<'m>(rates: impl Iterator<Item = (&'m f64, &'m f64)>, weight: f64) -> f64 {
    let mut sum = 0.0_f64;
    let reaches = |(rate, resistance): (&f64, &f64)| {
        sum += resistance;
        (sum.abs() > weight).then_some(1.0 / rate)
    };
    { rates }.find_map(reaches).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::OutputDrift;
    use crate::model::testing;

    /// 50 s, 5 s and 0.5 s; the last carries 1 % of the gain; swings by 2 K over 5 mK.
    fn model(duration_s: f64) -> Model {
        let mut model = testing::model(&[0.02, 0.2, 2.0], &[79.0, 20.0, 1.0]);
        model.provenance.duration_s = duration_s;
        model.provenance.input_range = vec![[0.0, 0.1]];
        (model.outputs[0].spread_rms, model.outputs[0].fit_percent) = (Some(2.0), 99.75);
        model
    }

    #[test]
    fn a_record_that_is_long_and_clear_enough_is_to_be_as_it_is() {
        let advice = advice(&model(1000.0), 1000.0, false);
        assert_eq!(
            advice,
            [
                "length: the present 1000 s are enough, 20 times the slowest time constant that carries weight, 50 s",
                // 0.4 · 5 s; 2π · 50 s are 157 bits, for which eight stages do.
                "input: pseudo-random bits of 2 s for a fastest time constant that carries weight of 5 s, from a register of 8 bits, whose sequence lasts 510 s (`prbs = { order = 8, bit_time_s = 2, seed = 1 }`)",
                // 2 K over 5 mK
                "amplitude: as now, the response of `temperature_c_a` is 400 times what is left",
            ]
        );
    }

    #[test]
    fn what_a_record_lacks_the_next_one_has() {
        let mut short = model(100.0);
        let starts = |model: &Model, at: usize, start: &str| {
            let advice = advice(model, model.provenance.duration_s, true);
            assert!(advice[at].starts_with(start), "{advice:#?}");
        };
        starts(&short, 0, "length: 250 s or more, 5 times");
        short.pairs[0].classes.get_mut("all").unwrap().se_steady_gain_k_per_w = 20.0;
        starts(
            &short,
            0,
            "length: 300 s or more, 3 times the present 100 s at least: a steady gain is known to ±20 % only",
        );
        short.sample_period_s = 3.0;
        starts(&short, 1, "input: pseudo-random bits of 3 s");
        assert!(advice(&short, short.provenance.duration_s, true)[1].ends_with("; sample every 1 s or faster"));
        let output = &mut short.outputs[0];
        output.residual_rms = 0.1;
        let whiteness = Whiteness { autocorrelation: vec![0.9], q: 1e3, p_value: 0.0, inflation: 5.0 };
        output.whiteness = Some(whiteness);
        starts(&short, 2, "amplitude: 5 times the present one");
        assert!(advice(&short, short.provenance.duration_s, true)[2].ends_with("or structure that the model lacks"));
        starts(&short, 3, "levels: ");
        assert_eq!(advice(&short, short.provenance.duration_s, false).len(), 3);
        short.outputs[0].forecast_rms = Some(0.5);
        starts(&short, 4, "surroundings: record their temperature in a column of its own, since what comes after");
        short.outputs[0].drift = Some(OutputDrift {
            kind: "random-walk".to_owned(),
            size: 1e-3,
            correlation_s: None,
            last_level_k: 0.1,
            evidence_nats: 50.0,
        });
        assert!(
            advice(&short, short.provenance.duration_s, true)[4]
                .ends_with("since the offset of `temperature_c_a` moved")
        );
        short.outputs[0].drift.as_mut().unwrap().kind = OutputDrift::AVERAGE.to_owned();
        assert!(
            advice(&short, short.provenance.duration_s, true)[4]
                .ends_with("since the offset of `temperature_c_a` may have moved")
        );
    }
}
