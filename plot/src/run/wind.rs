//! Wind estimates of an anemometer, reduced to what a picture can hold, and their charts.
//!
//! | chart | estimate | truth, where it is known |
//! |---|---|---|
//! | speed | mean, band of ± one standard uncertainty of a single estimate | wide and pale behind it |
//! | azimuth, elevation | of where the wind goes to, likewise; gaps where there is no direction | likewise |
//! | angle to the axis | in place of both, for heads with one axis | likewise |
//! | conductances | of the surfaces | raw ones pale behind them |
//! | gas | temperature as the anemometer knows it, where it changes | wide and pale |
//! | quality flags | a row each: the share of estimates that have it, over time and in all | |
//!
//! Errors against the truth are in `wind_error.rs`.

use dr_core::wind::QualityFlags;

use super::azimuth;
use super::numbers::{dot, most_of, size};
use super::wind_error::{self, Comparison, WindBesideTruth, by_wind, sweep};
use crate::engine::chart::{Chart, Shading};
use crate::engine::colour::{ALARM, Colour, ESTIMATE, INK, PALETTE, QUIET, TRUTH};
use crate::engine::pen::Pen;
use crate::engine::reduce::{BINS, Bin, bins};
use crate::engine::trace::Trace;
use recording::wind::{
    DIRECTION_UNCERTAINTY, QUALITY_FLAGS, SPEED_UNCERTAINTY, WIND_ESTIMATE as COMPONENTS, WIND_SPEED,
};
use recording::{CONDUCTANCE, RAW_CONDUCTANCE};
use recording::{GAS_TEMPERATURE, Recording, TRUE_WIND};

/// A gas that stays within so many kelvin is not drawn.
const STEADY_GAS_K: f64 = 0.2;
/// Slower truths have no direction, m/s.
const STILL_M_S: f64 = 1e-3;
/// A flag of a single estimate among many is drawn as high as one of this share: a hair.
const LEAST_SHARE: f64 = 0.08;
/// Height of a row of flags, mm.
const FLAG_ROW: f64 = 3.9;

/// A quantity with its standard uncertainty and its truth.
struct Quantity {
    estimate: Vec<Bin>,
    /// Standard uncertainty of a single estimate, by bin.
    uncertainty: Vec<f64>,
    truth: Option<Vec<Bin>>,
}

