//! Wind estimates of a recording: the board's anemometer goes through it tick by tick, so that the
//! estimates equal those of the board to the bit.

use std::path::{Path, PathBuf};

use anyhow::Context;
use diffusive::model::Conditions;
use dr_core::wind::QualityFlags;
use dr_core::wind::slow_errors::SurfaceCorrection;
use dr_core::wind::sphere::SECTORS;
use recording::text::tidy;
use wire::WindSample;

use super::comparison::WindComparison;
use super::field_correction::{FieldCorrection, SlowErrorKind, SlowErrorReport, SlowErrorsUnknown, SlowEvidence};
use super::gas_input::{GasInput, temperature_column};
use super::gas_uncertainty::{GasReadingErrors, GasUncertainty};
use super::given_winds::GivenWinds;
use super::moment::{Moment, TickOrigin};
use super::off_line::{OffLineAnemometer, WindError, axes};
use super::replay::Replay;
use super::report::WindReport;
use super::tally::{EstimateTally, LevelRecord, UnknownHeat, contradiction};

use crate::head::calibration::checked::Calibration;
use crate::head::calibration::commands::WindOutput;
use crate::head::calibration::table::CorrectionTable;
use crate::head::file::Head;

/// Share of a tick by which the output interval may be off.
const WHOLE: f64 = 1e-3;

/// Share of contradicting estimates from which on it is sought what explains them.
const OFTEN: f64 = 0.05;

/// χ² that slow errors of one kind leave, beyond which both are sought.
const MOST_LEFT: f64 = 3.0;

/// With one of these an estimate is of a head that warms up, and the heat of its cores unknown.
const NOT_SETTLED: [QualityFlags; 3] = [QualityFlags::STARTING, QualityFlags::SATURATED, QualityFlags::NOT_RUNNING];

/// Options of the estimation.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WindOptions {
    /// Bandwidth of the convective powers, Hz; by default 2.
    pub bandwidth_hz: Option<f64>,
    /// The bandwidth stays after a jump of the wind.
    pub fixed: bool,
    /// Output interval, s; by default 0.01 or a tick.
    pub interval_s: Option<f64>,
    /// Temperature of the gas, a number in °C or a column; by default the head's reference or the
    /// recording's.
    pub gas_temperature: Option<String>,
    /// Pressure of the gas, Pa; by default the recording's.
    pub pressure_pa: Option<f64>,
    /// Standard uncertainties of the two.
    pub gas_uncertainty: GasUncertainty,
    /// Estimates before this time do not count in the report, s.
    pub from_s: f64,
    /// Time at the beginning of every stretch of one label that does not count in the report.
    pub settle_s: f64,
}

/// An estimate with the moment that it belongs to.
#[derive(Debug, Clone, PartialEq)]
pub struct EstimatedWind {
    /// Time, tick and conditions.
    pub moment: Moment,
    /// Sample as the board outputs it.
    pub sample: WindSample,
    /// Heat of each element without a surface, W ([`WindEstimation::cores`]).
    pub unknown_heat_w: Vec<f32>,
    /// True wind, where it is known, m/s.
    pub true_wind_m_s: Option<[f64; 3]>,
}

/// A recording whose wind is being estimated.
pub struct WindEstimation<'a> {
    recording: PathBuf,
    head: &'a Head,
    calibration: &'a Calibration,
    /// Bandwidth and interval.
    pub output: WindOutput,
    options: &'a WindOptions,
    winds: Option<&'a GivenWinds>,
    replay: Replay,
    anemometer: OffLineAnemometer<'a>,
    gas_errors: GasReadingErrors<'a>,
    /// Pressure and temperature of the gas.
    pub gas: GasInput,
    axes: Vec<[f64; 3]>,
    /// Label, and the time at which it began, s.
    label: Option<(String, f64)>,
    estimates: u64,
    tally: EstimateTally,
    comparison: WindComparison,
    has_truth: bool,
    levels: LevelRecord,
    evidence: SlowEvidence,
    correction: Option<FieldCorrection>,
    /// Corrections that the head carries.
    former: Option<[SurfaceCorrection; SECTORS]>,
    /// Least and greatest temperature of the gas in estimates that count, °C.
    gas_c: Option<[f64; 2]>,
    unknown_heat: Vec<UnknownHeat>,
    /// Warnings of the gas, and of labels that do not match.
    warnings: Vec<String>,
}

