//! What a chart's series look like, and what range they need: lines, stems, dots and error bars.

use plotters::style::{Color as _, RGBColor};

use super::super::axis::{Axis, Scale};
use super::super::draw::{CURVE, DrawError, Panel};
use super::chart::{Chart, Series, Style};
use super::columns;
use super::paint::Laid;

/// Above it, a line's points are reduced to about one a pixel.
const POINTS: usize = 1500;
/// Error bars may widen the range of the values by so much on either side, and are cut beyond it.
const REACH: f64 = 1.0;
/// Between the stems of several series at one place, pixels.
const DODGE: f64 = 7.0;
/// Room for the labels of stretches at the top of a chart, pixels.
const HEADROOM: f64 = 18.0;

impl Laid<'_> {
    /// How far the stems of several series stand apart: not at all if no two of them have one place, as on a mesh.
    pub(super) fn dodge(&self, panel: &Panel) -> f64 {
        let stems: Vec<&Series> = self.chart.series.iter().filter(|series| series.style == Style::Stems).collect();
        let mut all: Vec<u64> =
            stems.iter().flat_map(|series| series.points.iter().map(|point| point.0.to_bits())).collect();
        all.sort_unstable();
        if all.windows(2).all(|pair| pair[0] != pair[1]) {
            return 0.0;
        }
        let mut closest = f64::INFINITY;
        for series in &stems {
            let mut places: Vec<f64> = series.points.iter().map(|point| panel.x(self.x.shown(point.0))).collect();
            places.sort_by(f64::total_cmp);
            closest = places.windows(2).map(|pair| pair[1] - pair[0]).fold(closest, f64::min);
        }
        (closest / (stems.len() as f64 + 1.0)).min(DODGE)
    }

    pub(super) fn series<'a>(
        &self,
        panel: &Panel<'_, 'a>,
        series: &Series,
        colour: RGBColor,
        shift: f64,
    ) -> Result<(), DrawError<'a>> {
        let width = series.width.unwrap_or(CURVE);
        let shown = |&(x, y): &(f64, f64)| (self.x.shown(x), self.y.shown(y));
        if !series.bins.is_empty() {
            return columns::draw(panel, &columns::shown(&series.bins, &self.x, &self.y), colour, width);
        }
        let bottom = panel.rect.bottom;
        let zero = if self.chart.y == Scale::Linear {
            panel.y(self.y.shown(0.0).clamp(panel.value.low, panel.value.high))
        } else {
            bottom
        };
        for (i, point) in series.points.iter().enumerate() {
            let Some(&error) = series.errors.get(i) else { break };
            let (x, _) = shown(point);
            if x.is_finite() && error.is_finite() && error > 0.0 {
                let end = |value: f64| {
                    let value = self.y.shown(value);
                    if value.is_nan() { bottom } else { panel.y(value.clamp(panel.value.low, panel.value.high)) }
                };
                let (x, low, high) = (panel.x(x) + shift, end(point.1 - error), end(point.1 + error));
                panel.figure.line(&[(x, low), (x, high)], colour.mix(0.75), 1.2)?;
                for y in [low, high].into_iter().filter(|y| *y > panel.rect.top + 0.5 && *y < bottom - 0.5) {
                    panel.figure.line(&[(x - 3.0, y), (x + 3.0, y)], colour.mix(0.75), 1.2)?;
                }
            }
        }
        match series.style {
            Style::Line if series.points.len() > POINTS => {
                let points = series.points.iter().map(shown);
                let bins = columns::reduced(points, &panel.time, panel.rect.right - panel.rect.left);
                columns::draw(panel, &bins, colour, width)
            }
            Style::Line => {
                let points = series.points.iter().map(shown).map(|(x, y)| (x, if x.is_nan() { x } else { y }));
                panel.curve(points, colour, width)
            }
            Style::Dashed => {
                let points: Vec<_> = if series.points.len() > POINTS {
                    let bins = columns::reduced(
                        series.points.iter().map(shown),
                        &panel.time,
                        panel.rect.right - panel.rect.left,
                    );
                    bins.iter().map(|bin| (bin.middle_s(), bin.mean)).collect()
                } else {
                    series.points.iter().map(shown).collect()
                };
                let good = |point: &(f64, f64)| point.0.is_finite() && panel.value.contains(point.1);
                for stretch in points.chunk_by(|a, b| good(a) == good(b)).filter(|stretch| good(&stretch[0])) {
                    let line: Vec<_> = stretch.iter().map(|&(x, y)| (panel.x(x), panel.y(y))).collect();
                    panel.figure.dashed(&line, colour.to_rgba(), 1.6)?;
                }
                Ok(())
            }
            Style::Points | Style::Stems => {
                for (x, y) in series.points.iter().map(shown).filter(|(x, y)| x.is_finite() && y.is_finite()) {
                    let at = (panel.x(x) + shift, panel.y(y));
                    if series.style == Style::Stems {
                        panel.figure.line(&[(at.0, zero), at], colour.to_rgba(), 1.8)?;
                    }
                    panel.figure.dot(at, if series.points.len() > 100 { 1.8 } else { 3.2 }, colour)?;
                }
                Ok(())
            }
        }
    }
}