/// The wind estimates of a recording.
pub struct WindEstimates<'r> {
    recording: &'r Recording,
    /// Those with an estimate, which most ticks do not have.
    rows: Vec<usize>,
    /// Of these rows.
    times_s: Vec<f64>,
    flags: &'r [f64],
    speed_m_s: &'r [f64],
    vector: [&'r [f64]; 3],
    truth: Option<[&'r [f64]; 3]>,
    /// Of a head that reports one angle only.
    axis: Option<[f64; 3]>,
    /// Every estimate beside its truth, where that is known and it counts.
    compared: Vec<Option<WindBesideTruth>>,
    /// The means of winds, where there are many.
    winds: Vec<WindBesideTruth>,
}

impl<'r> WindEstimates<'r> {
    /// None where a recording has no wind estimates.
    pub fn of(recording: &'r Recording, time_s: &[f64]) -> Option<Self> {
        let numbers = |name: &str| recording.numbers(name).ok();
        let (flags, speed_m_s) = (numbers(QUALITY_FLAGS)?, numbers(WIND_SPEED)?);
        let [x, y, z] = COMPONENTS.map(numbers);
        let vector = [x?, y?, z?];
        let rows: Vec<usize> = (0..flags.len()).filter(|&row| flags[row].is_finite()).collect();
        let truth = match TRUE_WIND.map(numbers) {
            [Some(x), Some(y), Some(z)] => Some([x, y, z]).filter(|[x, ..]| rows.iter().any(|&row| x[row].is_finite())),
            _ => None,
        };
        let times_s = rows.iter().map(|&row| time_s[row]).collect();
        let (axis, compared, winds) = (axis(recording), Vec::new(), Vec::new());
        let estimates = Self { recording, rows, times_s, flags, speed_m_s, vector, truth, axis, compared, winds };
        (!estimates.rows.is_empty()).then(|| estimates.compared())
    }

    /// With its errors against the truth.
    fn compared(mut self) -> Self {
        let comparison = Comparison { axis: self.axis, normal: card_normal(self.recording) };
        let uncertainties = [SPEED_UNCERTAINTY, DIRECTION_UNCERTAINTY].map(|name| self.numbers(name));
        let unusable = QualityFlags::FAILED.0 | QualityFlags::STARTING.0 | QualityFlags::NOT_RUNNING.0;
        let of = |(&row, &time_s): (&usize, &f64)| {
            let truth = self.truth?.map(|of| of[row]);
            let estimate = (self.vector.map(|of| of[row]), self.speed_m_s[row]);
            let of = uncertainties.map(|of| of.map_or(f64::NAN, |of| of[row]));
            let has_direction = self.estimated(row).is_some() || comparison.normal.is_some();
            let counts = self.flags[row] as u16 & unusable == 0;
            counts.then(|| comparison.of(time_s, estimate, truth, has_direction, of)).flatten()
        };
        self.compared = self.rows.iter().zip(&self.times_s).map(of).collect();
        let events = self.recording.events().into_iter().flat_map(|words| words.stretches().collect::<Vec<_>>());
        let place = |row: usize| self.rows.partition_point(|of| *of < row);
        let stretches: Vec<(usize, usize)> =
            events.filter(|(.., word)| !word.is_empty()).map(|(from, to, _)| (place(from), place(to))).collect();
        self.winds = by_wind(&self.compared, &stretches, comparison);
        self
    }

    /// How many winds there are, if they are drawn one by one.
    pub fn sweep(&self) -> Option<usize> {
        (!self.winds.is_empty()).then_some(self.winds.len())
    }

    /// Rows of charts that have no time axis: errors by wind, estimate over truth, histograms.
    pub fn errors(&self) -> Vec<Vec<Chart>> {
        let all: Vec<WindBesideTruth> = self.compared.iter().flatten().copied().collect();
        match (self.winds.as_slice(), all.as_slice()) {
            (_, []) => Vec::new(),
            ([], all) => vec![wind_error::summary(all, true)],
            (winds, _) => sweep(winds).map(Vec::from).into_iter().chain([wind_error::summary(winds, false)]).collect(),
        }
    }

    /// The vector and its speed; of a head with one axis the speed alone.
    pub fn components(&self) -> Vec<(&'static str, Colour, Vec<Bin>)> {
        let [x, y, z] = self.vector;
        let all = [("x", PALETTE[0], x), ("y", PALETTE[1], y), ("z", PALETTE[2], z), ("speed", INK, self.speed_m_s)];
        let all = all.into_iter().skip(if self.axis.is_some() { 3 } else { 0 });
        all.map(|(label, colour, of)| (label, colour, self.reduced(|row| of[row]))).collect()
    }

    /// Its charts: all of them, or those that a run has beside its own.
    pub fn charts(&self, alone: bool) -> Vec<Chart> {
        if alone && self.sweep().is_some() {
            return vec![self.flag_chart()];
        }
        let mut charts = Vec::new();
        charts.extend(alone.then(|| self.speed_chart()));
        if let Some(axis) = self.axis {
            let angle = |wind: [f64; 3], speed: f64| (dot(wind, axis) / speed).clamp(-1.0, 1.0).acos().to_degrees();
            let chart = Chart::new("Angle to the head's axis", "°").note("0 goes to where the first surface looks");
            charts.push(self.direction(angle).narrow_chart(chart.height(25.0), 0.0, 180.0));
        } else if alone {
            let elevation = self.direction(|wind, _| (wind[2] / size(wind)).clamp(-1.0, 1.0).asin().to_degrees());
            charts.push(self.azimuth(&elevation).azimuth_chart());
            let chart = Chart::new("Elevation", "°").note("above the xy plane").height(22.0);
            charts.push(elevation.narrow_chart(chart, -90.0, 90.0));
        }
        if alone {
            let is_compared = self.compared.iter().any(Option::is_some);
            charts.extend(
                is_compared.then(|| wind_error::over_time(&self.times_s, &self.compared)).into_iter().flatten(),
            );
            charts.extend(self.conductance_chart());
            charts.extend(self.gas_chart());
        }
        charts.push(self.flag_chart());
        charts
    }

    fn numbers(&self, name: &str) -> Option<&'r [f64]> {
        self.recording.numbers(name).ok()
    }

    /// A value of every estimate, by its row.
    fn reduced(&self, values: impl Fn(usize) -> f64) -> Vec<Bin> {
        bins(&self.times_s, |i| values(self.rows[i]), BINS)
    }

    fn column(&self, name: &str) -> Option<Vec<Bin>> {
        self.numbers(name).map(|column| self.reduced(|row| column[row]))
    }

    /// By bin; nothing where the recording has no such column.
    fn uncertainty(&self, name: &str) -> Vec<f64> {
        self.column(name).iter().flatten().map(|bin| bin.mean).collect()
    }

    /// Where the estimate has a direction.
    fn estimated(&self, row: usize) -> Option<[f64; 3]> {
        let undetermined = if self.axis.is_none() { QualityFlags::UNDETERMINED.0 } else { 0 };
        let lacking = QualityFlags::FAILED.0 | QualityFlags::NO_DIRECTION.0 | undetermined;
        let has_direction = self.flags[row] as u16 & lacking == 0 && self.speed_m_s[row] > 0.0;
        has_direction.then(|| self.vector.map(|of| of[row]))
    }

    /// Where it is known and has a direction.
    fn true_wind(&self, row: usize) -> Option<[f64; 3]> {
        self.truth.map(|of| of.map(|of| of[row])).filter(|wind| size(*wind) > STILL_M_S)
    }

    /// An angle of a wind with some speed, estimated and true.
    fn direction(&self, angle: impl Fn([f64; 3], f64) -> f64) -> Quantity {
        let estimated = |row| self.estimated(row).map_or(f64::NAN, |wind| angle(wind, self.speed_m_s[row]));
        let truth = |row| self.true_wind(row).map_or(f64::NAN, |wind| angle(wind, size(wind)));
        Quantity {
            estimate: self.reduced(estimated),
            uncertainty: self.uncertainty(DIRECTION_UNCERTAINTY),
            truth: self.truth.map(|_| self.reduced(truth)),
        }
    }

    fn azimuth(&self, elevation: &Quantity) -> Quantity {
        // The same uncertainty on the sphere is a greater one of the azimuth towards the poles.
        let widen = |(up, of): (&Bin, &f64)| (of / up.mean.to_radians().cos().max(1e-3)).min(180.0);
        Quantity {
            estimate: azimuth::azimuths(&self.times_s, |i| self.estimated(self.rows[i]), BINS),
            uncertainty: elevation.estimate.iter().zip(&elevation.uncertainty).map(widen).collect(),
            truth: self.truth.map(|_| azimuth::azimuths(&self.times_s, |i| self.true_wind(self.rows[i]), BINS)),
        }
    }

    /// Room for nearly all estimates and for all of the truth; from zero, unless the speed hardly
    /// changes.
    fn speed_chart(&self) -> Chart {
        let speed = Quantity {
            estimate: self.reduced(|row| self.speed_m_s[row]),
            uncertainty: self.uncertainty(SPEED_UNCERTAINTY),
            truth: self.truth.map(|of| self.reduced(|row| size(of.map(|of| of[row])))),
        };
        let (low, high) = speed.ends().unwrap_or((0.0, 0.0));
        let low = if low < 0.7 * high { 0.0 } else { low };
        let chart = Chart::new("Wind speed", "m/s").height(30.0).range(low.max(0.0), high);
        speed.chart(chart.note("shaded: ± one standard uncertainty, paler: from least to greatest"))
    }

    /// By surface: name, pen and mW/K.
    fn of_surfaces(&self, prefix: &str) -> Vec<(&str, Pen, Vec<Bin>)> {
        let columns = self.recording.columns.iter().filter_map(|column| column.name.strip_prefix(prefix));
        let reduced = |(i, surface)| {
            let of = self.numbers(&format!("{prefix}{surface}"))?;
            Some((surface, Pen::numbered(i), self.reduced(|row| 1e3 * of[row])))
        };
        columns.enumerate().filter_map(reduced).collect()
    }

    fn conductance_chart(&self) -> Option<Chart> {
        let conductances = self.of_surfaces(CONDUCTANCE);
        // Raw ones begin at many times what they end at, and would hide the others.
        let means = conductances.iter().flat_map(|(_, _, bins)| bins).map(|bin| bin.mean);
        let (low, high) = most_of(means).unwrap_or((0.0, 1.0));
        let raw = self.of_surfaces(RAW_CONDUCTANCE).into_iter();
        let raw = raw.map(|(_, pen, bins)| Trace::pale("", bins, pen.colour.paler()));
        let is_there = !conductances.is_empty();
        let lines = conductances.into_iter();
        let lines = lines.map(|(label, pen, bins)| Trace::bins(label, bins).painted(pen).band(0.15));
        let chart = Chart::new("Conductance to the gas", "mW/K").note("pale: from the power alone").height(30.0);
        is_there.then(|| chart.range(low.min(0.0), 1.1 * high).traces(raw.chain(lines)))
    }

    fn gas_chart(&self) -> Option<Chart> {
        let gas = self.column("wind_gas_temperature_c").filter(|gas| changes(gas))?;
        let truth = self.column(GAS_TEMPERATURE).filter(|bins| bins.iter().any(|bin| bin.mean.is_finite()));
        let means = gas.iter().chain(truth.iter().flatten()).map(|bin| bin.mean);
        let chart = Chart::new("Gas", "°C").note("as the anemometer knows it").height(20.0).around(means);
        let truth = truth.map(|truth| Trace::pale("true", truth, TRUTH));
        Some(chart.first_on_top([Trace::bins("estimate", gas).painted(INK).band(0.0)].into_iter().chain(truth)))
    }

    /// A row a flag, as high as the share of estimates that have it, and a hair at least; beside it
    /// the share of all estimates.
    fn flag_chart(&self) -> Chart {
        let chart = Chart::new("Quality flags", "").note("height: share of the estimates at that time");
        let seen = |bin: Bin| Bin { mean: if bin.most > 0.0 { bin.mean.max(LEAST_SHARE) } else { bin.mean }, ..bin };
        let row = |(flag, name): (QualityFlags, &str)| {
            let share = |row: usize| if self.flags[row] as u16 & flag.0 != 0 { 1.0 } else { 0.0 };
            let colour = if name == "failed" { ALARM } else { QUIET };
            let flagged = self.rows.iter().filter(|&&row| share(row) > 0.0).count();
            let label = format!("{name} {}", percent(flagged as f64 / self.rows.len() as f64));
            (flagged > 0).then(|| (label, colour, self.reduced(share).into_iter().map(seen).collect()))
        };
        let rows: Vec<_> = QualityFlags::NAMES.into_iter().filter_map(row).collect();
        if rows.is_empty() {
            let mut chart = chart.bare().height(FLAG_ROW);
            chart.shadings.push(Shading::new(f64::MIN, f64::MAX, QUIET.with_opacity(0.08), "none"));
            return chart;
        }
        chart.bars(rows, FLAG_ROW)
    }
}

