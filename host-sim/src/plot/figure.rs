//! The picture of a run: which panels there are, and what is in them.

use plotters::style::{Color as _, RGBColor, WHITE};

use super::PlotError;
use super::answer::{self, Part};
use super::axis::Axis;
use super::content::{BINS, Content, Curve};
use super::draw::{
    ALARM, Align, CURVE, DrawError, Figure, INK, Panel, QUIET, Rect, in_pixels, legend_height, text_width,
};
use super::reduce::{bins, reach};
use super::set_points::SetPoint;
use crate::recording::Recording;

const WIDTH: f64 = 1200.0;
/// Room to the left of the panels; longer names of elements take more.
const LEFT: f64 = 70.0;
const RIGHT: f64 = 32.0;
/// Room above a panel for its caption.
const CAPTION: f64 = 34.0;
/// Dashed lines of set-points; more of them would be all that is seen.
const MOST_SET_POINTS: usize = 40;
/// Bands of conditions; of more of them nothing but stripes would be seen.
const MOST_EVENTS: usize = 150;
const BAND_COLOURS: [RGBColor; 2] = [RGBColor(0xdd, 0xe8, 0xf0), RGBColor(0xf3, 0xea, 0xd8)];

/// Draws a recording.
pub fn svg(recording: &Recording) -> Result<String, PlotError> {
    let content = Content::of(recording)?;
    if content.temperatures.is_empty()
        && content.powers.is_empty()
        && content.heaters.is_empty()
        && content.wind.is_empty()
        && content.answer.is_none()
    {
        return Err(PlotError::Nothing(recording.path.clone()));
    }
    let layout = Layout::of(&content);
    let mut svg = String::new();
    compose(&content, &layout, &mut svg).map_err(|error| PlotError::Drawing(error.to_string()))?;
    Ok(in_pixels(&svg, WIDTH, layout.height))
}

/// Where the panels are, from top to bottom; `None` for those that are left out.
struct Layout {
    height: f64,
    left: f64,
    events: Option<Rect>,
    wind: Option<Rect>,
    answers: Vec<(Part, Rect)>,
    temperatures: Option<Rect>,
    deviations: Option<Rect>,
    powers: Option<Rect>,
    heaters: Option<Rect>,
    close_up: Option<Rect>,
}

impl Layout {
    fn of(content: &Content) -> Self {
        let mut y = 62.0;
        let names = content.heaters.iter().map(|(name, _, _)| text_width(name, 12.0));
        let doubts = content.answer.iter().flat_map(|answer| &answer.doubts).map(|(name, _)| text_width(name, 12.0));
        let left = names.chain(doubts).fold(LEFT, |left, width| left.max(width + 18.0));
        let width = WIDTH - RIGHT - left;
        let mut place = |wanted: bool, above: f64, height: f64| {
            wanted.then(|| {
                let rect = Rect { left, right: WIDTH - RIGHT, top: y + above, bottom: y + above + height };
                y = rect.bottom;
                rect
            })
        };
        let rows = content.heaters.len() as f64;
        let named = content.events.iter().any(|(label, _, _)| !label.is_empty());
        let temperatures = content.temperatures.iter().chain(&content.gas);
        let labels: Vec<&str> = temperatures.map(|curve| curve.label.as_str()).collect();
        let above_temperatures = CAPTION + legend_height(labels.iter().copied(), width);
        let above_powers = CAPTION + legend_height(content.powers.iter().map(|power| power.label.as_str()), width);
        let alone = content.is_of_answers();
        let parts = content.answer.as_ref().map_or_else(Vec::new, |answer| answer.parts(alone));
        let any_wind = (!content.wind.is_empty() || content.answer.is_some()) && !alone;
        let layout = Self {
            height: 0.0,
            left,
            events: place(named, 4.0, 22.0),
            wind: place(any_wind, CAPTION, if content.answer.is_some() { 190.0 } else { 130.0 }),
            answers: parts
                .into_iter()
                .filter_map(|(part, height)| Some((part, place(true, CAPTION, height)?)))
                .collect(),
            temperatures: place(!content.temperatures.is_empty(), above_temperatures, 130.0),
            deviations: place(!content.deviations.is_empty(), CAPTION, 100.0),
            powers: place(!content.powers.is_empty(), above_powers, 190.0),
            heaters: place(rows > 0.0, CAPTION, 22.0 * rows),
            close_up: place(rows > 0.0, 66.0, 16.0 * rows),
        };
        Self { height: y + 38.0, ..layout }
    }

