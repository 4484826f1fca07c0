use super::*;

fn texts(svg: &str) -> Vec<&str> {
    svg.lines().filter(|line| !line.starts_with('<')).collect()
}

/// What a picture must not hold, whatever the data.
fn assert_sound(svg: &str) {
    assert!(svg.starts_with("<svg width=\"1200\""));
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{:?}", texts(svg));
}

#[test]
fn a_figure_has_its_titles_captions_units_and_legends() {
    let points: Vec<(f64, f64)> = (1..50).map(|n| (f64::from(n), 1.0 / f64::from(n))).collect();
    let chart = |caption: &str| {
        Chart::new(caption, "K/W")
            .x(Scale::Log, "rad/s")
            .y(Scale::Log)
            .series(Series::line("exact <&>", points.clone()))
    };
    let svg =
        Lines::new("Title").subtitle("words").row([chart("one"), chart("two")]).row([chart("three")]).svg().unwrap();
    assert_sound(&svg);
    for text in ["Title", "words", "one", "two", "three"] {
        assert!(texts(&svg).contains(&text), "{text}: {:?}", texts(&svg));
    }
    assert_eq!(svg.matches("exact &lt;&amp;&gt;").count(), 3);
    assert_eq!(texts(&svg).iter().filter(|text| **text == "rad/s").count(), 3);
    assert!(texts(&svg).contains(&"0.1") && texts(&svg).contains(&"10"));
}

#[test]
fn what_a_logarithmic_axis_cannot_show_is_counted_in_the_caption() {
    let points = vec![(0.0, 1.0), (1.0, -1.0), (2.0, 0.0), (3.0, 5.0), (4.0, f64::NAN)];
    let chart = |x, y| Chart::new("c", "K").x(x, "s").y(y).series(Series::points("p", points.clone()));
    let of = |x, y| Lines::new("").row([chart(x, y)]).svg().unwrap();
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
        for (x, y) in [(Scale::Linear, Scale::Linear), (Scale::Log, Scale::Log), (Scale::Linear, Scale::Log)] {
            let chart = Chart::new("c", "K")
                .x(x, "s")
                .y(y)
                .time_constants()
                .limit(0.5)
                .span(0.0, 2.0, 1, "a stretch")
                .series(Series::line("line", points.clone()))
                .series(Series::dashed("dashed", points.clone()))
                .series(Series::stems("stems", points.clone()).errors(errors.clone()))
                .series(Series::points("points", points.clone()));
            let svg = Lines::new("t").row([chart]).svg().unwrap();
            assert_sound(&svg);
        }
    }
}

#[test]
fn two_million_points_stay_a_small_picture_in_which_one_stands_out() {
    let points: Vec<(f64, f64)> = (0..2_000_000_u32)
        .map(|n| (f64::from(n) * 5e-4, if n == 1_234_567 { 3.0 } else { f64::from(n % 5) * 0.01 }))
        .collect();
    let svg = Lines::new("t").row([Chart::new("c", "K").series(Series::line("", points))]).svg().unwrap();
    assert!(svg.len() < 200_000, "{}", svg.len());
    assert!(texts(&svg).contains(&"3.0"), "{:?}", texts(&svg));
}

#[test]
fn error_bars_widen_the_axis_until_they_would_hide_the_values() {
    let chart = |error: f64| {
        let points = vec![(1.0, 1.0), (2.0, 2.0)];
        Lines::new("")
            .row([Chart::new("c", "K").series(Series::stems("", points).errors(vec![error; 2]))])
            .svg()
            .unwrap()
    };
    assert!(!chart(0.5).contains("edge"));
    let wide = chart(1e6);
    assert!(wide.contains("error bars end at the edge") && texts(&wide).contains(&"2"), "{:?}", texts(&wide));
}