impl Quantity {
    /// Puts the estimate over its truth.
    fn chart(&self, chart: Chart) -> Chart {
        let truth = self.truth.as_ref().map(|truth| Trace::pale("true wind", apart(truth), TRUTH).band(0.35));
        let band = Trace::extremes(apart(&self.spread()), 0.3).painted(ESTIMATE);
        let estimate = Trace::bins("estimate", apart(&self.estimate)).painted(ESTIMATE).band(0.13);
        chart.first_on_top([estimate, band].into_iter().chain(truth))
    }

    /// The azimuth, turned into the range of an axis that is cut where nothing is.
    fn azimuth_chart(&self) -> Chart {
        let ends = azimuth::range(&[&self.estimate, self.truth.as_deref().unwrap_or_default()], 0.6 * self.typical());
        let turn = |bins: &[Bin]| azimuth::turned(bins, ends.0);
        let turned = Self {
            estimate: turn(&self.estimate),
            uncertainty: self.uncertainty.clone(),
            truth: self.truth.as_deref().map(turn),
        };
        let chart = Chart::new("Azimuth", "°").note("from x towards y, where the wind goes to").height(25.0);
        turned.chart(chart.degrees(ends))
    }

    /// One standard uncertainty either way of the mean.
    fn spread(&self) -> Vec<Bin> {
        let around = |(bin, of): (&Bin, &f64)| {
            let of = if of.is_finite() { *of } else { 0.0 };
            Bin { least: bin.mean - of, most: bin.mean + of, ..*bin }
        };
        self.estimate.iter().zip(&self.uncertainty).map(around).collect()
    }