    /// The panels over the whole time, in order.
    fn whole(&self) -> impl Iterator<Item = Rect> {
        let answers = self.answers.iter().map(|(_, rect)| *rect);
        let others = [self.temperatures, self.deviations, self.powers, self.heaters];
        self.wind.into_iter().chain(answers).chain(others.into_iter().flatten())
    }
}

fn compose<'a>(content: &Content, layout: &Layout, svg: &'a mut String) -> Result<(), DrawError<'a>> {
    let figure = Figure::new(svg, WIDTH, layout.height)?;
    let first = content.temperatures.first().or(content.wind.first());
    let bins = first.map(|curve| &curve.bins).or(content.answer.as_ref().map(|answer| &answer.speed.answer));
    let end_s = bins.and_then(|bins| bins.last()).map_or(content.time_s[content.time_s.len() - 1], |bin| bin.to_s);
    let start_s = content.time_s[0];
    let end_s = if end_s > start_s { end_s } else { start_s + 1.0 };
    let time = Axis::exactly(start_s, end_s, 10);
    let panel = |rect: Rect, value: Axis| Panel { figure: &figure, rect, time: time.clone(), value };

    headline(&figure, content, layout.left)?;
    event_bands(&figure, content, layout, &time)?;
    if let Some(rect) = layout.wind {
        wind(&panel, rect, content)?;
    }
    for (part, rect) in &layout.answers {
        if let Some(of) = &content.answer {
            answer::draw(&figure, of, *part, *rect, &time)?;
        }
    }
    if let Some(rect) = layout.temperatures {
        temperatures(&panel, rect, content)?;
    }
    if let Some(rect) = layout.deviations {
        deviations(&panel, rect, content)?;
    }
    if let Some(rect) = layout.powers {
        let watts = content.powers.iter().flat_map(|power| &power.points).map(|(_, power_w)| *power_w);
        let greatest = watts.fold(0.0, f64::max);
        let (factor, unit) = if greatest < 0.5 { (1e3, "mW") } else { (1.0, "W") };
        let panel = panel(rect, Axis::around([0.0, greatest * factor], 5));
        panel.grid()?;
        let unit = format!("{unit}, decimated to one value in {} s", brief(content.power_window_s));
        let legend: Vec<_> = content.powers.iter().map(|power| (power.label.clone(), power.colour)).collect();
        panel.caption("Heating power", &unit, &legend)?;
        for power in content.powers.iter().rev() {
            let points = power.points.iter().map(|(time_s, power_w)| (*time_s, power_w * factor));
            panel.curve(points, power.colour, CURVE)?;
        }
    }
    if let (Some(rect), Some(close_up)) = (layout.heaters, layout.close_up) {
        heaters(&figure, content, &time, rect, close_up)?;
    } else if let Some(rect) = layout.whole().last() {
        panel(rect, Axis::exactly(0.0, 1.0, 2)).time_labels()?;
    }
    trips(&figure, content, layout, &time)?;
    figure.finish()
}

