//! Demands of a journal on every figure of the crate: type of 6 pt at any width, nothing beyond the
//! page, axis titles with units, two labels an axis.

use crate::engine::axis::Axis;
use crate::engine::chart::{Chart, ChartFrame, Figure};
use crate::engine::words::Weight;
use crate::picture::{PictureFormat, PictureWidth};
use crate::{closed_loop, model, run, tests};
use diffusive::model::testing;
use diffusive::predict::analysis_report::{AnalysisReport, AnalysisRequest};
use resvg::usvg::roxmltree::{Document, Node};

const WIDTHS_MM: [f64; 4] = [60.0, 88.0, 180.0, 400.0];
const LEAST_TYPE_PT: f64 = 6.0;

/// One figure of each kind.
fn figures() -> Vec<(&'static str, Figure)> {
    let long = "A title that is much too long for a single column of a journal, and for two columns as well";
    let experiment = "[drives]\nsector1 = { temperature_c = -22.5 }\ncore1 = \"passive\"\n";
    let recorded = tests::noisy(3000, &[("title", long), ("experiment", experiment)]);
    let estimates = tests::estimates(&tests::SECTORS, "", |n| if n == 77 { 8 } else { 0 });
    let mut both = estimates.clone();
    let temperature = recording::ColumnValues::Numbers(vec![-23.0; 400]);
    both.columns.push(recording::RecordingColumn { name: "temperature_c_sector1".into(), values: temperature });
    let network = model::tests::network(7, &["calm", "ahead", "reverse"], 8);
    let fits: Vec<_> = network.outputs.iter().map(|output| model::tests::fit(&output.name, 9000, 3)).collect();
    let mut windy = model::tests::single(8);
    testing::add_wind(&mut windy, "gust", 0.02);
    let request = AnalysisRequest {
        target_k: Some(10.0),
        power_low_w: Some(0.0),
        power_high_w: Some(2.0),
        sample_period_s: Some(0.1),
        ..AnalysisRequest::default()
    };
    let analysis = AnalysisReport::new(&windy, &request).unwrap();
    let rows: Vec<_> = (0..500).map(|n| (f64::from(n), 0.01, 0.011, n % 50 > 5)).collect();
    let winds = [(0.0, 250.0, 0, "calm".to_owned()), (250.0, 500.0, 1, "ahead".to_owned())];
    let celsius = vec![-23.0; 5000];
    let predicted = closed_loop::PredictedCharts {
        name: "sector1",
        powers: &rows,
        temperatures_c: [Some(&celsius), Some(&celsius)],
        target_c: &celsius,
    };
    vec![
        ("run", run::figure(&recorded).unwrap()),
        ("wind", run::figure(&estimates).unwrap()),
        ("run with wind", run::figure(&both).unwrap()),
        ("model", model::figure(&network, &fits)),
        ("small model", model::figure(&windy, &[model::tests::fit("temperature_c_a", 9000, 1)])),
        ("closed loop", closed_loop::analysis_figure(&analysis.pair, &analysis.analysis, &analysis.changes)),
        ("prediction", closed_loop::prediction_figure(long, "recorded", &[predicted], 0.1, &winds)),
    ]
}

fn number(node: Node<'_, '_>, name: &str) -> f64 {
    node.attribute(name).unwrap().trim_end_matches("mm").parse().unwrap()
}

/// Ends of a text across and along the page, in units of the view box.
fn extent(text: Node<'_, '_>) -> [(f64, f64); 2] {
    let weight = if text.attribute("font-weight").is_some() { Weight::Bold } else { Weight::Regular };
    let size = number(text, "font-size");
    let wide = weight.width(text.text().unwrap_or_default(), size);
    let before = match text.attribute("text-anchor") {
        Some("middle") => wide / 2.0,
        Some("end") => wide,
        _ => 0.0,
    };
    let (x, y) = (number(text, "x"), number(text, "y"));
    if text.attribute("transform").is_some() {
        return [(x - size, x), (y + before - wide, y + before)];
    }
    [(x - before, x - before + wide), (y - size, y)]
}

