//! Whole pictures: what stands in them, and that no data make an unsound one.

use super::*;
use crate::{Chart, Figure, Scale, Trace};
use diffusive::model::{Model, Whiteness, testing};
use std::path::Path;

fn texts(svg: &str) -> Vec<&str> {
    svg.lines().filter_map(|line| Some(line.strip_suffix("</text>")?.rsplit_once('>')?.1)).collect()
}

/// Asserts what a picture must not hold, whatever the data.
fn assert_sound(svg: &str) {
    assert!(svg.starts_with("<svg width=\"180mm\""));
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{:?}", texts(svg));
}

#[test]
fn a_figure_has_its_titles_captions_units_and_legends() {
    let points: Vec<(f64, f64)> = (1..50).map(|n| (f64::from(n), 1.0 / f64::from(n))).collect();
    let chart = |caption: &str| {
        Chart::new(caption, "K/W").x(Scale::Log, "rad/s").y(Scale::Log).trace(Trace::line("exact <&>", points.clone()))
    };
    let svg = Figure::new("Title").subtitle("words").row([chart("one"), chart("two")]).row([chart("three")]).svg();
    assert_sound(&svg);
    for text in ["Title", "words", "one", "two", "three"] {
        assert!(texts(&svg).contains(&text), "{text}: {:?}", texts(&svg));
    }
    assert_eq!(svg.matches("exact &lt;&amp;&gt;").count(), 3);
    assert_eq!(texts(&svg).iter().filter(|text| **text == "Rate (rad/s)").count(), 3);
    assert_eq!(texts(&svg).iter().filter(|text| **text == "Thermal resistance (K/W)").count(), 3);
    let other = Figure::new("").row([Chart::new("Rise", "K").trace(Trace::line("", points.clone()))]).svg();
    assert!(texts(&other).contains(&"Rise (K)"), "{:?}", texts(&other));
    assert!(texts(&svg).contains(&"0.1") && texts(&svg).contains(&"10"));
}

#[test]
fn what_a_logarithmic_axis_cannot_show_is_counted_in_the_caption() {
    let points = vec![(0.0, 1.0), (1.0, -1.0), (2.0, 0.0), (3.0, 5.0), (4.0, f64::NAN)];
    let chart = |x, y| Chart::new("c", "K").x(x, "s").y(y).trace(Trace::points("p", points.clone()));
    let of = |x, y| Figure::new("").row([chart(x, y)]).svg();
    assert!(of(Scale::Linear, Scale::Log).contains("2 values at or below zero left out"));
    assert!(of(Scale::Log, Scale::Linear).contains("1 value at or below zero left out"));
    assert!(of(Scale::Log, Scale::Log).contains("3 values at or below zero left out"));
    assert!(!of(Scale::Linear, Scale::Linear).contains("left out"));
}

#[test]
fn any_data_make_a_sound_picture() {
    let cases: Vec<Vec<(f64, f64)>> = vec![
        vec![],
        vec![(1.0, 1.0)],
        vec![(0.0, 0.0)],
        vec![(f64::NAN, f64::NAN), (f64::INFINITY, f64::NEG_INFINITY)],
        vec![(1e-6, 1e6), (1e6, 1e-6)],
        vec![(-1e300, 1e300), (1e300, -1e300)],
        vec![(1e-320, 1e-320), (1.0, 1.0)],
        vec![(5.0, 5.0), (5.0, 5.0)],
        (0..5000).map(|n| (f64::from(n), if n % 7 == 0 { f64::NAN } else { -1.0 })).collect(),
    ];
    for points in &cases {
        let errors: Vec<f64> = points.iter().enumerate().map(|(i, _)| [0.0, 1e9, f64::NAN][i % 3]).collect();
        let scales = [(Scale::Linear, Scale::Linear), (Scale::Log, Scale::Log), (Scale::Linear, Scale::Log)];
        for ((x, y), limit) in scales.into_iter().flat_map(|of| [(of, Some(0.5)), (of, None)]) {
            let chart = Chart::new("c", "K").x(x, "s").y(y).time_constants();
            let chart = limit
                .into_iter()
                .fold(chart, Chart::limit)
                .shading(0.0, 2.0, 1, "a stretch")
                .trace(Trace::line("line", points.clone()))
                .trace(Trace::dashed("dashed", points.clone()))
                .trace(Trace::stems("stems", points.clone()).errors(errors.clone()))
                .trace(Trace::points("points", points.clone()));
            let svg = Figure::new("t").row([chart]).svg();
            assert_sound(&svg);
        }
    }
}