/// The true wind, or what the anemometer says over it.
fn wind<'f, 'a>(
    panel: &impl Fn(Rect, Axis) -> Panel<'f, 'a>,
    rect: Rect,
    content: &Content,
) -> Result<(), DrawError<'a>>
where
    'a: 'f,
{
    let answers = content.answer.as_ref().map_or(&[][..], |answer| &answer.components);
    let truths = content.wind.iter().flat_map(|curve| &curve.bins).flat_map(|bin| [bin.least, bin.most]);
    // Transients of the first answers would hide the wind.
    let told = if content.wind.is_empty() { answers } else { &[] };
    let values = truths.chain(told.iter().flat_map(|curve| &curve.bins).map(|bin| bin.mean));
    let panel = panel(rect, Axis::around(values.chain([0.0]), 5));
    panel.grid()?;
    if !answers.is_empty() {
        let unit = match content.wind.is_empty() {
            true => "m/s, into which it blows, as answered",
            false => "m/s, into which it blows; answers over the true wind, which is wide and pale",
        };
        panel.caption("Wind", unit, &legend(if content.wind.is_empty() { answers } else { &content.wind }))?;
        return answer::drawn_over(&panel, &content.wind, answers);
    }
    panel.caption("Wind", "m/s, into which it blows", &legend(&content.wind))?;
    for curve in &content.wind {
        panel.band(&curve.bins, curve.colour.mix(0.18))?;
    }
    for curve in &content.wind {
        let width = if curve.label == "speed" { 1.6 } else { 1.1 };
        panel.curve(curve.bins.iter().map(|bin| (bin.middle_s(), bin.mean)), curve.colour, width)?;
    }
    Ok(())
}

fn headline<'a>(figure: &Figure<'a>, content: &Content, left: f64) -> Result<(), DrawError<'a>> {
    let of = |key| content.recording.metadata(key);
    let title = of("title").map_or_else(|| content.recording.path.display().to_string(), str::to_owned);
    figure.text(&title, (left, 26.0), 22.0, INK, Align::Left, true)?;
    let (rows, elements) = (content.time_s.len(), content.elements.len());
    let mut parts = vec![of("head_name").map_or_else(|| format!("{elements} elements"), |head| format!("head {head}"))];
    parts.extend(of("firmware").map(str::to_owned));
    if content.is_of_answers() {
        parts.push(format!("{rows} answers"));
        parts.extend(of("bandwidth_hz").map(|bandwidth_hz| format!("bandwidth {bandwidth_hz} Hz")));
    } else {
        parts.push(format!("{rows} ticks"));
    }
    parts.extend(of("lost").filter(|lost| *lost != "0").map(|lost| format!("{lost} lost")));
    parts.extend(of("hash").map(|hash| format!("hash {hash}")));
    figure.text(&parts.join("  ·  "), (left, 49.0), 12.5, QUIET, Align::Left, false)
}

/// Bands of alternating colour with the labels of the conditions; they go on, paler, through the panels.
fn event_bands<'a>(figure: &Figure<'a>, content: &Content, layout: &Layout, time: &Axis) -> Result<(), DrawError<'a>> {
    let Some(strip) = layout.events else { return Ok(()) };
    let x = |time_s: f64| strip.left + (strip.right - strip.left) * time.share(time_s).clamp(0.0, 1.0);
    let last = content.events.len() - 1;
    if content.events.len() > MOST_EVENTS {
        let words = format!("{} conditions, “{}” to “{}”", last + 1, content.events[0].0, content.events[last].0);
        figure.rectangle(strip, BAND_COLOURS[0].to_rgba(), true)?;
        let middle = (f64::midpoint(strip.left, strip.right), f64::midpoint(strip.top, strip.bottom));
        return figure.text(&words, middle, 12.0, INK, Align::Middle, false);
    }
    for (i, (label, from_s, to_s)) in content.events.iter().enumerate() {
        // The last one holds to the end of the last tick.
        let (left, right) = (x(*from_s), if i == last { strip.right } else { x(*to_s) });
        let colour = BAND_COLOURS[i % 2];
        figure.rectangle(Rect { left, right, ..strip }, colour.to_rgba(), true)?;
        for rect in layout.whole() {
            figure.rectangle(Rect { left, right, ..rect }, colour.mix(0.3), true)?;
        }
        let room = right - left - 8.0;
        let mut shown = label.clone();
        while text_width(&shown, 12.0) > room && !shown.is_empty() {
            shown.pop();
        }
        if shown.len() < label.len() {
            shown.pop();
            shown = if shown.chars().count() < 3 { String::new() } else { shown.trim_end().to_owned() + "…" };
        }
        let middle = ((left + right) / 2.0, (strip.top + strip.bottom) / 2.0);
        figure.text(&shown, middle, 12.0, INK, Align::Middle, false)?;
    }
    Ok(())
}

