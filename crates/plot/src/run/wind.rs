//! Wind estimates of an anemometer, reduced to what a picture can hold, and their charts.
//!
//! | chart | estimate | truth, where it is known |
//! |---|---|---|
//! | speed | mean, band of ± one standard uncertainty of a single estimate | wide and pale behind it |
//! | azimuth, elevation | the same of where the wind goes to; gaps where there is no direction | the same |
//! | azimuth in the plane | in place of both, for heads that output the wind in a plane | the same |
//! | angle to the axis | in place of both, for heads with one axis | the same |
//! | conductances | of the surfaces | raw ones pale behind them |
//! | gas | temperature as the anemometer knows it, where it changes | wide and pale |
//! | quality flags | a row each: the share of estimates that have it, over time and in all | |
//!
//! Errors against the truth are in `wind_error.rs`, and their charts in `error_charts.rs`.

use dr_core::wind::QualityFlags;

use super::columns::{VectorColumns, counted, stretches};
use super::error_charts::{over_time, summary, sweep};
use super::quantity::{Quantity, azimuths};
use super::wind_error::{Comparison, WindBesideTruth, by_wind};
use crate::engine::axis::{extent, extent_of_most};
use crate::engine::chart::{Chart, Shading};
use crate::engine::colour::{ALARM, Colour, INK, PALETTE, Pen, QUIET, TRUTH};
use crate::engine::reduce::{BINS, Bin, bins};
use crate::engine::trace::Trace;
use anemometry::vector::{dot, length};
use recording::head_mounting::HeadMounting;
use recording::wind::{
    DIRECTION_UNCERTAINTY, ESTIMATED_GAS, QUALITY_FLAGS, SPEED_UNCERTAINTY, WIND_ESTIMATE, WIND_SPEED,
};
use recording::{CONDUCTANCE, GAS_TEMPERATURE, RAW_CONDUCTANCE, Recording, TRUE_WIND};

/// A gas that stays within so many kelvin is not drawn.
const STEADY_GAS_K: f64 = 0.2;
/// Slower truths have no direction, m/s.
const STILL_M_S: f64 = 1e-3;
/// A flag of a single estimate among many is drawn as high as one of this share: a hair.
const LEAST_SHARE: f64 = 0.08;
/// Height of a row of flags, mm.
const FLAG_ROW: f64 = 3.9;

