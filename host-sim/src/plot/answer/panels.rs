//! The panels of answers.

use plotters::style::{Color as _, RGBColor};

use super::super::axis::Axis;
use super::super::content::Curve;
use super::super::draw::{ALARM, ANSWER, Align, CURVE, DrawError, Figure, INK, Panel, QUIET, Rect, TRUTH, shade};
use super::super::reduce::Bin;
use super::{Answer, Part, Quantity, angle};

/// Width of a truth behind an answer, pixels.
const WIDE: f64 = 4.5;
/// Share of the bins whose values an axis may leave out at either end: transients of the start.
const LEFT_OUT: f64 = 0.005;

/// A doubt of a single answer among many is drawn as high as one of this share.
const LEAST_SHARE: f64 = 0.2;

type Drawn<'a> = Result<(), DrawError<'a>>;

/// Draws a panel into its place.
pub fn draw<'a>(figure: &Figure<'a>, answer: &Answer, part: Part, rect: Rect, time: &Axis) -> Drawn<'a> {
    let panel = |value: Axis| Panel { figure, rect, time: time.clone(), value };
    match part {
        Part::Speed => {
            let panel = panel(speed_axis(&answer.speed));
            panel.grid()?;
            let unit = "m/s; shaded: ± one standard error, paler: from least to greatest";
            quantity(&panel, &answer.speed, "Wind speed", unit)
        }
        Part::Azimuth => {
            let Some(azimuth) = &answer.azimuth else { return Ok(()) };
            let panel = panel(azimuth_axis(azimuth));
            panel.grid()?;
            quantity(&panel, &turned(azimuth, &panel.value), "Azimuth", "° from x towards y, where the wind goes to")
        }
        Part::Elevation => {
            let Some(elevation) = &answer.elevation else { return Ok(()) };
            let panel = panel(narrow_axis(elevation, -90.0, 90.0, 4));
            panel.grid()?;
            quantity(&panel, elevation, "Elevation", "° above the xy plane")
        }
        Part::Angle => {
            let Some(angle) = &answer.angle else { return Ok(()) };
            let panel = panel(narrow_axis(angle, 0.0, 180.0, 5));
            panel.grid()?;
            quantity(&panel, angle, "Angle to the head's axis", "°; 0 goes to where the first part looks")
        }
        Part::Conductances => conductances(&panel, answer),
        Part::Gas => {
            let Some((gas, truth)) = &answer.gas else { return Ok(()) };
            let values = gas.bins.iter().chain(truth.iter().flatten()).map(|bin| bin.mean);
            let panel = panel(Axis::around(values, 3));
            panel.grid()?;
            let legend = [("answer".to_owned(), INK), ("true".to_owned(), TRUTH)];
            panel.caption("Gas", "°C, as the anemometer knows it", &legend[..1 + usize::from(truth.is_some())])?;
            if let Some(truth) = truth {
                line(&panel, truth, TRUTH, WIDE)?;
            }
            line(&panel, &gas.bins, INK, CURVE)
        }
        Part::Doubts => doubts(&panel(Axis::exactly(0.0, 1.0, 1)), answer),
    }
}

/// Answers over the true wind of a run: first what lies beneath.
pub fn drawn_over<'a>(panel: &Panel<'_, 'a>, truth: &[Curve], answers: &[Curve]) -> Drawn<'a> {
    for curve in truth {
        line(panel, &curve.bins, pale(curve.colour), WIDE)?;
    }
    for curve in answers {
        panel.band(&curve.bins, curve.colour.mix(0.15))?;
    }
    for curve in answers {
        line(panel, &curve.bins, curve.colour, if curve.label == "speed" { 1.6 } else { 1.1 })?;
    }
    Ok(())
}

fn pale(colour: RGBColor) -> RGBColor {
    shade(shade(colour, 2), 2)
}