/// The values that the y axis must hold, and whether error bars reach beyond.
pub fn reach(chart: &Chart) -> (Vec<f64>, bool) {
    if let Some((low, high)) = chart.range {
        return (vec![low, high], false);
    }
    let good = |value: &f64| Axis::shows(chart.y, *value);
    let mut values: Vec<f64> =
        chart.series.iter().flat_map(Series::values).chain(chart.limits.iter().copied()).collect();
    if chart.y == Scale::Linear && chart.series.iter().any(|series| series.style == Style::Stems) {
        values.push(0.0);
    }
    values.retain(good);
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if chart.spans.iter().any(|span| !span.label.is_empty()) && high > low {
        let share = HEADROOM / (chart.height - HEADROOM).max(HEADROOM);
        values.push(match chart.y {
            Scale::Linear => high + share * (high - low),
            Scale::Log => high * (high / low).powf(share),
        });
    }
    let bounds = match chart.y {
        Scale::Linear if high > low => (low - REACH * (high - low), high + REACH * (high - low)),
        Scale::Linear => (f64::NEG_INFINITY, f64::INFINITY),
        Scale::Log => (low / 10.0, high * 10.0),
    };
    let bars = chart.series.iter().flat_map(|series| series.points.iter().zip(&series.errors));
    let ends: Vec<f64> = bars.flat_map(|(point, error)| [point.1 - error, point.1 + error]).filter(good).collect();
    let cut = ends.iter().any(|end| *end < bounds.0 || *end > bounds.1);
    values.extend(ends.iter().map(|end| end.clamp(bounds.0, bounds.1)).filter(|end| end.is_finite()));
    (values, cut)
}

impl Series {
    pub(super) fn is_empty(&self) -> bool {
        self.points.is_empty() && self.bins.is_empty()
    }

    pub(super) fn places(&self) -> impl Iterator<Item = f64> {
        let points = self.points.iter().map(|point| point.0);
        points.chain(self.bins.iter().flat_map(|bin| [bin.from_s, bin.to_s]))
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        let points = self.points.iter().map(|point| point.1);
        points.chain(self.bins.iter().flat_map(|bin| [bin.least, bin.most]))
    }

    /// Values that are there but that a logarithmic axis cannot show.
    pub(super) fn lost(&self, chart: &Chart) -> usize {
        let hidden = |scale, value: f64| value.is_finite() && !Axis::shows(scale, value);
        let points = self.points.iter().filter(|point| hidden(chart.x, point.0) || hidden(chart.y, point.1)).count();
        points + self.bins.iter().filter(|bin| hidden(chart.y, bin.mean)).count()
    }
}
