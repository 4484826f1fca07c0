//! Steady winds of calibration recordings: means of what the quiescent-gas observer reads off, once
//! each wind has settled.

use std::path::{Path, PathBuf};

use dr_core::control::MOST_ELEMENTS;
use dr_core::model::{ConvectionObserver, ConvectionObserverState, TickInput};

use super::steady_wind::{SteadyWind, SurfaceReading};
use crate::gas::{IdealGas, Species, ZERO_CELSIUS_K};
use crate::head::file::Head;
use crate::network::observer::NetworkObserver;
use crate::network::parameters::QuiescentNetwork;
use crate::wind::given_winds::GivenWinds;
use crate::wind::moment::{Moment, TickOrigin};
use crate::wind::off_line::standing_w;
use crate::wind::replay::Replay;
use diffusive::model::Conditions;
use recording::RecordingError;

/// Bandwidth of the convective powers, Hz: a calibration has time.
pub const BANDWIDTH_HZ: f64 = 0.5;
/// Least relative error of a mean, by drifts and models.
const LEAST_ERROR: f64 = 3e-4;
/// Two winds nearer than this in every component are one, m/s.
const SAME_M_S: f64 = 1e-6;

/// A head whose convective powers can be read off.
pub struct ObservedHead<'a> {
    /// The head.
    pub head: &'a Head,
    /// Its quiescent-gas network.
    pub network: QuiescentNetwork,
    /// Places in the head of the surfaces' elements, in their order.
    pub surfaces: Vec<usize>,
    /// The element that measures the gas.
    pub reference: Option<usize>,
    /// The gas.
    pub species: Species,
    /// Conditions in which the network was identified.
    pub quiescent: Conditions,
}

/// Search for steady winds in the recordings of a head.
pub struct SteadyWindSearch<'a> {
    /// The head.
    pub observed: &'a ObservedHead<'a>,
    /// Left out at the beginning of every wind, s.
    pub settle_s: f64,
    /// Given winds; by default those of the recordings.
    pub winds: Option<&'a GivenWinds>,
}

/// Steady winds of a head.
#[derive(Default)]
pub struct SteadyWinds {
    /// In the order of time.
    pub steady: Vec<SteadyWind>,
    /// Winds that were left out because they were too short.
    pub short: usize,
}

/// Sums over a steady wind.
struct WindSums {
    label: String,
    wind_m_s: [f64; 3],
    from_s: f64,
    rows: u64,
    gas_c: f64,
    convection_w: Vec<f64>,
    surface_c: Vec<f64>,
}

/// Collects the steady winds of one recording, or of a run while it goes on.
pub struct SteadyWindCollector<'a> {
    search: &'a SteadyWindSearch<'a>,
    /// The recording, for errors.
    recording: PathBuf,
    conditions: Conditions,
    observer: NetworkObserver,
    network: ConvectionObserver<MOST_ELEMENTS>,
    state: ConvectionObserverState<MOST_ELEMENTS>,
    /// Levels since the last tick.
    levels: usize,
    period_s: f64,
    found: SteadyWinds,
    current: Option<WindSums>,
}

