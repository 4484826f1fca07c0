//! The page of the benchmark, `wind.md`: the bars with what was measured, and tables by bandwidth.

use super::directions::SETTLE_S;
use super::findings::findings;
use super::measure::MeasuredSphere;
use super::sphere::WindMode;
use super::steps::Way;
use anemometry::calibrate::report::ConductanceNoise;
use recording::template::fill;

/// The page over some spheres.
///
/// # Errors
/// If the templates of the page do not go with its values.
pub fn page(all: &[MeasuredSphere]) -> anyhow::Result<String> {
    let spheres = all.iter().map(section).collect::<Result<String, _>>()?;
    fill(include_str!("pages/wind.md"), &[("settle_s", &SETTLE_S.to_string()), ("spheres", &spheres)])
}

fn section(of: &MeasuredSphere) -> anyhow::Result<String> {
    let bands = of.turbulence.first().map_or(&[][..], |first| &first.bands);
    let headings: String = bands.iter().map(|band| format!(" {} to {} Hz |", band.from_hz, band.to_hz)).collect();
    let noise =
        |write: &dyn Fn(&ConductanceNoise) -> String| of.noise_w_k.iter().map(write).collect::<Vec<_>>().join(", ");
    let values: [(&str, &str); 12] = [
        ("title", of.sphere.title),
        ("made_from", &of.made_from),
        (
            "findings",
            &rows(findings(of).findings.iter().map(|finding| {
                let met = if finding.met == Some(true) { "met" } else { "**not met**" };
                let beside = match finding.published.as_str() {
                    "" => String::new(),
                    beside => format!(" ({beside})"),
                };
                format!("{} | {}{beside} | {}: {met}", finding.what, finding.ours, finding.bar)
            })),
        ),
        ("direction_columns", if of.sphere.whole { " direction rms | worst | linear inverse rms |" } else { "" }),
        ("direction_rule", if of.sphere.whole { "---|---|---|" } else { "" }),
        (
            "directions",
            &rows(of.directions.iter().map(|row| {
                let errors = &row.errors;
                let degrees = |deg: Option<f64>| deg.map_or("–".to_owned(), |deg| format!("{deg:.2}"));
                let share = |share: Option<f64>| share.map_or("–".to_owned(), |share| in_percent(share, 2));
                let speed = [errors.speed.rms(), errors.speed.mean(), errors.speed.worst()].map(share);
                let direction = [errors.direction_deg.rms(), errors.direction_deg.worst(), errors.linear_deg.rms()];
                let cells = if of.sphere.whole { [speed, direction.map(degrees)].concat() } else { speed.to_vec() };
                format!("{} | {}", in_hz(row.mode), cells.join(" | "))
            })),
        ),
        (
            "steps",
            &rows(of.steps.iter().map(|steps| {
                let both = |of: &dyn Fn(&Way) -> String| steps.ways.iter().map(of).collect::<Vec<_>>().join(", ");
                format!(
                    "{} | {} | {} | {} | {}",
                    in_hz(steps.mode),
                    both(&|way| format!("{:.2}", way.mean_response_s)),
                    both(&|way| format!("{:.2}", way.single_response_s)),
                    both(&|way| in_percent(way.noise, 2)),
                    both(&|way| in_percent(way.outside, 1))
                )
            })),
        ),
        ("bands", &headings),
        ("rule", &"---|".repeat(bands.len())),
        (
            "turbulence",
            &rows(of.turbulence.iter().map(|row| {
                let bands = row.bands.iter().map(|band| format!("{:.3}, {:.3}", band.coherence, band.gain));
                format!("{} | {}", in_hz(row.mode), bands.collect::<Vec<_>>().join(" | "))
            })),
        ),
        ("noise_hz", &noise(&|of| of.bandwidth_hz.to_string())),
        ("noise", &noise(&|of| format!("{:.1}", 1e6 * of.sd_w_k))),
    ];
    fill(include_str!("pages/sphere.md"), &values)
}

/// A bandwidth for a column in Hz.
fn in_hz(mode: WindMode) -> String {
    format!("{}{}", mode.bandwidth_hz, if mode.fixed { ", fixed" } else { "" })
}

/// A share for a column in per cent.
fn in_percent(share: f64, digits: usize) -> String {
    format!("{:.digits$}", 100.0 * share)
}

/// Rows of a table, without the end of the last line.
fn rows(rows: impl Iterator<Item = String>) -> String {
    rows.map(|row| format!("| {row} |")).collect::<Vec<_>>().join("\n")
}