fn temperatures<'f, 'a>(
    panel: &impl Fn(Rect, Axis) -> Panel<'f, 'a>,
    rect: Rect,
    content: &Content,
) -> Result<(), DrawError<'a>>
where
    'a: 'f,
{
    let curves = || content.temperatures.iter().chain(&content.gas);
    let values = curves().flat_map(|curve| &curve.bins).flat_map(|bin| [bin.least, bin.most]);
    let targets = content.set_points.iter().map(|set_point| set_point.celsius);
    let panel = panel(rect, Axis::around(values.chain(targets.clone()), 4));
    panel.grid()?;
    let mut distinct: Vec<f64> = Vec::new();
    for target in targets {
        if !distinct.contains(&target) {
            distinct.push(target);
        }
    }
    let unit = match distinct.as_slice() {
        [] => "°C".to_owned(),
        [one] => format!("°C, set-point {}", one.to_string().replace('-', "−")),
        _ => "°C, set-points dashed".to_owned(),
    };
    panel.caption("Temperature", &unit, &legend(curves()))?;
    let mut drawn: Vec<(f64, f64, f64)> = Vec::new();
    for SetPoint { from_s, to_s, celsius, .. } in &content.set_points {
        // Most elements share their set-points; one line does for them.
        if drawn.contains(&(*from_s, *to_s, *celsius)) || drawn.len() == MOST_SET_POINTS {
            continue;
        }
        drawn.push((*from_s, *to_s, *celsius));
        let x = |time_s: f64| panel.x(time_s).clamp(rect.left, rect.right);
        let y = panel.y(*celsius);
        panel.figure.dashed(&[(x(*from_s), y), (x(*to_s), y)], QUIET.to_rgba(), 1.0)?;
    }
    // Wide and beneath: what measures the gas lies on it.
    if let Some(curve) = &content.gas {
        panel.curve(curve.bins.iter().map(|bin| (bin.middle_s(), bin.mean)), curve.colour, 3.0 * CURVE)?;
    }
    for curve in content.temperatures.iter().rev() {
        panel.band(&curve.bins, curve.colour.mix(0.3))?;
        panel.curve(curve.bins.iter().map(|bin| (bin.middle_s(), bin.mean)), curve.colour, CURVE)?;
    }
    Ok(())
}

/// How well the loops hold: from when an element first arrived at its set-point, with a range that the rare extremes may leave.
fn deviations<'f, 'a>(
    panel: &impl Fn(Rect, Axis) -> Panel<'f, 'a>,
    rect: Rect,
    content: &Content,
) -> Result<(), DrawError<'a>>
where
    'a: 'f,
{
    let bins = || content.deviations.iter().flat_map(|curve| &curve.bins).filter(|bin| bin.mean.is_finite());
    let mut distances: Vec<f64> = bins().flat_map(|bin| [bin.least.abs(), bin.most.abs()]).collect();
    distances.sort_by(f64::total_cmp);
    let most = distances.get(distances.len().saturating_sub(1) * 98 / 100).copied().unwrap_or(1.0).max(1e-3);
    let panel = panel(rect, Axis::around([-most, most], 4));
    panel.grid()?;
    panel.caption("Off the set-point", "mK; means, and what all of them reach over", &[])?;
    panel.band(&reach(content.deviations.iter().map(|curve| curve.bins.as_slice())), QUIET.mix(0.15))?;
    for curve in content.deviations.iter().rev() {
        panel.curve(curve.bins.iter().map(|bin| (bin.middle_s(), bin.mean)), curve.colour, 1.2)?;
    }
    Ok(())
}