impl<'a> WindEstimation<'a> {
    /// Opens a recording of `head`; `winds` are the true winds where the recording has none.
    ///
    /// # Errors
    /// If the recording cannot be read, the head has no calibration, an option cannot be met, or no
    /// given wind has a label of the recording.
    pub fn new(
        recording: &Path,
        head: &'a Head,
        options: &'a WindOptions,
        winds: Option<&'a GivenWinds>,
    ) -> Result<Self, WindError> {
        let calibration = head.calibration.as_ref().ok_or_else(|| WindError::NoCalibration(head.name.clone()))?;
        let replay = Replay::open(recording, head, temperature_column(options.gas_temperature.as_deref()))?;
        let output = output(options, replay.sample_period_s)?;
        let anemometer = OffLineAnemometer::new(head, calibration, &output, replay.sample_period_s)?;
        let uncertainty = options.gas_uncertainty;
        let gas_errors = GasReadingErrors::new(uncertainty, head, calibration, &output, replay.sample_period_s)?;
        let given = (options.pressure_pa, options.gas_temperature.as_deref());
        let gas = GasInput::new(given, uncertainty, head, calibration, recording, &replay)?;
        let mut warnings = gas.warnings.clone();
        if let Some(conditions) = &replay.conditions {
            let of = Conditions { pressure_pa: gas.pressure_pa(), ..conditions.clone() };
            warnings.extend(calibration.differences(&of, gas.constant_c().map(|gas_c| [gas_c; 2]), None));
        }
        if let Some(winds) = winds {
            warnings.extend(winds.compare_labels(recording)?);
        }
        Ok(Self {
            recording: recording.to_owned(),
            head,
            calibration,
            output,
            options,
            winds,
            replay,
            anemometer,
            gas_errors,
            gas,
            axes: axes(head, calibration),
            label: None,
            estimates: 0,
            tally: EstimateTally::default(),
            comparison: WindComparison::in_plane(calibration.plane_normal()),
            has_truth: false,
            levels: LevelRecord::default(),
            evidence: SlowEvidence::default(),
            correction: None,
            former: calibration.corrections(),
            gas_c: None,
            unknown_heat: cores(calibration),
            warnings,
        })
    }

    /// Names of the elements of the surfaces.
    pub fn surfaces(&self) -> Vec<String> {
        self.calibration.surfaces.iter().map(|&place| self.head.elements[place].name.clone()).collect()
    }

    /// Names of the elements without a surface.
    pub fn cores(&self) -> Vec<String> {
        self.unknown_heat.iter().map(|of| of.element.clone()).collect()
    }

    /// Tells whether true winds are given or stand in the recording.
    pub fn has_truth(&self) -> bool {
        self.winds.is_some() || self.replay.has_wind()
    }

    /// Tells whether the recording has a column of the gas's temperature.
    pub fn has_gas(&self) -> bool {
        self.replay.has_gas()
    }

    /// Corrects slow errors from now on, at the beginning of the recording.
    #[must_use]
    pub fn corrected(self, correction: FieldCorrection) -> Self {
        Self { correction: Some(correction), ..self }
    }

    /// Slow errors of such a kind in the estimates so far, and the kind that explains the
    /// contradictions far better, if one does.
    ///
    /// # Errors
    /// If the head has no number to spare, or the recording no wind that says something.
    pub fn slow_errors(
        &self,
        kind: SlowErrorKind,
    ) -> Result<(FieldCorrection, Option<SlowErrorKind>), SlowErrorsUnknown> {
        let found = self.find(kind)?;
        let other = kind.other().and_then(|other| self.find(other).ok());
        let better = other.filter(|other| {
            let (better, as_likely) = FieldCorrection::likelier(&found, other);
            better.kind == other.kind && as_likely.is_none() && other.explains()
        });
        Ok((found, better.map(|of| of.kind)))
    }

    fn find(&self, kind: SlowErrorKind) -> Result<FieldCorrection, SlowErrorsUnknown> {
        FieldCorrection::find(&self.evidence, self.anemometer.anemometer(), kind, self.output.bandwidth_hz)
    }