#[test]
fn two_million_points_stay_a_small_picture_in_which_one_stands_out() {
    let points: Vec<(f64, f64)> = (0..2_000_000_u32)
        .map(|n| (f64::from(n) * 5e-4, if n == 1_234_567 { 3.0 } else { f64::from(n % 5) * 0.01 }))
        .collect();
    let svg = Figure::new("t").row([Chart::new("c", "K").trace(Trace::line("", points))]).svg();
    assert!(svg.len() < 200_000, "{}", svg.len());
    assert!(texts(&svg).contains(&"3.0"), "{:?}", texts(&svg));
}

#[test]
fn error_bars_widen_the_axis_until_they_would_hide_the_values() {
    let chart = |error: f64| {
        let points = vec![(1.0, 1.0), (2.0, 2.0)];
        Figure::new("").row([Chart::new("c", "K").trace(Trace::stems("", points).errors(vec![error; 2]))]).svg()
    };
    assert!(!chart(0.5).contains("edge"));
    let wide = chart(1e6);
    assert!(wide.contains("error bars end at the edge") && texts(&wide).contains(&"2"), "{:?}", texts(&wide));
}

fn mesh(order: usize) -> Vec<f64> {
    (0..order).map(|k| dr_core::model::mesh::rate_rad_s(1e-3, 10.0, k, order)).collect()
}

/// One input and output, `order` poles of a rod's like.
pub(crate) fn single(order: usize) -> Model {
    let rates = mesh(order);
    let resistances: Vec<f64> = rates.iter().map(|rate| 200.0 / order as f64 * rate.sqrt() / (0.1 + rate)).collect();
    let mut model = testing::model(&rates, &resistances);
    model.provenance.records = vec!["records/prbs_first.parquet".to_owned()];
    (model.provenance.rows, model.provenance.duration_s) = (36_000, 3600.0);
    model
}

/// `count` elements that heat each other, in the classes of `labels`.
pub(crate) fn network(count: usize, labels: &[&str], order: usize) -> Model {
    let mut model = single(order);
    let (pair, output) = (model.pairs.remove(0), model.outputs.remove(0));
    model.classes = labels.iter().map(|label| (*label).to_owned()).collect();
    model.inputs = (0..count).map(|i| format!("power_w_sector{i}")).collect();
    for i in 0..count {
        let mut own = output.clone();
        own.name = format!("temperature_c_sector{i}");
        for j in 0..count {
            let mut pair = pair.clone();
            (pair.input, pair.output) = (model.inputs[j].clone(), own.name.clone());
            let class = pair.classes.remove("all").unwrap();
            for (n, label) in labels.iter().enumerate() {
                let mut class = class.clone();
                let factor = if i == j { 1.0 } else { -0.1 } / (1.0 + n as f64);
                class.r_k_per_w.iter_mut().for_each(|r| *r *= factor);
                class.steady_gain_k_per_w *= factor;
                pair.classes.insert((*label).to_owned(), class);
            }
            model.pairs.push(pair);
        }
        model.outputs.push(own);
    }
    model
}

fn whiteness() -> Whiteness {
    Whiteness {
        autocorrelation: (1..=40_u32).map(|lag| 0.02 * f64::from(lag * 7919 % 101) / 101.0 - 0.01).collect(),
        q: 38.0,
        p_value: 0.56,
        inflation: 1.0,
    }
}

pub(crate) fn fit(name: &str, rows: u32, classes: u32) -> FitSeries {
    let mut fit = FitSeries::new(name, "°C");
    for n in 0..rows {
        let truth = 20.0 + 5.0 * libm::sin(f64::from(n) * 2e-3);
        let noise = 0.01 * (f64::from(n.wrapping_mul(2_654_435_761) >> 8) / 16_777_216.0 - 0.5);
        fit.push(f64::from(n) * 0.1, truth + noise, truth, (0.0, 0.0), (n / 900 % classes) as usize);
    }
    fit.whiteness = Some(whiteness());
    fit
}