    /// What holds nearly all estimates and all of the truth.
    fn ends(&self) -> Option<(f64, f64)> {
        let nearly_all = most_of(self.spread().iter().flat_map(|bin| [bin.least, bin.most]));
        let truths = self.truth.iter().flatten().map(|bin| bin.mean).filter(|mean| mean.is_finite());
        let ends = nearly_all.into_iter().chain(truths.map(|mean| (mean, mean)));
        ends.reduce(|all, of| (all.0.min(of.0), all.1.max(of.1)))
    }

    /// Of an angle that has ends: nearly all of it, and a range of a few degrees at least.
    fn narrow_chart(&self, chart: Chart, least: f64, most: f64) -> Chart {
        let range = self.ends().map_or((least, most), |(low, high)| {
            let air = (0.05 * (high - low)).max(azimuth::LEAST_RANGE_DEG / 2.0 - (high - low) / 2.0);
            ((low - air).max(least), (high + air).min(most))
        });
        self.chart(chart.degrees(range))
    }

    fn typical(&self) -> f64 {
        let mut all: Vec<f64> = self.uncertainty.iter().copied().filter(|of| of.is_finite()).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or(0.0).min(60.0)
    }
}

/// Bins with a gap wherever an azimuth runs out of one end of its axis: nothing else changes by
/// more than half a turn from bin to bin.
fn apart(bins: &[Bin]) -> Vec<Bin> {
    let mut all: Vec<Bin> = Vec::with_capacity(bins.len());
    for bin in bins {
        if let Some(before) = all.last().filter(|before| (before.mean - bin.mean).abs() > 180.0) {
            let gap = Bin { from_s: before.to_s, to_s: bin.from_s, least: f64::NAN, most: f64::NAN, mean: f64::NAN };
            all.push(gap);
        }
        all.push(*bin);
    }
    all
}

