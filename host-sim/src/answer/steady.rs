//! Steady winds of calibration recordings: means of what the windless observer reads off, once each wind has settled.

use std::path::Path;

use dr_core::ConfigError;
use dr_core::control::Tick;
use dr_core::model::{Look, Network, NetworkState};
use wire::MOST_ELEMENTS;

use super::moment::{Known, Moment};
use super::off_line::standing_w;
use super::replay::{Replay, ReplayError};
use super::winds::Winds;
use crate::calibrate::{GasProperties, PartReading, Steady};
use crate::head::Head;
use crate::model::Conditions;
use crate::network::{Observer, ReadingNoise, Windless};
use crate::sensor::Species;
use crate::sensor::gas::{Gas, ZERO_CELSIUS_K};

/// Bandwidth at which a calibration looks, Hz: it has time.
pub const BANDWIDTH_HZ: f64 = 0.5;
/// What no noise says of a mean: the share of it by which drifts and models may be wrong.
const LEAST_ERROR: f64 = 3e-4;
/// Two winds nearer than this in every component are one, m/s.
const SAME_M_S: f64 = 1e-6;

/// What a calibration looks for in its recordings.
pub struct Search<'a> {
    pub head: &'a Head,
    pub windless: &'a Windless,
    pub noise: &'a [ReadingNoise],
    /// Places in the head of the parts' elements, in their order.
    pub parts: &'a [usize],
    /// The element that measures the gas.
    pub reference: Option<usize>,
    /// In which the network was identified.
    pub still: &'a Conditions,
    /// Left out of every wind, s.
    pub settle_s: f64,
    pub winds: Option<&'a Winds>,
}

/// What was found in a recording.
pub struct Found {
    pub steady: Vec<Steady>,
    pub species: Species,
    /// Winds that were left out because they were too short.
    pub short: usize,
}

/// Sums over a steady wind.
struct Sums {
    label: String,
    wind_m_s: [f64; 3],
    from_s: f64,
    period_s: f64,
    rows: u64,
    gas_c: f64,
    convection_w: Vec<f64>,
    surface_c: Vec<f64>,
}

/// A recording, or a run, that is being looked through.
pub struct Looking<'a> {
    search: &'a Search<'a>,
    /// What refusals call it.
    name: String,
    conditions: Conditions,
    observer: Observer,
    network: Network<MOST_ELEMENTS>,
    state: NetworkState<MOST_ELEMENTS>,
    /// Levels since the last tick.
    levels: u16,
    period_s: f64,
    found: Found,
    current: Option<Sums>,
}