/// The wind estimates of a recording.
pub struct WindEstimates<'r> {
    recording: &'r Recording,
    /// Rows with an estimate, which most ticks do not have.
    rows: Vec<usize>,
    /// Times of these rows.
    times_s: Vec<f64>,
    flags: &'r [f64],
    speed_m_s: &'r [f64],
    vector: VectorColumns<'r>,
    truth: Option<VectorColumns<'r>>,
    /// Part of a wind that the head resolves.
    comparison: Comparison,
    /// Any of them has a direction; those of a single element have none.
    has_direction: bool,
    /// Each counts in histograms.
    counted: Vec<bool>,
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
        let vector = VectorColumns::of(recording, WIND_ESTIMATE)?;
        let rows: Vec<usize> = (0..flags.len()).filter(|&row| flags[row].is_finite()).collect();
        let truth = VectorColumns::of(recording, TRUE_WIND);
        let truth = truth.filter(|truth| rows.iter().any(|&row| truth.at(row)[0].is_finite()));
        let times_s = rows.iter().map(|&row| time_s[row]).collect();
        let of_row = counted(recording, time_s);
        let counted = rows.iter().map(|&row| of_row[row]).collect();
        let mut estimates = Self {
            recording,
            rows,
            times_s,
            flags,
            speed_m_s,
            vector,
            truth,
            comparison: Comparison::of_recording(recording),
            has_direction: false,
            counted,
            compared: Vec::new(),
            winds: Vec::new(),
        };
        estimates.has_direction = estimates.rows.iter().any(|&row| estimates.estimated(row).is_some());
        (!estimates.rows.is_empty()).then(|| estimates.compared())
    }

    /// With its errors against the truth.
    fn compared(mut self) -> Self {
        let uncertainties = [SPEED_UNCERTAINTY, DIRECTION_UNCERTAINTY].map(|name| self.numbers(name));
        let unusable = QualityFlags::FAILED.0 | QualityFlags::STARTING.0 | QualityFlags::NOT_RUNNING.0;
        let of = |(&row, &time_s): (&usize, &f64)| {
            let truth = self.truth?.at(row);
            let estimate = (self.vector.at(row), self.speed_m_s[row]);
            let of = uncertainties.map(|of| of.map_or(f64::NAN, |of| of[row]));
            let has_direction = self.estimated(row).is_some();
            let counts = self.flags[row] as u16 & unusable == 0;
            counts.then(|| self.comparison.of(time_s, estimate, truth, has_direction, of)).flatten()
        };
        self.compared = self.rows.iter().zip(&self.times_s).map(of).collect();
        let events = stretches(self.recording.events()).into_iter().filter(|(.., word)| !word.is_empty());
        let place = |row: usize| self.rows.partition_point(|of| *of < row);
        let winds: Vec<(usize, usize)> = events.map(|(from, to, _)| (place(from), place(to))).collect();
        self.winds = by_wind(&self.that_count(), &winds, self.comparison);
        self
    }

    /// Estimates beside their truth, without those that do not count.
    fn that_count(&self) -> Vec<Option<WindBesideTruth>> {
        self.compared.iter().zip(&self.counted).map(|(of, counts)| of.filter(|_| *counts)).collect()
    }

    /// Number of winds, if they are drawn one by one.
    pub fn sweep(&self) -> Option<usize> {
        (!self.winds.is_empty()).then_some(self.winds.len())
    }

    /// Rows of charts that have no time axis: errors by wind, estimate over truth, histograms.
    pub fn errors(&self) -> Vec<Vec<Chart>> {
        let all: Vec<WindBesideTruth> = self.that_count().into_iter().flatten().collect();
        match (self.winds.as_slice(), all.as_slice()) {
            (_, []) => Vec::new(),
            ([], all) => vec![summary(all, true)],
            (winds, _) => sweep(winds, self.has_direction).into_iter().chain([summary(winds, false)]).collect(),
        }
    }

    /// The vector and its speed; of a head with one axis, or without a direction, the speed alone.
    pub fn components(&self) -> Vec<(&'static str, Colour, Vec<Bin>)> {
        let VectorColumns([x, y, z]) = self.vector;
        let all = [("x", PALETTE[0], x), ("y", PALETTE[1], y), ("z", PALETTE[2], z), ("speed", INK, self.speed_m_s)];
        let speed_alone = self.comparison.axis.is_some() || !self.has_direction;
        let all = all.into_iter().skip(if speed_alone { 3 } else { 0 });
        all.map(|(label, colour, of)| (label, colour, self.reduced(|row| of[row]))).collect()
    }

    /// Sense in which azimuths count, and where north is among them, if the head has a heading.
    fn azimuth_note(&self) -> String {
        let from = if self.comparison.is_tilted() { "in the head's plane" } else { "from x towards y" };
        let mut note = format!("{from}, where the wind goes to");
        if let Some(mounting) = HeadMounting::from_metadata(&self.recording.metadata, None, None).ok().flatten() {
            let [x, y, _] = self.comparison.in_frame(mounting.north());
            note += &format!("; north is {:.0}°", libm::atan2(y, x).to_degrees());
        }
        note
    }

    /// Its charts: all of them, or those that a run has beside its own.
    pub fn charts(&self, alone: bool) -> Vec<Chart> {
        if alone && self.sweep().is_some() {
            return vec![self.flag_chart()];
        }
        let mut charts = Vec::new();
        charts.extend(alone.then(|| self.speed_chart()));
        if let Some(axis) = self.comparison.axis.filter(|_| self.has_direction) {
            let angle =
                |wind: [f64; 3], speed: f64| libm::acos((dot(wind, axis) / speed).clamp(-1.0, 1.0)).to_degrees();
            let chart = Chart::new("Angle to the head's axis", "°").note("0 goes to where the first surface looks");
            charts.push(self.direction(angle).narrow_chart(chart.height(25.0), 0.0, 180.0));
        } else if alone && self.has_direction && self.comparison.normal.is_some() {
            let azimuth = self.azimuth(self.uncertainty(DIRECTION_UNCERTAINTY));
            charts.push(azimuth.azimuth_chart(&self.azimuth_note()));
        } else if alone && self.has_direction {
            let elevation =
                self.direction(|wind, _| libm::asin((wind[2] / length(wind)).clamp(-1.0, 1.0)).to_degrees());
            // The same uncertainty on the sphere is a greater one of the azimuth towards the poles.
            let widen = |(up, of): (&Bin, &f64)| (of / libm::cos(up.mean.to_radians()).max(1e-3)).min(180.0);
            let uncertainty = elevation.estimate.iter().zip(&elevation.uncertainty).map(widen).collect();
            charts.push(self.azimuth(uncertainty).azimuth_chart(&self.azimuth_note()));
            let chart = Chart::new("Elevation", "°").note("above the xy plane").height(22.0);
            charts.push(elevation.narrow_chart(chart, -90.0, 90.0));
        }
        if alone {
            let is_compared = self.compared.iter().any(Option::is_some);
            let errors = is_compared.then(|| over_time(&self.times_s, &self.compared, self.has_direction));
            charts.extend(errors.into_iter().flatten());
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
        // A component that such heads do not determine is no part of their direction.
        let is_partial = self.comparison.axis.is_some() || self.comparison.normal.is_some();
        let undetermined = if is_partial { 0 } else { QualityFlags::UNDETERMINED.0 };
        let lacking = QualityFlags::FAILED.0 | QualityFlags::NO_DIRECTION.0 | undetermined;
        let has_direction = self.flags[row] as u16 & lacking == 0 && self.speed_m_s[row] > 0.0;
        has_direction.then(|| self.vector.at(row))
    }

    /// Visible part of it, where it is known and has a direction.
    fn true_wind(&self, row: usize) -> Option<[f64; 3]> {
        self.truth.map(|truth| self.comparison.visible(truth.at(row))).filter(|wind| length(*wind) > STILL_M_S)
    }

    /// An angle of a wind with some speed, estimated and true.
    fn direction(&self, angle: impl Fn([f64; 3], f64) -> f64) -> Quantity {
        let estimated = |row| self.estimated(row).map_or(f64::NAN, |wind| angle(wind, self.speed_m_s[row]));
        let truth = |row| self.true_wind(row).map_or(f64::NAN, |wind| angle(wind, length(wind)));
        Quantity {
            estimate: self.reduced(estimated),
            uncertainty: self.uncertainty(DIRECTION_UNCERTAINTY),
            truth: self.truth.map(|_| self.reduced(truth)),
        }
    }

    fn azimuth(&self, uncertainty: Vec<f64>) -> Quantity {
        let frame = |wind: Option<[f64; 3]>| wind.map(|wind| self.comparison.in_frame(wind));
        let truth = |i: usize| frame(self.true_wind(self.rows[i]));
        Quantity {
            estimate: azimuths(&self.times_s, |i| frame(self.estimated(self.rows[i])), BINS),
            uncertainty,
            truth: self.truth.map(|_| azimuths(&self.times_s, truth, BINS)),
        }
    }

    /// Room for nearly all estimates and for all of the truth; from zero, unless the speed hardly
    /// changes.
    fn speed_chart(&self) -> Chart {
        let speed = Quantity {
            estimate: self.reduced(|row| self.speed_m_s[row]),
            uncertainty: self.uncertainty(SPEED_UNCERTAINTY),
            truth: self.truth.map(|truth| self.reduced(|row| length(self.comparison.visible(truth.at(row))))),
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
        let (low, high) = extent_of_most(means).unwrap_or((0.0, 1.0));
        let raw = self.of_surfaces(RAW_CONDUCTANCE).into_iter();
        let raw = raw.map(|(_, pen, bins)| Trace::pale("", bins, pen.colour.paler()));
        let is_there = !conductances.is_empty();
        let lines = conductances.into_iter();
        let lines = lines.map(|(label, pen, bins)| Trace::bins(label, bins).painted(pen).band(0.15));
        let chart = Chart::new("Conductance to the gas", "mW/K").note("pale: from the power alone").height(30.0);
        is_there.then(|| chart.range(low.min(0.0), 1.1 * high).traces(raw.chain(lines)))
    }

    fn gas_chart(&self) -> Option<Chart> {
        let gas = self.column(ESTIMATED_GAS).filter(|gas| changes(gas))?;
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

fn changes(bins: &[Bin]) -> bool {
    extent(bins.iter().map(|bin| bin.mean)).is_some_and(|(low, high)| high - low > STEADY_GAS_K)
}

/// A share in percent: 3.6 %, 12 %, < 0.1 %.
fn percent(share: f64) -> String {
    match 100.0 * share {
        few if few < 0.1 => "< 0.1 %".to_owned(),
        some if some < 10.0 => format!("{some:.1} %"),
        many => format!("{many:.0} %"),
    }
}