fn changes(bins: &[Bin]) -> bool {
    let of = |pick: fn(f64, f64) -> f64| bins.iter().map(|bin| bin.mean).fold(f64::NAN, pick);
    of(f64::max) - of(f64::min) > STEADY_GAS_K
}

/// A share in percent: 3.6 %, 12 %, < 0.1 %.
fn percent(share: f64) -> String {
    match 100.0 * share {
        few if few < 0.1 => "< 0.1 %".to_owned(),
        some if some < 10.0 => format!("{some:.1} %"),
        many => format!("{many:.0} %"),
    }
}

/// The outward normal of a card, which reports the wind in its plane only; none for other heads.
fn card_normal(recording: &Recording) -> Option<[f64; 3]> {
    let head: toml::Table = recording.metadata("head")?.parse().ok()?;
    let calibration = head.get("calibration")?;
    let surfaces = calibration.get("card").and(calibration.get("parts"))?.as_array()?;
    direction(surfaces.first()?)
}

/// The axis of a surface.
fn direction(surface: &toml::Value) -> Option<[f64; 3]> {
    let axis: Vec<f64> = surface.get("axis")?.as_array()?.iter().filter_map(toml::Value::as_float).collect();
    axis.try_into().ok()
}

/// The axis of a head of two hemispheres, which reports one angle only; none for others.
fn axis(recording: &Recording) -> Option<[f64; 3]> {
    let head: toml::Table = recording.metadata("head")?.parse().ok()?;
    let surfaces = head.get("calibration")?.get("parts")?.as_array()?;
    let [first, _] = surfaces.as_slice() else { return None };
    let axis = direction(first)?;
    let length = size(axis);
    (length > 0.0).then(|| axis.map(|of| of / length))
}