impl Search<'_> {
    /// The steady winds of a recording.
    ///
    /// # Errors
    /// If it cannot be read, does not tell its gas or its winds, or holds what the observer cannot be made for.
    pub fn of(&self, path: &Path, each: &mut dyn FnMut(u64)) -> Result<Found, ReplayError> {
        let name = path.display().to_string();
        let mut replay = Replay::open(path, self.head, None)?;
        let conditions = replay.conditions().cloned().ok_or_else(|| {
            ReplayError::Sentence(format!("{name}: does not tell its gas: `gas_species`, `gas_pressure_pa`, `gas_temperature_c` and `support_temperature_c` belong into its metadata (Recordings in docs/manual.md)"))
        })?;
        let mut looking = self.begin(name, conditions, replay.sample_period_s())?;
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

    /// Begins to look through moments that come one by one.
    ///
    /// # Errors
    /// If it is of a gas that is not known, or of other conditions than the network, or the observer cannot be made for its ticks.
    pub fn begin(&self, name: String, conditions: Conditions, period_s: f64) -> Result<Looking<'_>, ReplayError> {
        let refuse = |sentence: String| ReplayError::Sentence(format!("{name}: {sentence}"));
        let species =
            species(&conditions.species).ok_or_else(|| refuse(format!("is of the gas {}", conditions.species)))?;
        let differences = self.still.of_another_network(&conditions);
        if !differences.is_empty() {
            return Err(refuse(format!(
                "was taken {}, for which the network was identified: it holds for one gas and one support",
                differences.join(" and ")
            )));
        }
        let observer = self.windless.observer(BANDWIDTH_HZ, period_s, self.noise).map_err(refuse)?;
        let network = network(&observer, period_s as f32).map_err(|error| refuse(error.to_string()))?;
        Ok(Looking {
            search: self,
            name,
            conditions,
            observer,
            network,
            state: NetworkState::default(),
            levels: 0,
            period_s,
            found: Found { steady: Vec::new(), species, short: 0 },
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

impl Looking<'_> {
    /// Takes a moment in.
    ///
    /// # Errors
    /// If its wind is not known.
    pub fn take(&mut self, moment: &Moment) -> Result<(), ReplayError> {
        let search = self.search;
        let standing_w = std::array::from_fn(|i| standing_w(search.head, i, moment.tick.temperature_c[i]));
        let convection = self.network.step(&mut self.state, &look(&moment.tick, self.levels, &standing_w));
        self.levels = moment.tick.heaters.0;
        if moment.known == Known::Missing {
            return Ok(());
        }
        let wind_m_s = search.wind(moment).ok_or_else(|| {
            ReplayError::Sentence(match search.winds {
                Some(winds) => {
                    format!("{} has no row `{}`, which is a wind of {}", winds.path.display(), moment.event, self.name)
                }
                None => format!(
                    "{}: does not tell the wind of `{}`: give a table of winds with --winds",
                    self.name, moment.event
                ),
            })
        })?;
        let same = |sums: &Sums| {
            sums.label == moment.event && (0..3).all(|k| (sums.wind_m_s[k] - wind_m_s[k]).abs() < SAME_M_S)
        };
        if !self.current.as_ref().is_some_and(same) {
            self.close()?;
            self.current = Some(Sums::new(moment, wind_m_s, self.period_s, search.parts.len()));
        }
        let Some(sums) = &mut self.current else { return Ok(()) };
        if let Some(convection) = convection
            && moment.known == Known::Recorded
            && moment.time_s - sums.from_s >= search.settle_s
        {
            let gas_c = match search.reference {
                Some(reference) => f64::from(moment.tick.temperature_c[reference]),
                None => moment.gas_c.unwrap_or(self.conditions.gas_temperature_c),
            };
            sums.rows += 1;
            sums.gas_c += gas_c;
            for (p, &i) in search.parts.iter().enumerate() {
                sums.convection_w[p] += f64::from(convection.power_w[i]);
                sums.surface_c[p] += f64::from(convection.surface_c[i]);
            }
        }
        Ok(())
    }

    /// What was found.
    ///
    /// # Errors
    /// If the last wind was of a gas that cannot be.
    pub fn finish(mut self) -> Result<Found, ReplayError> {
        self.close()?;
        Ok(self.found)
    }

    /// Means of a wind that is over, if it lasted.
    fn close(&mut self) -> Result<(), ReplayError> {
        let Some(sums) = self.current.take() else { return Ok(()) };
        if sums.rows < 2 {
            self.found.short += 1;
            return Ok(());
        }
        let rows = sums.rows as f64;
        let gas_c = sums.gas_c / rows;
        let gas = Gas::new(self.found.species, self.conditions.pressure_pa, gas_c + ZERO_CELSIUS_K)
            .map_err(|error| ReplayError::Sentence(format!("`{}`: {error}", sums.label)))?;
        let parts: Vec<PartReading> = (self.search.parts.iter().enumerate())
            .map(|(p, &i)| {
                let power_w = sums.convection_w[p] / rows;
                let surface_c = sums.surface_c[p] / rows;
                let own = &self.observer.own;
                let sd_w = own.iter().position(|(own, _)| *own == i).map_or(0.0, |at| self.observer.sd_w[at]);
                // So many independent looks as the bandwidth lets through, π/2 a hertz and second.
                let looks = (rows * sums.period_s * std::f64::consts::PI * BANDWIDTH_HZ).max(1.0);
                let least_w = LEAST_ERROR * power_w.abs().max(1e-3);
                PartReading {
                    power_w,
                    overheat_k: surface_c - gas_c,
                    above_reference_k: surface_c - self.search.still.gas_temperature_c,
                    variance_w2: sd_w * sd_w / looks + least_w * least_w,
                }
            })
            .collect();
        self.found.steady.push(Steady {
            label: sums.label,
            wind_m_s: sums.wind_m_s,
            gas: GasProperties {
                density_kg_m3: gas.density_kg_m3,
                viscosity_pa_s: gas.viscosity_pa_s,
                conductivity_w_m_k: gas.conductivity_w_m_k,
            },
            parts,
        });
        Ok(())
    }
}

impl Sums {
    fn new(moment: &Moment, wind_m_s: [f64; 3], period_s: f64, parts: usize) -> Self {
        Self {
            label: moment.event.clone(),
            wind_m_s,
            from_s: moment.time_s,
            period_s,
            rows: 0,
            gas_c: 0.0,
            convection_w: vec![0.0; parts],
            surface_c: vec![0.0; parts],
        }
    }
}

/// The windless network of an observer, as the board has it.
fn network(observer: &Observer, sample_period_s: f32) -> Result<Network<MOST_ELEMENTS>, ConfigError> {
    let mut network = Network::default();
    for (element, config) in &observer.own {
        network.set_own(*element, config, sample_period_s)?;
    }
    for cross in &observer.cross {
        network.set_cross(cross, sample_period_s)?;
    }
    Ok(network)
}

/// A tick as the network looks at it.
fn look<'a>(
    tick: &'a Tick<MOST_ELEMENTS>,
    read_high: u16,
    standing_w: &'a [f32; MOST_ELEMENTS],
) -> Look<'a, MOST_ELEMENTS> {
    Look { temperature_c: &tick.temperature_c, valid: tick.valid, read_high, power_w: &tick.power_w, standing_w }
}

/// A gas by the name that recordings have for it.
pub fn species(name: &str) -> Option<Species> {
    [Species::CarbonDioxide, Species::Air].into_iter().find(|species| species.name() == name)
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
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fixtures/sphere-b-calibrated.toml");
        let head = Head::read(&path).unwrap();
        let calibration = head.calibration.as_ref().unwrap();
        let still = mars();
        let search = Search {
            head: &head,
            windless: &calibration.windless,
            noise: &calibration.noise,
            parts: &calibration.parts,
            reference: calibration.reference,
            still: &still,
            settle_s: 0.0,
            winds: None,
        };
        let begun = |conditions: Conditions| search.begin("t.parquet".to_owned(), conditions, 1e-3).map(|_| ());
        // What a calibration reckons with.
        begun(Conditions { pressure_pa: 700.0, gas_temperature_c: -40.0, ..mars() }).unwrap();
        let refused = begun(Conditions { support_temperature_c: -18.15, ..mars() }).unwrap_err().to_string();
        assert_eq!(
            refused,
            "t.parquet: was taken with its support at -18.15 °C instead of -43.15 °C, for which the network was identified: \
             it holds for one gas and one support"
        );
        let refused = begun(Conditions { species: "air".to_owned(), ..mars() }).unwrap_err().to_string();
        assert!(refused.contains("was taken in air instead of co2"), "{refused}");
    }
}