#[test]
fn the_page_of_a_model_shows_all_its_sides() {
    let svg = figure(&single(8), &[fit("temperature_c_a", 36_000, 1)]).svg();
    assert_sound(&svg);
    for text in [
        "power_w_a → temperature_c_a",
        "Time-constant spectrum",
        "temperature_c_a",
        "Residuals",
        "Autocorrelation of the residuals",
    ] {
        assert!(texts(&svg).contains(&text), "{text}: {:?}", texts(&svg));
    }
    for text in ["Magnitude", "Phase", "Structure function", "band of the record"] {
        assert!(texts(&svg).contains(&text), "{text}");
    }
    assert!(
        svg.contains("95 % of white noise within ±0.0103")
            && svg.contains("p = 0.56 (Ljung–Box)")
            && svg.contains("prbs_first.parquet")
    );
    assert!(svg.contains("steady gain") && svg.contains("rms 2.89 mK"), "{:?}", texts(&svg));
}

#[test]
fn coloured_residuals_are_said_beside_the_intervals() {
    let mut model = single(8);
    model.outputs[0].whiteness = Some(whiteness());
    assert!(!figure(&model, &[]).svg().contains("white residuals"));
    model.outputs[0].whiteness = Some(Whiteness { inflation: 2.5, p_value: 0.0, ..whiteness() });
    assert!(figure(&model, &[]).svg().contains("2.5 times as wide as for white residuals"));
}

#[test]
fn several_outputs_have_charts_of_their_own_up_to_six() {
    let model = network(7, &["all"], 3);
    let fits: Vec<FitSeries> = model.outputs.iter().map(|output| fit(&output.name, 100, 1)).collect();
    let svg = figure(&model, &fits).svg();
    assert_sound(&svg);
    for i in 0..6 {
        assert!(texts(&svg).contains(&format!("Time-constant spectrum of sector{i}").as_str()));
        assert!(texts(&svg).contains(&format!("Phase of sector{i}").as_str()));
    }
    assert!(svg.contains("left out: temperature_c_sector6") && !svg.contains("Time-constant spectrum of sector6"));
    assert_eq!(texts(&svg).iter().filter(|text| **text == "Residuals").count(), 6);
}

#[test]
fn classes_are_named_in_legends_and_on_the_ground_of_the_fit() {
    let mut model = network(1, &["calm", "ahead", "reverse"], 8);
    model.pairs[0].dead_time_samples = 50;
    let svg = figure(&model, &[fit("temperature_c_sector0", 9000, 3)]).svg();
    assert_sound(&svg);
    assert!(texts(&svg).iter().any(|text| text.starts_with("calm: 1")));
    assert!(texts(&svg).iter().filter(|text| **text == "ahead").count() >= 3, "{:?}", texts(&svg));
    assert!(svg.contains("cut where dead time turns it further"));
}

#[test]
fn names_of_grounds_without_room_move_to_the_legend() {
    let chart = |stretch: f64| {
        let names = ["a wind of some name", "b"];
        let chart = Chart::new("c", "K").trace(Trace::line("", vec![(0.0, 0.0), (100.0, 1.0)]));
        let chart = (0..10).fold(chart, |chart, n| {
            let from = f64::from(n) * stretch;
            chart.shading(from, from + stretch, n as usize % 2, names[n as usize % 2])
        });
        let svg = Figure::new("t").row([chart]).svg();
        ["a wind of some name", "b"].map(|name| texts(&svg).iter().filter(|text| **text == name).count())
    };
    // stretches of 47 and of 9 points
    assert_eq!(chart(10.0)[1], 5);
    assert_eq!(chart(2.0), [1, 5]);
}

#[test]
fn wind_is_in_the_responses_and_its_conductance_in_the_caption() {
    let mut model = single(8);
    testing::add_wind(&mut model, "gust", 0.02);
    let svg = figure(&model, &[]).svg();
    assert_sound(&svg);
    assert!(svg.contains("ΔG gust 0.0200 ± 0.0010 W/K") && svg.contains("of class still"), "{:?}", texts(&svg));
    assert!(texts(&svg).contains(&"gust") && texts(&svg).contains(&"still"));
}