impl SteadyWindSearch<'_> {
    /// The steady winds of all recordings; `each` is called with the number of recordings that are
    /// done.
    ///
    /// # Errors
    /// As those of a single recording.
    pub fn of_all(&self, paths: &[PathBuf], each: &mut dyn FnMut(usize)) -> Result<SteadyWinds, RecordingError> {
        let mut all = SteadyWinds::default();
        for (n, path) in paths.iter().enumerate() {
            let found = self.of(path, &mut |_| each(n))?;
            all.steady.extend(found.steady);
            all.short += found.short;
            each(n + 1);
        }
        Ok(all)
    }

    /// The steady winds of a recording.
    ///
    /// # Errors
    /// If it cannot be read, does not name its gas or its winds, or the network cannot be observed.
    pub fn of(&self, path: &Path, each: &mut dyn FnMut(u64)) -> Result<SteadyWinds, RecordingError> {
        let mut replay = Replay::open(path, self.observed.head, None)?;
        let conditions = replay.conditions.clone().ok_or_else(|| RecordingError::new(
            path,
            "does not tell its gas: `gas_species`, `gas_pressure_pa`, `gas_temperature_c` and `support_temperature_c` belong into its metadata (docs/reference/recordings.md)",
        ))?;
        let mut looking = self.begin(path, conditions, replay.sample_period_s)?;
        let mut rows = 0;
        while let Some(moment) = replay.next_moment()? {
            looking.take(&moment)?;
            rows += 1;
            if rows % 65_536 == 0 {
                each(rows);
            }
        }
        looking.finish()
    }

    /// Begins with moments that come one by one.
    ///
    /// # Errors
    /// If its conditions are others than the network's, or the network cannot be observed.
    pub fn begin(
        &self,
        recording: &Path,
        conditions: Conditions,
        period_s: f64,
    ) -> Result<SteadyWindCollector<'_>, RecordingError> {
        let refuse = |sentence: String| RecordingError::new(recording, sentence);
        // Heat from another support is found where there are cores.
        let quiescent = &self.observed.quiescent;
        let support_temperature_c = match self.observed.network.has_cores() {
            true => quiescent.support_temperature_c,
            false => conditions.support_temperature_c,
        };
        let differences = quiescent.of_another_network(&Conditions { support_temperature_c, ..conditions.clone() });
        if !differences.is_empty() {
            return Err(refuse(format!(
                "was taken {}, for which the network was identified: it holds for one gas and one support",
                differences.join(" and ")
            )));
        }
        let observer = self.observed.network.stable_observer(BANDWIDTH_HZ, period_s);
        let observer = observer.map_err(|error| refuse(error.to_string()))?;
        let network = observer.board(period_s as f32).map_err(|error| refuse(error.to_string()))?;
        Ok(SteadyWindCollector {
            search: self,
            recording: recording.to_owned(),
            conditions,
            observer,
            network,
            state: ConvectionObserverState::default(),
            levels: 0,
            period_s,
            found: SteadyWinds::default(),
            current: None,
        })
    }

    fn wind(&self, moment: &Moment) -> Option<[f64; 3]> {
        match self.winds {
            Some(winds) => winds.of(&moment.event),
            None => moment.wind_m_s,
        }
    }
}