fn line<'a>(panel: &Panel<'_, 'a>, bins: &[Bin], colour: RGBColor, width: f64) -> Drawn<'a> {
    panel.curve(bins.iter().map(|bin| (bin.middle_s(), bin.mean)), colour, width)
}

/// An answer over its truth. Azimuths have been [`turned`]: they are broken where they run out of one end of the axis.
fn quantity<'a>(panel: &Panel<'_, 'a>, of: &Quantity, caption: &str, unit: &str) -> Drawn<'a> {
    let legend = [("answer".to_owned(), ANSWER), ("true wind".to_owned(), TRUTH)];
    panel.caption(caption, unit, &legend[..1 + usize::from(of.truth.is_some())])?;
    let truths = || of.truth.iter().flat_map(|truth| truth.chunk_by(together));
    for stretch in truths() {
        panel.band(stretch, TRUTH.mix(0.35))?;
    }
    for stretch in of.answer.chunk_by(together) {
        panel.band(stretch, ANSWER.mix(0.13))?;
    }
    for stretch in spread(of).chunk_by(together) {
        panel.band(stretch, ANSWER.mix(0.3))?;
    }
    for stretch in truths() {
        line(panel, stretch, TRUTH, WIDE)?;
    }
    for stretch in of.answer.chunk_by(together) {
        line(panel, stretch, ANSWER, CURVE)?;
    }
    Ok(())
}

/// Nothing but an azimuth changes by more than half a turn from bin to bin.
fn together(a: &Bin, b: &Bin) -> bool {
    let change = (a.mean - b.mean).abs();
    !(change.is_finite() && change > 180.0)
}

/// One standard error either way of the mean.
fn spread(of: &Quantity) -> Vec<Bin> {
    let around = |(bin, error): (&Bin, &f64)| {
        let (least, most) = if error.is_finite() { (bin.mean - error, bin.mean + error) } else { (bin.mean, bin.mean) };
        Bin { least, most, ..*bin }
    };
    of.answer.iter().zip(&of.error).map(around).collect()
}

fn turned(of: &Quantity, axis: &Axis) -> Quantity {
    let turn = |bins: &[Bin]| angle::turned(bins, axis.low);
    Quantity { answer: turn(&of.answer), error: of.error.clone(), truth: of.truth.as_deref().map(turn) }
}

/// Least and greatest value but for a few.
fn most_of(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let left_out = (values.len() as f64 * LEFT_OUT) as usize;
    Some((*values.get(left_out)?, *values.get(values.len() - 1 - left_out)?))
}

/// Room for nearly all answers and for all of the truth; from zero, unless the speed hardly changes.
fn speed_axis(speed: &Quantity) -> Axis {
    let (low, high) = most_of(spread(speed).iter().flat_map(|bin| [bin.least, bin.most])).unwrap_or((0.0, 0.0));
    let truths = || speed.truth.iter().flatten().map(|bin| bin.mean).filter(|mean| mean.is_finite());
    let (low, high) = (truths().fold(low, f64::min), truths().fold(high, f64::max));
    let low = if low < 0.7 * high { 0.0 } else { low };
    Axis::around([low.max(0.0), high], 5)
}

fn azimuth_axis(azimuth: &Quantity) -> Axis {
    let bins = [azimuth.answer.as_slice(), azimuth.truth.as_deref().unwrap_or_default()];
    angle::axis(&bins, 0.6 * typical_error(azimuth), 5)
}

/// An axis for nearly all of an angle that has ends, at least a few degrees long.
fn narrow_axis(of: &Quantity, least: f64, most: f64, ticks: usize) -> Axis {
    let errors = spread(of);
    let told = most_of(errors.iter().flat_map(|bin| [bin.least, bin.most]));
    let truths = of.truth.iter().flatten().map(|bin| bin.mean).filter(|mean| mean.is_finite());
    let ends = told.into_iter().chain(truths.map(|mean| (mean, mean)));
    let Some((low, high)) = ends.reduce(|all, of| (all.0.min(of.0), all.1.max(of.1))) else {
        return Axis::degrees(least, most, ticks);
    };
    let air = (0.05 * (high - low)).max(angle::LEAST_RANGE_DEG / 2.0 - (high - low) / 2.0);
    Axis::degrees((low - air).max(least), (high + air).min(most), ticks)
}