#[test]
fn any_model_makes_a_sound_figure() {
    for (order, scale) in [(1, 1.0), (30, 1.0), (8, 1e-6), (8, 1e6), (8, -1.0), (3, 0.0)] {
        let mut model = single(order);
        let class = model.pairs[0].classes.get_mut("all").unwrap();
        class.r_k_per_w.iter_mut().chain(&mut class.se_k_per_w).for_each(|r| *r *= scale);
        (class.steady_gain_k_per_w, class.se_steady_gain_k_per_w) = (class.steady_gain_k_per_w * scale, f64::MAX);
        class.se_k_per_w[0] = 1e12;
        (model.provenance.duration_s, model.provenance.rows) = (0.0, 0);
        model.pairs[0].input = "x".repeat(200);
        model.inputs[0] = model.pairs[0].input.clone();
        model.supported = false;
        model.warnings = vec!["the record is too short for its slowest pole".to_owned(); 9];
        let mut empty = FitSeries::new("nothing", "");
        empty.whiteness = Some(whiteness());
        let mut missing = FitSeries::new("missing", "V");
        (0..3000).for_each(|n| missing.push(f64::from(n), f64::NAN, 1.0, (0.0, 0.0), n as usize % 5));
        assert_sound(&figure(&model, &[empty, missing]).svg());
    }
}

/// With a standard error of 1 K/W of every resistance.
fn uncertain(order: usize) -> Model {
    let mut model = single(order);
    let class = model.pairs[0].classes.get_mut("all").unwrap();
    let triangle = (0..=order).flat_map(|i| (0..=i).map(move |j| if i == j && i < order { 1.0 } else { 0.0 }));
    class.covariance = Some(triangle.collect());
    model
}

fn chart<'f>(figure: &'f Figure, caption: &str) -> &'f Chart {
    figure.charts().find(|chart| chart.caption() == caption).unwrap()
}

#[test]
fn responses_and_impedances_have_bands_where_the_covariance_is_known() {
    for (model, is_known) in [(uncertain(8), true), (single(8), false)] {
        let figure = figure(&model, &[]);
        assert_sound(&figure.svg());
        for caption in ["Magnitude", "Phase", "Thermal impedance"] {
            let bins = &chart(&figure, caption).traces[0].bins;
            assert_eq!(bins.iter().any(|bin| bin.most - bin.least > 1e-3 * bin.mean.abs()), is_known, "{caption}");
        }
        assert_eq!(figure.svg().contains("the model file has no covariance"), !is_known);
    }
    // At 1.96 standard errors of the sum of eight resistances, slower than all of which the step
    // is.
    let figure = figure(&uncertain(8), &[]);
    let last = *chart(&figure, "Thermal impedance").traces[0].bins.last().unwrap();
    assert!(((last.most - last.mean) / (1.96 * 8_f64.sqrt()) - 1.0).abs() < 0.01, "{last:?}");
}

#[test]
fn frequencies_are_in_hertz_and_rates_have_their_time_constants() {
    let svg = figure(&single(8), &[]).svg();
    for text in ["Frequency (Hz)", "Rate (rad/s)", "Time constant (s)", "Thermal impedance (K/W)"] {
        assert!(texts(&svg).contains(&text), "{text}: {:?}", texts(&svg));
    }
}

#[test]
fn resistances_that_others_hide_stand_on_a_logarithmic_axis_with_a_marker_of_their_sign() {
    let mut model = single(8);
    let class = model.pairs[0].classes.get_mut("all").unwrap();
    (class.r_k_per_w[0], class.r_k_per_w[1]) = (5000.0, -4990.0);
    let figure = figure(&model, &[]);
    let chart = chart(&figure, "Time-constant spectrum");
    assert_eq!((chart.y, chart.traces.len()), (Scale::Log, 2));
    assert_eq!(chart.traces[1].points, [(model.pairs[0].mesh_rad_s[1], 4990.0)]);
    assert!(figure.svg().contains("triangles that point down: negative"));
}

#[test]
fn a_model_that_its_record_does_not_support_says_so_quietly() {
    let mut model = single(8);
    (model.supported, model.warnings) = (false, vec!["too short".to_owned(), "too quiet".to_owned()]);
    assert!(figure(&model, &[]).subtitle.ends_with("not supported by its record (2 warnings in the model)"));
}

#[test]
fn a_validation_names_the_record_and_the_model_and_shows_what_was_measured() {
    let fits = [fit("temperature_c_a", 3600, 1)];
    let figure =
        validation_figure(&single(8), &fits, Path::new("records/other-day.parquet"), Path::new("models/sphere.json"));
    assert_eq!(figure.title, "other-day.parquet as predicted by sphere.json");
    assert!(
        figure.subtitle.starts_with("3600 rows") && figure.subtitle.ends_with("identified from prbs_first.parquet")
    );
    let captions: Vec<&str> = figure.charts().map(Chart::caption).collect();
    assert_eq!(captions, ["temperature_c_a", "Residuals", "Autocorrelation of the residuals"]);
}