impl SteadyWindCollector<'_> {
    /// Adds a moment.
    ///
    /// # Errors
    /// If its wind is not known.
    pub fn take(&mut self, moment: &Moment) -> Result<(), RecordingError> {
        let (search, observed, tick) = (self.search, self.search.observed, &moment.tick);
        let input = TickInput {
            temperature_c: &tick.temperature_c,
            valid: tick.valid,
            read_high: self.levels,
            power_w: &tick.power_w,
            standing_w: &std::array::from_fn(|i| standing_w(observed.head, i, tick.temperature_c[i])),
        };
        if moment.state.starts_with("tripped") {
            let sentence = format!(
                "is in state `{}` from {:.2} s on, during `{}`: cut it there",
                moment.state, moment.time_s, moment.event
            );
            return Err(RecordingError::new(&self.recording, sentence));
        }
        let convection = self.network.step(&mut self.state, &input);
        self.levels = tick.heaters.0;
        if moment.known == TickOrigin::Missing {
            return Ok(());
        }
        let wind_m_s = search.wind(moment).ok_or_else(|| {
            let (label, recording) = (&moment.event, &self.recording);
            let (path, sentence) = match search.winds {
                Some(winds) => {
                    (&winds.path, format!("has no row `{label}`, which is a wind of {}", recording.display()))
                }
                None => (recording, format!("does not tell the wind of `{label}`: give a table of winds with --winds")),
            };
            RecordingError::new(path, sentence)
        })?;
        let same = |sums: &WindSums| {
            sums.label == moment.event && (0..3).all(|k| (sums.wind_m_s[k] - wind_m_s[k]).abs() < SAME_M_S)
        };
        if !self.current.as_ref().is_some_and(same) {
            self.close()?;
            let none = vec![0.0; observed.surfaces.len()];
            self.current = Some(WindSums {
                label: moment.event.clone(),
                wind_m_s,
                from_s: moment.time_s,
                rows: 0,
                gas_c: 0.0,
                convection_w: none.clone(),
                surface_c: none,
            });
        }
        let Some(sums) = &mut self.current else { return Ok(()) };
        if let Some(convection) = convection
            && moment.known == TickOrigin::Recorded
            && moment.time_s - sums.from_s >= search.settle_s
        {
            let gas_c = match observed.reference {
                Some(reference) => f64::from(tick.temperature_c[reference]),
                None => moment.gas_c.unwrap_or(self.conditions.gas_temperature_c),
            };
            sums.rows += 1;
            sums.gas_c += gas_c;
            for (p, &i) in observed.surfaces.iter().enumerate() {
                sums.convection_w[p] += f64::from(convection.power_w[i]);
                sums.surface_c[p] += f64::from(convection.surface_c[i]);
            }
        }
        Ok(())
    }

    /// The steady winds.
    ///
    /// # Errors
    /// If the last wind was of a gas that cannot be.
    pub fn finish(mut self) -> Result<SteadyWinds, RecordingError> {
        self.close()?;
        Ok(self.found)
    }

    /// Means of a wind that is over, if it lasted.
    fn close(&mut self) -> Result<(), RecordingError> {
        let Some(sums) = self.current.take() else { return Ok(()) };
        if sums.rows < 2 {
            self.found.short += 1;
            return Ok(());
        }
        let rows = sums.rows as f64;
        let gas_c = sums.gas_c / rows;
        let gas = IdealGas::new(self.search.observed.species, self.conditions.pressure_pa, gas_c + ZERO_CELSIUS_K)
            .map_err(|error| RecordingError::new(&self.recording, format!("`{}`: {error}", sums.label)))?;
        let observed = self.search.observed;
        let surfaces: Vec<SurfaceReading> = (observed.surfaces.iter().enumerate())
            .map(|(p, &i)| {
                let power_w = sums.convection_w[p] / rows;
                let surface_c = sums.surface_c[p] / rows;
                let sd_w = self.observer.noise_w(i).unwrap_or(0.0);
                // So many independent looks as the bandwidth lets through, π/2 a hertz and second.
                let looks = (rows * self.period_s * std::f64::consts::PI * BANDWIDTH_HZ).max(1.0);
                let least_w = LEAST_ERROR * power_w.abs().max(1e-3);
                SurfaceReading {
                    power_w,
                    overheat_k: surface_c - gas_c,
                    above_reference_k: surface_c - observed.quiescent.gas_temperature_c,
                    variance_w2: sd_w * sd_w / looks + least_w * least_w,
                }
            })
            .collect();
        self.found.steady.push(SteadyWind { label: sums.label, wind_m_s: sums.wind_m_s, gas, surfaces });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The conditions of the identification of sphere B.
    fn mars() -> Conditions {
        Conditions {
            species: "co2".to_owned(),
            pressure_pa: 1000.0,
            gas_temperature_c: -53.15,
            support_temperature_c: -43.15,
        }
    }

    #[test]
    fn a_recording_of_other_conditions_than_the_networks_is_refused() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/sphere-b-calibrated.toml");
        let head = Head::read(&path).unwrap();
        let calibration = head.calibration.as_ref().unwrap();
        let mut observed = ObservedHead {
            head: &head,
            network: calibration.network.clone(),
            surfaces: calibration.surfaces.clone(),
            reference: calibration.reference,
            species: calibration.table.species,
            quiescent: mars(),
        };
        let begun = |observed: &ObservedHead<'_>, conditions: Conditions| {
            let search = SteadyWindSearch { observed, settle_s: 0.0, winds: None };
            search.begin(Path::new("t.parquet"), conditions, 1e-3).map(|_| ())
        };
        let warm = Conditions { support_temperature_c: -18.15, ..mars() };
        // Pressure and temperature may differ, and the support, whose heat the cores find.
        begun(&observed, Conditions { pressure_pa: 700.0, gas_temperature_c: -40.0, ..mars() }).unwrap();
        begun(&observed, warm.clone()).unwrap();
        let air = Conditions { species: "air".to_owned(), ..mars() };
        let refused = begun(&observed, air).unwrap_err().to_string();
        assert!(refused.contains("was taken in air instead of co2"), "{refused}");
        observed.network.own.retain(|own| own.surface.is_some());
        let refused = begun(&observed, warm).unwrap_err().to_string();
        assert_eq!(
            refused,
            "t.parquet: was taken with its support at -18.15 °C instead of -43.15 °C, for which the network was identified: \
             it holds for one gas and one support"
        );
    }
}