#[test]
fn type_is_legible_and_stays_on_the_page_at_every_width() {
    for (name, figure) in figures() {
        for width_mm in WIDTHS_MM {
            let svg = figure.clone().at(PictureWidth::mm(width_mm).unwrap()).svg();
            let document = Document::parse(&svg).unwrap();
            let root = document.root_element();
            assert_eq!(number(root, "width"), width_mm, "{name}");
            let view: Vec<f64> =
                root.attribute("viewBox").unwrap().split(' ').map(|side| side.parse().unwrap()).collect();
            let points = width_mm / 25.4 * 72.0 / view[2];
            assert!((number(root, "height") / view[3] - width_mm / view[2]).abs() < 1e-3, "{name}");
            for text in document.descendants().filter(|node| node.has_tag_name("text")) {
                let what = || format!("{name}, {width_mm} mm: {:?}", text.text());
                assert!(number(text, "font-size") * points >= LEAST_TYPE_PT, "{}", what());
                for ((low, high), end) in extent(text).into_iter().zip(&view[2..]) {
                    assert!(low >= -0.01 && high <= end + 0.01, "{}: {low} {high} of {end}", what());
                }
            }
        }
    }
}

#[test]
fn every_axis_has_its_quantity_its_unit_and_two_labels() {
    for (name, figure) in figures() {
        let svg = figure.svg();
        let charts: Vec<&Chart> = figure.charts().filter(|chart| chart.frame == ChartFrame::Axes).collect();
        for (i, chart) in charts.iter().enumerate() {
            let what = format!("{name}: {}", chart.caption());
            assert!(!chart.y_name().is_empty(), "{what}");
            let labels = chart.y_axis().axis.ticks();
            assert!(labels.len() > 1, "{what}: {labels:?}");
            // Or else one below it shows the axis for both.
            let below = figure.charts().skip_while(|other| !std::ptr::eq(*other, *chart));
            let labelled = below.filter(|other| other.x_unit == chart.x_unit).find(|other| other.x_labels).unwrap();
            let quantity = labelled.x_name();
            assert!(!quantity.is_empty() && svg.contains(&format!(">{quantity}")), "{what} {i}");
        }
    }
}

#[test]
fn a_range_of_any_kind_has_two_labels() {
    for span in [1e-6, 0.013, 0.7, 1.0, 1.9, 3.3, 9.5, 100.0] {
        for low in [0.0, -0.31, 0.49, 17.2] {
            for ticks in 1..6 {
                for axis in [Axis::exactly(low, low + span, ticks), Axis::degrees(low, low + span, ticks)] {
                    assert!(axis.ticks().len() > 1, "{axis:?}");
                }
            }
        }
    }
}

#[test]
fn pdf_and_png_have_the_size_and_the_letters_of_the_svg() {
    let chart = Chart::new("Temperature", "°C").trace(crate::Trace::line("ξ → 10⁻³ ±", vec![(0.0, 1.0), (1.0, 2.0)]));
    let figure = Figure::new("“Böe” × Σ").row([chart]).at(PictureWidth::mm(88.0).unwrap());
    let png = PictureFormat::Png.encode(figure.svg()).unwrap();
    let image = resvg::tiny_skia::Pixmap::decode_png(&png).unwrap();
    // 88 mm at 300 dots an inch.
    assert_eq!(image.width(), 1039);
    // Letters are there: without a face, nothing of the title would be dark.
    let dark = |row: u32| (0..300).any(|x| image.pixel(x, row).is_some_and(|pixel| pixel.red() < 80));
    assert!((17..58).any(dark));
    let pdf = PictureFormat::Pdf.encode(figure.svg()).unwrap();
    let text = String::from_utf8_lossy(&pdf);
    // 88 mm are 249.45 pt; text that can be selected comes with a font and its letters.
    assert!(text.starts_with("%PDF") && text.contains("249.4") && text.contains("DejaVuSans"));
    assert!(text.contains("/ToUnicode"));
}
