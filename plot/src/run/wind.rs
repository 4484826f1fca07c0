//! Wind estimates of an anemometer, reduced to what a picture can hold, and their charts.
//!
//! | chart | estimate | truth, where it is known |
//! |---|---|---|
//! | speed | mean, band of ± one standard uncertainty of a single estimate | wide and pale behind it |
//! | azimuth, elevation | of where the wind goes to, likewise; gaps where there is no direction | likewise |
//! | angle to the axis | in place of both, for heads with one axis | likewise |
//! | conductances | of the surfaces | raw ones pale behind them |
//! | gas | temperature as the anemometer knows it, where it changes | wide and pale |
//! | quality flags | a row each: the share of estimates that have it | |

use dr_core::wind::QualityFlags;

use super::azimuth;
use crate::engine::chart::{Chart, Shading};
use crate::engine::colour::{ALARM, Colour, ESTIMATE, INK, PALETTE, QUIET, TRUTH};
use crate::engine::reduce::{BINS, Bin, bins};
use crate::engine::trace::{CURVE, Trace};
use recording::wind::{QUALITY_FLAGS, WIND_ESTIMATE as COMPONENTS, WIND_SPEED};
use recording::{CONDUCTANCE, RAW_CONDUCTANCE};
use recording::{GAS_TEMPERATURE, Recording, TRUE_WIND};

/// A gas that stays within so many kelvin is not drawn.
const STEADY_GAS_K: f64 = 0.2;
/// Slower truths have no direction, m/s.
const STILL_M_S: f64 = 1e-3;
/// Width of a truth behind an estimate, pixels.
pub const WIDE: f64 = 4.5;
/// Share of the bins whose values an axis may leave out at either end: transients of the start.
const LEFT_OUT: f64 = 0.005;
/// A flag of a single estimate among many is drawn as high as one of this share.
const LEAST_SHARE: f64 = 0.2;
/// Height of a row of flags, pixels.
const FLAG_ROW: f64 = 20.0;

/// A quantity with its standard uncertainty and its truth.
#[derive(Default)]
pub struct Quantity {
    pub estimate: Vec<Bin>,
    /// Standard uncertainty of a single estimate, by bin.
    pub uncertainty: Vec<f64>,
    pub truth: Option<Vec<Bin>>,
}

/// Label, colour and values.
type Labelled = (String, Colour, Vec<Bin>);

