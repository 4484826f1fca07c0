//! Laws of response on one record: what was measured, what each law makes of the fitted part and
//! of what comes after, and the residuals of each on one scale.

use diffusive::laws::{LawForecast, LawsReport};

use crate::engine::chart::{Chart, Figure};
use crate::engine::extent::extent;
use crate::engine::trace::Trace;
use crate::engine::words::{brief, shortened};

/// The scale of residuals reaches to so many times the greatest of the best law.
const BEYOND: f64 = 3.0;

/// The figure of a comparison.
pub fn laws_figure(report: &LawsReport) -> Figure {
    let time_s = |row: usize| report.first_time_s + row as f64 * report.sample_period_s;
    let end_s = time_s(report.rows);
    let unit = report.unit.as_deref().unwrap_or_default();
    let line = |label: &str, value: &dyn Fn(usize) -> f64| {
        Trace::line(label, (0..report.rows).map(|row| (time_s(row), value(row))).collect())
    };
    let parts = |chart: Chart, labels: [&str; 2]| {
        let fitted = chart.shading(report.first_time_s, report.until_s, 7, labels[0]);
        fitted.shading(report.until_s, end_s, 0, labels[1])
    };
    let laws = report.laws.iter().enumerate();
    let lines = laws.clone().map(|(pen, law)| line(&law.law, &|row| law.predicted[row]).colour(pen).width(0.7));
    let output_unit = recording::stated_unit(&report.output).unwrap_or_default();
    // The unit stands beside the axis, whatever brackets the name has.
    let name = report.output.split(['(', '[']).next().map_or("", str::trim_end);
    let output = Chart::new(shortened(name, 8.0, 200.0), output_unit)
        .height(50.0)
        .trace(line("measured", &|row| report.measured[row]).colour(7).width(1.6))
        .traces(lines);
    let residual = |law: &LawForecast, row: usize| report.measured[row] - law.predicted[row];
    let greatest = |law: &LawForecast| {
        let sizes = (0..report.rows).map(|row| residual(law, row).abs()).filter(|size| size.is_finite());
        sizes.fold(0.0, f64::max)
    };
    let best = report.laws.iter().find(|law| law.law == report.best).map_or(f64::INFINITY, greatest);
    let all = extent(report.laws.iter().map(greatest)).map_or(1.0, |(_, most)| most);
    let reach = all.min(BEYOND * best);
    let last = report.laws.len() - 1;
    let residuals = laws.map(|(pen, law)| {
        let cut = (greatest(law) > reach).then(|| format!("cut, the greatest is {}", brief(greatest(law))));
        let rms = format!("rms {} fitted, {} held out", brief(law.fitted.rmse), brief(law.held_out.rmse));
        let chart = Chart::new(format!("Residuals, {}", law.law), unit)
            .y_title("Residual")
            .height(14.0)
            .note(rms)
            .notes(cut)
            .trace(line("", &|row| residual(law, row)).colour(pen).width(0.5));
        let chart = Chart { x_labels: pen == last, ..chart };
        parts(if reach > 0.0 { chart.range(-reach, reach) } else { chart }, [""; 2])
    });
    Figure::new(format!("{} → {}", report.input, report.output))
        .subtitle(report.verdict())
        .row([parts(Chart { x_labels: false, ..output }, ["fitted", "held out"])])
        .stack(residuals)
}