    /// The head's file with slow errors that were found in this recording in its table of
    /// corrections, on top of those that it carries; `found` says by what, `day` when.
    ///
    /// # Errors
    /// If they do not explain what contradicts, or the file cannot be written.
    pub fn corrected_head(
        &self,
        correction: &FieldCorrection,
        found: &str,
        day: Option<&str>,
    ) -> anyhow::Result<String> {
        let whole = correction.constant(self.former.as_ref()).context(
            "nothing is written: the slow errors that were found do not explain what contradicts, or nothing contradicts",
        )?;
        Ok(self.calibration.with_corrections(&whole, found, day, self.head)?.0)
    }

    /// The slow errors that were corrected, or those that explain why estimates contradict
    /// themselves.
    fn slow_error_report(&self) -> Option<SlowErrorReport> {
        if let Some(correction) = &self.correction {
            return Some(SlowErrorReport::of(correction, &self.surfaces(), true));
        }
        let counted = self.tally.summary();
        let inconsistent = *counted.quality_flags.get("inconsistent")?;
        if (inconsistent as f64) < OFTEN * counted.estimates as f64 {
            return None;
        }
        let [offsets, gains] = [SlowErrorKind::Offsets, SlowErrorKind::Gains].map(|kind| self.find(kind).ok());
        let (offsets, gains) = (offsets?, gains?);
        let (better, other) = FieldCorrection::likelier(&offsets, &gains);
        let names = self.surfaces();
        let unexplained = |of: &FieldCorrection| !of.explains() || of.chi_square[1] > MOST_LEFT;
        if unexplained(better)
            && let Some(both) = self.find(SlowErrorKind::Both).ok().filter(|both| !unexplained(both))
        {
            return Some(SlowErrorReport::of(&both, &names, false));
        }
        let other = other.filter(|of| of.explains()).map(|of| SlowErrorReport::of(of, &names, false).words());
        better.explains().then(|| SlowErrorReport { as_likely: other, ..SlowErrorReport::of(better, &names, false) })
    }

    /// The next estimate; none after the last row.
    ///
    /// # Errors
    /// If the recording is damaged, or the board refuses its gas.
    pub fn next_estimate(&mut self) -> Result<Option<EstimatedWind>, WindError> {
        while let Some(moment) = self.replay.next_moment()? {
            let begun_s = match &self.label {
                Some((label, begun_s)) if *label == moment.event => *begun_s,
                _ => moment.time_s,
            };
            if begun_s == moment.time_s {
                self.label = Some((moment.event.clone(), begun_s));
            }
            if let Some((pressure_pa, gas_c)) = self.gas.changed(&moment) {
                self.anemometer.gas(pressure_pa, gas_c)?;
                self.gas_errors.gas(pressure_pa, gas_c)?;
            }
            if moment.known != TickOrigin::Missing {
                self.levels.add(&moment.tick);
            }
            if let Some(correction) = &self.correction {
                let corrections = correction.corrections(moment.time_s, self.former.as_ref());
                self.anemometer.correct(corrections);
                self.gas_errors.correct(corrections);
            }
            let estimate = self.anemometer.step_whole(&moment.tick);
            let mut sample = estimate.as_ref().map(WindSample::from);
            self.gas_errors.step(&moment.tick, sample.as_mut());
            let (Some(estimate), Some(mut sample)) = (estimate, sample) else { continue };
            match moment.known {
                TickOrigin::Recorded => {}
                TickOrigin::AfterGap => sample.quality_flags = sample.quality_flags.with(QualityFlags::STARTING, true),
                TickOrigin::Missing => continue,
            }
            match &self.correction {
                Some(correction) => {
                    correction.widen(moment.time_s, self.anemometer.anemometer(), &estimate, &mut sample)
                }
                None if moment.known == TickOrigin::AfterGap => {}
                None => self.evidence.add(moment.time_s, &estimate),
            }
            let true_wind_m_s = match self.winds {
                Some(winds) => winds.of(&moment.event),
                None => moment.wind_m_s.filter(|wind| wind.iter().all(|of| of.is_finite())),
            };
            let heat_w = |of: &UnknownHeat| self.anemometer.unknown_heat_w(of.place) as f32;
            let unknown_heat_w: Vec<f32> = self.unknown_heat.iter().map(heat_w).collect();
            self.estimates += 1;
            self.has_truth |= true_wind_m_s.is_some();
            if moment.time_s >= self.options.from_s && moment.time_s - begun_s >= self.options.settle_s {
                self.tally.add(&sample);
                if !sample.quality_flags.has(QualityFlags::NO_GAS) {
                    let is_c = f64::from(sample.gas_c);
                    let [least_c, most_c] = self.gas_c.unwrap_or([is_c; 2]);
                    self.gas_c = Some([least_c.min(is_c), most_c.max(is_c)]);
                }
                if NOT_SETTLED.iter().all(|flag| !sample.quality_flags.has(*flag)) {
                    let each = self.unknown_heat.iter_mut().zip(&unknown_heat_w);
                    each.for_each(|(of, heat_w)| of.add(f64::from(*heat_w)));
                }
                if let Some(truth) = true_wind_m_s {
                    self.comparison.add(&sample, &self.axes, truth);
                }
            }
            return Ok(Some(EstimatedWind { moment, sample, unknown_heat_w, true_wind_m_s }));
        }
        Ok(None)
    }