fn typical_error(of: &Quantity) -> f64 {
    let mut errors: Vec<f64> = of.error.iter().copied().filter(|error| error.is_finite()).collect();
    errors.sort_by(f64::total_cmp);
    errors.get(errors.len() / 2).copied().unwrap_or(0.0).min(60.0)
}

fn conductances<'f, 'a>(panel: &impl Fn(Axis) -> Panel<'f, 'a>, answer: &Answer) -> Drawn<'a>
where
    'a: 'f,
{
    let in_mw = |curve: &Curve| {
        let of = |bin: &Bin| Bin { least: 1e3 * bin.least, most: 1e3 * bin.most, mean: 1e3 * bin.mean, ..*bin };
        curve.bins.iter().map(of).collect::<Vec<_>>()
    };
    let scaled = |curves: &[Curve]| curves.iter().map(|curve| (curve.colour, in_mw(curve))).collect::<Vec<_>>();
    let (told, raw) = (scaled(&answer.conductances), scaled(&answer.raw));
    // Raw ones begin at many times what they end at, and would hide the others.
    let values = told.iter().flat_map(|(_, bins)| bins).map(|bin| bin.mean);
    let (low, high) = most_of(values).unwrap_or((0.0, 1.0));
    let panel = panel(Axis::around([low.min(0.0), 1.1 * high], 5));
    panel.grid()?;
    let legend: Vec<_> = answer.conductances.iter().map(|curve| (curve.label.clone(), curve.colour)).collect();
    panel.caption("Conductance to the gas", "mW/K; pale: what the power alone would say", &legend)?;
    for (colour, bins) in &raw {
        line(&panel, bins, pale(*colour), WIDE)?;
    }
    for (colour, bins) in &told {
        panel.band(bins, colour.mix(0.15))?;
    }
    for (colour, bins) in &told {
        line(&panel, bins, *colour, CURVE)?;
    }
    Ok(())
}

/// A row a doubt, as high as the share of answers that have it, and never too low to be seen.
fn doubts<'a>(panel: &Panel<'_, 'a>, answer: &Answer) -> Drawn<'a> {
    let rect = panel.rect;
    panel.caption("Doubts", "share of the answers that have them", &[])?;
    let middle = |rect: Rect| f64::midpoint(rect.top, rect.bottom);
    if answer.doubts.is_empty() {
        panel.figure.rectangle(rect, QUIET.mix(0.08), true)?;
        let at = (f64::midpoint(rect.left, rect.right), middle(rect));
        return panel.figure.text("none", at, 12.0, QUIET, Align::Middle, false);
    }
    let height = (rect.bottom - rect.top) / answer.doubts.len() as f64;
    for (i, (name, bins)) in answer.doubts.iter().enumerate() {
        let top = rect.top + height * i as f64;
        let row = Rect { top: top + 2.0, bottom: top + height - 2.0, ..rect };
        let colour = if *name == "failed" { ALARM } else { QUIET };
        panel.figure.text(name, (rect.left - 8.0, middle(row)), 12.0, QUIET, Align::Right, false)?;
        panel.figure.rectangle(row, colour.mix(0.1), true)?;
        let seen = |bin: &Bin| Bin { mean: if bin.most > 0.0 { bin.mean.max(LEAST_SHARE) } else { bin.mean }, ..*bin };
        let bins: Vec<Bin> = bins.iter().map(seen).collect();
        Panel { figure: panel.figure, rect: row, time: panel.time.clone(), value: panel.value.clone() }
            .bars(&bins, colour)?;
    }
    Ok(())
}