/// One row an element: the share of ticks at the high level over the whole run, and every single bit of a short stretch.
fn heaters<'a>(
    figure: &Figure<'a>,
    content: &Content,
    time: &Axis,
    rect: Rect,
    close_up: Rect,
) -> Result<(), DrawError<'a>> {
    let rows = content.close_up();
    let row_bins = bins(content.time_s, |_| 0.0, content.time_s.len());
    let (from_s, to_s) = (row_bins[rows.start].from_s, row_bins[rows.end - 1].to_s);
    let near = Axis::exactly(from_s, to_s, 8);
    let count = content.heaters.len() as f64;
    let row_of = |rect: Rect, i: usize| {
        let height = (rect.bottom - rect.top) / count;
        let top = rect.top + height * i as f64;
        Rect { top: top + 2.0, bottom: top + height - 2.0, ..rect }
    };
    let share = Axis::exactly(0.0, 1.0, 1);
    let whole = Panel { figure, rect, time: time.clone(), value: Axis::exactly(0.0, 1.0, 1) };
    whole.caption("Heater bits", "share of ticks at the high level", &[])?;
    let detail = Panel { figure, rect: close_up, time: near.clone(), value: share.clone() };
    let words = format!("every bit of {} ticks", rows.len());
    let middle = whole.x(f64::midpoint(from_s, to_s)).clamp(rect.left + 150.0, rect.right - 150.0);
    figure.text(&words, (middle, close_up.top - 13.0), 12.0, QUIET, Align::Middle, false)?;
    for (i, (name, colour, bits)) in content.heaters.iter().enumerate() {
        for (rect, time, bins) in [
            (row_of(rect, i), time, bins(content.time_s, |row| bits[row], BINS)),
            (row_of(close_up, i), &near, bins(&content.time_s[rows.clone()], |row| bits[rows.start + row], rows.len())),
        ] {
            let middle = (rect.top + rect.bottom) / 2.0;
            figure.text(name, (rect.left - 8.0, middle), 12.0, QUIET, Align::Right, false)?;
            figure.rectangle(rect, colour.mix(0.1), true)?;
            Panel { figure, rect, time: time.clone(), value: share.clone() }.bars(&bins, *colour)?;
        }
    }
    whole.time_labels()?;
    detail.time_labels()?;
    // Where the close-up comes from.
    let (left, right) = (whole.x(from_s), whole.x(to_s).max(whole.x(from_s) + 1.5));
    figure.rectangle(Rect { left, right, top: rect.top - 2.0, bottom: rect.bottom + 2.0 }, INK.to_rgba(), false)?;
    for (top, bottom) in [(left, close_up.left), (right, close_up.right)] {
        figure.line(
            &[(top, rect.bottom + 2.0), (top, rect.bottom + 24.0), (bottom, close_up.top - 4.0)],
            QUIET.mix(0.6),
            1.0,
        )?;
    }
    Ok(())
}

fn trips<'a>(figure: &Figure<'a>, content: &Content, layout: &Layout, time: &Axis) -> Result<(), DrawError<'a>> {
    let panels: Vec<Rect> = layout.whole().collect();
    let (Some(first), Some(last)) = (panels.first(), panels.last()) else { return Ok(()) };
    for (i, (words, _, time_s)) in content.trips.iter().enumerate() {
        let x = first.left + (first.right - first.left) * time.share(*time_s);
        figure.line(&[(x, first.top), (x, last.bottom)], ALARM.to_rgba(), 1.5)?;
        let words = format!("tripped: {words}");
        let y = first.top + 11.0 + 15.0 * (i % 4) as f64;
        let fits = x + 6.0 + text_width(&words, 12.5) < first.right;
        let (x, align) = if fits { (x + 6.0, Align::Left) } else { (x - 6.0, Align::Right) };
        let width = text_width(&words, 12.5) * 1.12;
        let left = if fits { x - 3.0 } else { x - width };
        let paper = Rect { left, right: left + width + 3.0, top: y - 8.0, bottom: y + 8.0 };
        figure.rectangle(paper, WHITE.mix(0.85), true)?;
        figure.text(&words, (x, y), 12.5, ALARM, align, true)?;
    }
    Ok(())
}

fn legend<'c>(curves: impl IntoIterator<Item = &'c Curve>) -> Vec<(String, RGBColor)> {
    curves.into_iter().map(|curve| (curve.label.clone(), curve.colour)).collect()
}

/// Three digits, for a caption.
fn brief(number: f64) -> String {
    let digits = (2 - number.abs().max(1e-9).log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{number:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