    /// Statistics of the estimates so far.
    pub fn report(mut self) -> WindReport {
        let slow_errors = self.slow_error_report();
        self.unknown_heat.retain(UnknownHeat::is_known);
        // A constant has been compared at the beginning.
        let measured = self.gas_c.filter(|_| self.gas.constant_c().is_none());
        self.warnings.extend(measured.and_then(|gas_c| self.calibration.gas_difference(gas_c)));
        self.warnings.extend(contradiction(&self.unknown_heat));
        let (gaps, missing_s) = self.replay.gaps;
        let surfaces = self.calibration.network.own.iter().filter(|own| own.surface.is_some());
        let at_one_level = surfaces.filter(|own| self.levels.is_constant(own.element)).map(|own| own.name.clone());
        WindReport {
            at_one_level: at_one_level.collect(),
            warnings: self.warnings,
            recording: self.recording,
            head: self.head.name.clone(),
            made_from: self.calibration.table.made_from.clone(),
            correction: self.calibration.table.correction.as_ref().map(CorrectionTable::sentence),
            in_plane: self.calibration.plane_normal().is_some(),
            estimates: self.estimates,
            output: self.output,
            fixed_because: self.anemometer.fixed,
            gas: self.gas,
            gaps,
            missing_s,
            from_s: self.options.from_s,
            settle_s: self.options.settle_s,
            counted: self.tally.summary(),
            unknown_heat: self.unknown_heat,
            slow_errors,
            comparison: self.has_truth.then_some(self.comparison),
            written: Vec::new(),
        }
    }
}

/// Elements of the network without a surface.
fn cores(calibration: &Calibration) -> Vec<UnknownHeat> {
    let cores = calibration.network.own.iter().filter(|own| own.surface.is_none());
    cores.map(|own| UnknownHeat::new(own.name.clone(), own.element)).collect()
}

/// Bandwidth and interval, the latter a whole number of ticks.
fn output(options: &WindOptions, period_s: f64) -> Result<WindOutput, WindError> {
    let mut output = WindOutput::new(options.bandwidth_hz, options.interval_s, options.fixed, period_s);
    let ticks = output.interval_s / period_s;
    if let Some(interval_s) = options.interval_s
        && !(ticks.is_finite() && ticks > 0.5 && (ticks - ticks.round()).abs() < WHOLE)
    {
        let (below, above) = (ticks.floor().max(1.0) * period_s, (ticks.floor() + 1.0).max(1.0) * period_s);
        let nearest = match interval_s > period_s {
            true => format!("{} s or {} s", tidy(below), tidy(above)),
            false => format!("{} s", tidy(period_s)),
        };
        let periods = format!("sample periods of {} s", tidy(period_s));
        return Err(WindError::Interval(format!(
            "{interval_s} is not a whole number of {periods}: {nearest} would be"
        )));
    }
    // Twelve digits of a product, so that 3 × 0.01 is 0.03.
    let interval_s = ticks.round().max(1.0) * period_s;
    output.interval_s = format!("{interval_s:.11e}").parse().unwrap_or(interval_s);
    Ok(output)
}