/// All that is drawn of the wind estimates of a recording.
pub struct WindEstimates {
    /// The vector and its speed; of a head with one axis the speed alone.
    pub components: Vec<(&'static str, Colour, Vec<Bin>)>,
    pub speed: Quantity,
    /// Angles, °.
    pub azimuth: Option<Quantity>,
    pub elevation: Option<Quantity>,
    pub angle: Option<Quantity>,
    /// mW/K.
    conductances: Vec<Labelled>,
    raw: Vec<Labelled>,
    /// °C.
    gas: Option<(Vec<Bin>, Option<Vec<Bin>>)>,
    /// Those that occur, with the share of estimates that have them.
    flags: Vec<(&'static str, Vec<Bin>)>,
}

impl WindEstimates {
    /// None where a recording has no wind estimates.
    pub fn of(recording: &Recording, time_s: &[f64], elements: &[(&str, Colour)]) -> Option<Self> {
        let numbers = |name: &str| recording.numbers(name).ok();
        let (flags, speed_m_s) = (numbers(QUALITY_FLAGS)?, numbers(WIND_SPEED)?);
        let [x, y, z] = COMPONENTS.map(numbers);
        let vector = [x?, y?, z?];
        // Most ticks have no estimate; what follows counts estimates.
        let rows: Vec<usize> = (0..flags.len()).filter(|&row| flags[row].is_finite()).collect();
        let times: Vec<f64> = rows.iter().map(|&row| time_s[row]).collect();
        if rows.is_empty() {
            return None;
        }
        let reduced = |values: &dyn Fn(usize) -> f64| bins(&times, |i| values(rows[i]), BINS);
        let means = |column: &[f64]| reduced(&|row| column[row]).iter().map(|bin| bin.mean).collect();
        let uncertainty = |name: &str| numbers(name).map(means).unwrap_or_default();

        let truth = match TRUE_WIND.map(numbers) {
            [Some(x), Some(y), Some(z)] => Some([x, y, z]).filter(|[x, ..]| rows.iter().any(|&row| x[row].is_finite())),
            _ => None,
        };
        let at = |of: [&[f64]; 3], row: usize| of.map(|component| component[row]);
        let true_wind = |row: usize| truth.map(|of| at(of, row)).filter(|wind| size(*wind) > STILL_M_S);
        let axis = axis(recording);
        let undetermined = if axis.is_none() { QualityFlags::UNDETERMINED.0 } else { 0 };
        let lacking = QualityFlags::FAILED.0 | QualityFlags::NO_DIRECTION.0 | undetermined;
        let has_direction = |row: usize| flags[row] as u16 & lacking == 0 && speed_m_s[row] > 0.0;
        let estimated = |row: usize| has_direction(row).then(|| at(vector, row));
        // An angle of a wind with some speed, estimated and true.
        let quantity = |angle: &dyn Fn([f64; 3], f64) -> f64| Quantity {
            estimate: reduced(&|row| estimated(row).map_or(f64::NAN, |wind| angle(wind, speed_m_s[row]))),
            uncertainty: uncertainty("wind_direction_u_deg"),
            truth: truth.map(|_| reduced(&|row| true_wind(row).map_or(f64::NAN, |wind| angle(wind, size(wind))))),
        };
        let (mut azimuth, mut elevation, mut angle) = (None, None, None);
        if let Some(axis) = axis {
            angle = Some(quantity(&|wind, speed| (dot(wind, axis) / speed).clamp(-1.0, 1.0).acos().to_degrees()));
        } else {
            let up = quantity(&|wind, _| (wind[2] / size(wind)).clamp(-1.0, 1.0).asin().to_degrees());
            // The same uncertainty on the sphere is a greater one of the azimuth towards the poles.
            let widen = |(up, of): (&Bin, &f64)| (of / up.mean.to_radians().cos().max(1e-3)).min(180.0);
            azimuth = Some(Quantity {
                estimate: azimuth::azimuths(&times, |i| estimated(rows[i]), BINS),
                uncertainty: up.estimate.iter().zip(&up.uncertainty).map(widen).collect(),
                truth: truth.map(|_| azimuth::azimuths(&times, |i| true_wind(rows[i]), BINS)),
            });
            elevation = Some(up);
        }

        let of_surfaces = |prefix: &str| {
            let columns = recording.columns.iter().filter_map(|column| column.name.strip_prefix(prefix));
            let labelled = |(i, surface): (usize, &str)| {
                let known = elements.iter().find(|(element, _)| *element == surface);
                let colour = known.map_or(Colour::of_element(i), |(_, colour)| *colour);
                let of = numbers(&format!("{prefix}{surface}"))?;
                Some((surface.to_owned(), colour, reduced(&|row| 1e3 * of[row])))
            };
            columns.enumerate().filter_map(labelled).collect::<Vec<_>>()
        };
        let gas = numbers("wind_gas_temperature_c").map(|gas_c| reduced(&|row| gas_c[row]));
        let gas = gas.filter(|gas| changes(gas)).map(|gas| {
            let truth = numbers(GAS_TEMPERATURE).map(|true_c| reduced(&|row| true_c[row]));
            (gas, truth.filter(|bins| bins.iter().any(|bin| bin.mean.is_finite())))
        });
        let has = |flag: QualityFlags| move |row: usize| if flags[row] as u16 & flag.0 != 0 { 1.0 } else { 0.0 };
        let occurring =
            QualityFlags::NAMES.into_iter().filter(|(flag, _)| rows.iter().any(|&row| has(*flag)(row) > 0.0));
        let component = |label, colour, of: &[f64]| (label, colour, reduced(&|row| of[row]));
        let axes = ["x", "y", "z"].into_iter().zip(PALETTE).zip(vector).filter(|_| axis.is_none());
        let components = axes.map(|((label, colour), of)| component(label, colour, of));
        Some(Self {
            components: components.chain([component("speed", INK, speed_m_s)]).collect(),
            speed: Quantity {
                estimate: reduced(&|row| speed_m_s[row]),
                uncertainty: uncertainty("wind_speed_u_m_s"),
                truth: truth.map(|of| reduced(&|row| size(at(of, row)))),
            },
            azimuth,
            elevation,
            angle,
            conductances: of_surfaces(CONDUCTANCE),
            raw: of_surfaces(RAW_CONDUCTANCE),
            gas,
            flags: occurring.map(|(flag, name)| (name, reduced(&has(flag)))).collect(),
        })
    }

    /// Its charts: all of them, or those that a run has beside its own.
    pub fn charts(&self, alone: bool) -> Vec<Chart> {
        let angle = |angle: &Quantity| {
            let chart = Chart::new("Angle to the head's axis", "°").note("0 goes to where the first surface looks");
            angle.chart(chart.height(130.0).degrees(angle.narrow_range(0.0, 180.0)))
        };
        let mut charts = Vec::new();
        if alone {
            charts.push(self.speed_chart());
            charts.extend(self.azimuth.as_ref().map(Quantity::azimuth_chart));
            charts.extend(self.elevation.as_ref().map(|elevation| {
                let chart = Chart::new("Elevation", "°").note("above the xy plane").height(110.0);
                elevation.chart(chart.degrees(elevation.narrow_range(-90.0, 90.0)))
            }));
        }
        charts.extend(self.angle.as_ref().map(angle));
        if alone {
            charts.extend(self.conductance_chart());
            charts.extend(self.gas_chart());
        }
        charts.push(self.flag_chart());
        charts
    }

    /// Room for nearly all estimates and for all of the truth; from zero, unless the speed hardly
    /// changes.
    fn speed_chart(&self) -> Chart {
        let (low, high) = self.speed.ends().unwrap_or((0.0, 0.0));
        let low = if low < 0.7 * high { 0.0 } else { low };
        let chart = Chart::new("Wind speed", "m/s").height(170.0).range(low.max(0.0), high);
        self.speed.chart(chart.note("shaded: ± one standard uncertainty, paler: from least to greatest"))
    }

    fn conductance_chart(&self) -> Option<Chart> {
        // Raw ones begin at many times what they end at, and would hide the others.
        let means = self.conductances.iter().flat_map(|(_, _, bins)| bins).map(|bin| bin.mean);
        let (low, high) = most_of(means).unwrap_or((0.0, 1.0));
        let raw = self.raw.iter().map(|(_, colour, bins)| {
            Trace::bins("", bins.clone()).painted(colour.paler().paler()).width(WIDE).band(0.0)
        });
        let lines = self.conductances.iter();
        let lines = lines.map(|(label, colour, bins)| Trace::bins(label, bins.clone()).painted(*colour).band(0.15));
        let chart = Chart::new("Conductance to the gas", "mW/K").note("pale: from the power alone").height(170.0);
        let chart = raw.chain(lines).fold(chart.range(low.min(0.0), 1.1 * high), Chart::trace);
        (!self.conductances.is_empty()).then_some(chart)
    }

    fn gas_chart(&self) -> Option<Chart> {
        let (gas, truth) = self.gas.as_ref()?;
        let means = gas.iter().chain(truth.iter().flatten()).map(|bin| bin.mean);
        let chart = Chart::new("Gas", "°C").note("as the anemometer knows it").height(90.0).around(means);
        let truth = truth.clone().map(|truth| Trace::bins("true", truth).painted(TRUTH).width(WIDE).band(0.0));
        let gas = Trace::bins("estimate", gas.clone()).painted(INK).band(0.0);
        Some(chart.first_on_top([gas].into_iter().chain(truth)))
    }

    /// A row a flag, as high as the share of estimates that have it, and never too low to be seen.
    fn flag_chart(&self) -> Chart {
        let chart = Chart::new("Quality flags", "").note("share of the estimates that have them");
        if self.flags.is_empty() {
            let mut chart = chart.bare().height(FLAG_ROW);
            chart.shadings.push(Shading::new(f64::MIN, f64::MAX, QUIET.with_opacity(0.08), "none"));
            return chart;
        }
        let seen = |bin: &Bin| Bin { mean: if bin.most > 0.0 { bin.mean.max(LEAST_SHARE) } else { bin.mean }, ..*bin };
        let row = |(name, bins): &(&str, Vec<Bin>)| {
            let colour = if *name == "failed" { ALARM } else { QUIET };
            ((*name).to_owned(), colour, bins.iter().map(seen).collect())
        };
        chart.bars(self.flags.iter().map(row), FLAG_ROW)
    }
}

impl Quantity {
    /// Puts the estimate over its truth.
    fn chart(&self, chart: Chart) -> Chart {
        let truth = self
            .truth
            .as_ref()
            .map(|truth| Trace::bins("true wind", apart(truth)).painted(TRUTH).width(WIDE).band(0.35));
        let band = Trace::extremes(apart(&self.spread()), 0.3).painted(ESTIMATE);
        let estimate = Trace::bins("estimate", apart(&self.estimate)).painted(ESTIMATE).width(CURVE).band(0.13);
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
        let chart = Chart::new("Azimuth", "°").note("from x towards y, where the wind goes to").height(130.0);
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

    /// A range for nearly all of an angle that has ends, at least a few degrees long.
    fn narrow_range(&self, least: f64, most: f64) -> (f64, f64) {
        let Some((low, high)) = self.ends() else { return (least, most) };
        let air = (0.05 * (high - low)).max(azimuth::LEAST_RANGE_DEG / 2.0 - (high - low) / 2.0);
        ((low - air).max(least), (high + air).min(most))
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

/// Least and greatest value but for a few.
fn most_of(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let left_out = (values.len() as f64 * LEFT_OUT) as usize;
    Some((*values.get(left_out)?, *values.get(values.len() - 1 - left_out)?))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn size(of: [f64; 3]) -> f64 {
    dot(of, of).sqrt()
}

fn changes(bins: &[Bin]) -> bool {
    let of = |pick: fn(f64, f64) -> f64| bins.iter().map(|bin| bin.mean).fold(f64::NAN, pick);
    of(f64::max) - of(f64::min) > STEADY_GAS_K
}

/// The axis of a head of two hemispheres, which reports one angle only; none for others.
fn axis(recording: &Recording) -> Option<[f64; 3]> {
    let head: toml::Table = recording.metadata("head")?.parse().ok()?;
    let surfaces = head.get("calibration")?.get("parts")?.as_array()?;
    let [first, _] = surfaces.as_slice() else { return None };
    let axis: Vec<f64> = first.get("axis")?.as_array()?.iter().filter_map(toml::Value::as_float).collect();
    let axis: [f64; 3] = axis.try_into().ok()?;
    let length = size(axis);
    (length > 0.0).then(|| axis.map(|of| of / length))
}
