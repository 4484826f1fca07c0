//! The calibration of a head: what it takes to answer with the wind.
//!
//! The table `[calibration]` stands at the end of a head file, where `anemo calibrate` writes it:
//!
//! | table | keys |
//! |---|---|
//! | `[calibration]` | `made_from` (in words), `species`, `reference_gas_c` (gas of the windless identification), `diameter_m`, `direction_error_max_deg`, optionally `reference` (the element that measures the gas) |
//! | `[calibration.nusselt]` | `least_reynolds`, `most_reynolds`, `amplitudes` (32 rows of a_0 … a_5); without it the head answers with conductances only |
//! | `[calibration.card]` | in its place for four dice on a card: `least_reynolds`, `most_reynolds`, `mean` and `difference` (12 values over √Re from 0), `along`, `around`, `seen` (8 harmonics each), `mean_share`, `difference_share`; see [`dr_core::sensor::wind::card`] |
//! | `[[calibration.parts]]` | `element`, `axis` and `corner` in the tunnel's frame, `area_m2`, `means`, `threefold`, `gain`, `windless_w_k` |
//! | `[[calibration.own]]` | `element`, `rest_c`, `noise_k` (low and high level), `mesh_rad_s`, `r_k_per_w`, `surface` (m_k, for what the wind cools) |
//! | `[[calibration.cross]]` | `from`, `to`, `mesh_rad_s`, `r_k_per_w`, `surface` |
//!
//! It holds for the gas's species, and for the temperature of the support of the identification; see [`dr_core::control::anemometer`]
//! and [`dr_core::model::network`] for what the numbers do.

mod checks;
mod table;

use dr_core::control::anemometer::MOST_PARTS;
use dr_core::control::{AnswerConfig, PartOfHead, WindCommand};
use dr_core::sensor::wind::nusselt::POINTS;
use dr_core::sensor::wind::{CardConfig, PartConfig};
use serde::Serialize;

use super::Element;
use crate::network::windless::{Cross, Own};
use crate::network::{Observer, ReadingNoise, Windless, gas_law};
use crate::sensor::Species;
use crate::sensor::gas::{TEMPERATURE_RANGE_K, ZERO_CELSIUS_K};
use crate::toml_file::{FileError, Source, suggest};
pub use table::CalibrationTable;
pub use table::CardTable;
use table::{CrossTable, NusseltTable, OwnTable, PartTable};

/// The gas is known so far on either side of the reference, K: further than any place on Mars goes in a year.
const GAS_RANGE_K: f64 = 70.0;
/// Temperatures of a gas whose properties are known, °C.
const GAS_C: std::ops::RangeInclusive<f64> =
    *TEMPERATURE_RANGE_K.start() - ZERO_CELSIUS_K..=*TEMPERATURE_RANGE_K.end() - ZERO_CELSIUS_K;
/// Smoothing time of the reference's readings, s.
const REFERENCE_SMOOTHING_S: f64 = 1.0;

/// How fast and how often a calibrated head answers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answering {
    /// −3 dB of the convective powers, Hz.
    pub bandwidth_hz: f64,
    pub every_s: f64,
    /// Whether the bandwidth stays, whatever the wind does; else it rises for a while after a jump.
    pub fixed: bool,
}

impl Answering {
    pub const DEFAULT_BANDWIDTH_HZ: f64 = 2.0;
    /// Bandwidths that a head may be asked for.
    pub const BANDWIDTHS_HZ: std::ops::RangeInclusive<f64> = 0.5..=50.0;
    const DEFAULT_EVERY_S: f64 = 0.01;

    /// What is not asked for is as fast as the loops and smooth enough to be looked at.
    pub fn new(bandwidth_hz: Option<f64>, every_s: Option<f64>, fixed: bool, sample_period_s: f64) -> Self {
        Self {
            bandwidth_hz: bandwidth_hz.unwrap_or(Self::DEFAULT_BANDWIDTH_HZ),
            every_s: every_s.unwrap_or(Self::DEFAULT_EVERY_S.max(sample_period_s)),
            fixed,
        }
    }
}

/// A checked calibration, in f64.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    table: CalibrationTable,
    pub species: Species,
    /// Place in the head of the element that measures the gas.
    pub reference: Option<usize>,
    /// Places in the head of the elements of the parts.
    pub parts: Vec<usize>,
    pub windless: Windless,
    /// By element of the head.
    pub noise: Vec<ReadingNoise>,
}

/// A part as a calibration found it.
#[derive(Debug, Clone, PartialEq)]
pub struct NewPart {
    pub element: String,
    pub surface: PartConfig,
    pub gain: f64,
    pub windless_w_k: f64,
}

/// How conductances depend on the wind.
#[derive(Debug, Clone, PartialEq)]
pub enum Curves {
    /// Of a sphere: least and greatest Reynolds number, and the amplitudes between them.
    Nusselt(f64, f64, Vec<[f64; 6]>),
    Card(Box<CardTable>),
}

/// All of a new calibration.
#[derive(Debug, Clone, PartialEq)]
pub struct NewCalibration<'a> {
    pub made_from: String,
    pub species: Species,
    pub reference_gas_c: f64,
    pub diameter_m: f64,
    pub direction_error_max_deg: f64,
    pub reference: Option<String>,
    pub curves: Curves,
    pub parts: Vec<NewPart>,
    pub windless: &'a Windless,
    pub noise: &'a [ReadingNoise],
    /// Names of the head's elements.
    pub names: &'a [&'a str],
}

impl Calibration {
    pub(super) fn from_table(
        source: &Source,
        table: CalibrationTable,
        elements: &[Element],
    ) -> Result<Self, FileError> {
        let names: Vec<&str> = elements.iter().map(|element| element.name.as_str()).collect();
        let place = |key: String, name: &str| {
            names.iter().position(|known| *known == name).ok_or_else(|| {
                let hint = suggest(name, names.iter().copied());
                source.refuse(&key, format!("is `{name}`, which is no element of this head; {hint}"))
            })
        };
        let species = match table.species.as_str() {
            "co2" => Species::CarbonDioxide,
            "air" => Species::Air,
            other => return Err(source.refuse("calibration.species", format!("is `{other}`: known are co2 and air"))),
        };
        source.within("calibration.direction_error_max_deg", table.direction_error_max_deg, 0.01..=90.0, "°")?;
        let reference =
            table.reference.as_ref().map(|name| place("calibration.reference".to_owned(), name)).transpose()?;
        if ![2, MOST_PARTS].contains(&table.parts.len()) {
            let sentence = format!("are {}: four sectors, two hemispheres or four dice belong here", table.parts.len());
            return Err(source.refuse("calibration.parts", sentence));
        }
        let parts: Vec<usize> = (table.parts.iter().enumerate())
            .map(|(i, part)| place(format!("calibration.parts[{i}].element"), &part.element))
            .collect::<Result<_, _>>()?;
        if let Some(nusselt) = &table.nusselt
            && nusselt.amplitudes.len() != POINTS
        {
            let sentence = format!("has {} rows: {POINTS} belong here", nusselt.amplitudes.len());
            return Err(source.refuse("calibration.nusselt.amplitudes", sentence));
        }
        if table.card.is_some() && (table.nusselt.is_some() || table.parts.len() != MOST_PARTS) {
            let sentence = "belongs to four dice on a card, which have no [calibration.nusselt]";
            return Err(source.refuse("calibration.card", sentence));
        }
        let mut own = Vec::with_capacity(table.own.len());
        let mut noise = vec![ReadingNoise { low_k: 1e-3, high_k: 1e-3 }; elements.len()];
        for (i, of) in table.own.iter().enumerate() {
            let key = format!("calibration.own[{i}]");
            let element = place(format!("{key}.element"), &of.element)?;
            for noise_k in of.noise_k {
                source.positive(&format!("{key}.noise_k"), noise_k, "K")?;
            }
            noise[element] = ReadingNoise { low_k: of.noise_k[0], high_k: of.noise_k[1] };
            same_length(source, &key, &of.mesh_rad_s, &of.r_k_per_w)?;
            if let Some(surface) = &of.surface {
                same_length(source, &key, &of.mesh_rad_s, surface)?;
            }
            own.push(of.own(element));
        }
        let mut cross = Vec::with_capacity(table.cross.len());
        for (i, of) in table.cross.iter().enumerate() {
            let key = format!("calibration.cross[{i}]");
            let (from, to) = (place(format!("{key}.from"), &of.from)?, place(format!("{key}.to"), &of.to)?);
            same_length(source, &key, &of.mesh_rad_s, &of.r_k_per_w)?;
            same_length(source, &key, &of.mesh_rad_s, &of.surface)?;
            let (mesh_rad_s, r_k_per_w) = (of.mesh_rad_s.clone(), of.r_k_per_w.clone());
            cross.push(Cross { from, to, mesh_rad_s, r_k_per_w, surface: of.surface.clone() });
        }
        checks::Checked { source, table: &table, reference, parts: &parts, own: &own, cross: &cross }.check()?;
        Ok(Self { species, reference, parts, windless: Windless { own, cross }, noise, table })
    }

    /// What an anemometer is told of its head, in the order in which it has to be told; beside it how noisy the convective powers are.
    ///
    /// # Errors
    /// A sentence: which bandwidth cannot be had, or what of the gas is not known.
    pub fn commands(
        &self,
        answering: &Answering,
        sample_period_s: f64,
    ) -> Result<(Vec<WindCommand>, Observer), String> {
        let observer = match answering.fixed {
            true => self.windless.observer(answering.bandwidth_hz, sample_period_s, &self.noise)?,
            false => self.windless.adaptive_observer(answering.bandwidth_hz, sample_period_s, &self.noise)?,
        };
        let mut commands = Vec::new();
        for (element, config) in &observer.own {
            commands.push(WindCommand::Own { element: *element as u8, config: *config });
        }
        commands.extend(observer.faster.iter().copied().map(WindCommand::Faster));
        commands.extend(observer.cross.iter().copied().map(WindCommand::Cross));
        if let Some(nusselt) = &self.table.nusselt {
            for (point, amplitudes) in (0_u8..).zip(&nusselt.amplitudes) {
                commands.push(WindCommand::Point { point, amplitudes: amplitudes.map(|a| a as f32) });
            }
        }
        if let Some(card) = &self.table.card {
            commands.push(WindCommand::Card(card.config()));
        }
        for (part, (of, &element)) in (0_u8..).zip(self.table.parts.iter().zip(&self.parts)) {
            let config = PartOfHead {
                element: element as u8,
                surface: of.surface(),
                gain: of.gain as f32,
                windless_w_k: of.windless_w_k as f32,
            };
            commands.push(WindCommand::Part { part, config });
        }
        let [least_c, most_c] = self.gas_range_c();
        let law = gas_law(self.species, least_c, most_c).map_err(|error| error.to_string())?;
        commands.push(WindCommand::GasLaw(law));
        commands.push(WindCommand::Answer(self.answer(answering, sample_period_s)?));
        Ok((commands, observer))
    }

    fn answer(&self, answering: &Answering, sample_period_s: f64) -> Result<AnswerConfig, String> {
        let every = (answering.every_s / sample_period_s).round();
        if !(1.0..=f64::from(u16::MAX)).contains(&every) {
            return Err(format!(
                "an answer every {} s cannot be had from ticks of {sample_period_s} s: between one and {} of them",
                answering.every_s,
                u16::MAX
            ));
        }
        let sphere = self.table.nusselt.as_ref().map(|of| [of.least_reynolds, of.most_reynolds]);
        let card = self.table.card.as_ref().map(|of| [of.least_reynolds, of.most_reynolds]);
        let reynolds = sphere.or(card).map(|both| both.map(|reynolds| reynolds as f32));
        Ok(AnswerConfig {
            parts: self.parts.len() as u8,
            diameter_m: self.table.diameter_m as f32,
            reynolds,
            direction_error_max_rad: self.table.direction_error_max_deg.to_radians() as f32,
            every_ticks: every as u16,
            reference: self.reference.map(|element| element as u8),
            smoothing_s: [REFERENCE_SMOOTHING_S, 0.5 / std::f64::consts::PI / answering.bandwidth_hz].map(|s| s as f32),
            reference_gas_c: self.table.reference_gas_c as f32,
        })
    }

    /// Outward normal of the card, for a head that tells the wind in a card's plane only.
    pub fn card_normal(&self) -> Option<[f64; 3]> {
        self.table.card.as_ref().and(self.table.parts.first()).map(|part| part.axis)
    }

    /// In words.
    pub fn made_from(&self) -> &str {
        &self.table.made_from
    }

    fn gas_range_c(&self) -> [f64; 2] {
        let (least_c, most_c) = (*GAS_C.start(), *GAS_C.end());
        let reference_c = self.table.reference_gas_c;
        [(reference_c - GAS_RANGE_K).max(least_c), (reference_c + GAS_RANGE_K).min(most_c)]
    }
}

impl NewCalibration<'_> {
    /// The table, as the end of a head file.
    ///
    /// # Errors
    /// If it cannot be written as TOML.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        #[derive(Serialize)]
        struct Tail {
            calibration: CalibrationTable,
        }
        toml::to_string(&Tail { calibration: self.table() })
    }

    /// The head's file with this calibration at its end, and the head that it makes.
    ///
    /// # Errors
    /// A sentence: why it cannot be read again.
    pub fn with_head(&self, head: &super::Head) -> Result<(String, super::Head), String> {
        let tail = self.to_toml().map_err(|error| error.to_string())?;
        let text = format!("{}\n{tail}", without_calibration(&head.source.text).trim_end());
        // What cannot be read again is not written.
        let source = Source { path: head.source.path.clone(), text: text.clone() };
        let made = super::Head::from_source(source).map_err(|error| error.to_string())?;
        Ok((text, made))
    }

    fn table(&self) -> CalibrationTable {
        let name = |element: usize| self.names.get(element).copied().unwrap_or_default().to_owned();
        let (nusselt, card) = match self.curves.clone() {
            Curves::Nusselt(least_reynolds, most_reynolds, amplitudes) => {
                (Some(NusseltTable { least_reynolds, most_reynolds, amplitudes }), None)
            }
            Curves::Card(card) => (None, Some(*card)),
        };
        CalibrationTable {
            made_from: self.made_from.clone(),
            species: self.species.name().to_owned(),
            reference_gas_c: self.reference_gas_c,
            diameter_m: self.diameter_m,
            direction_error_max_deg: self.direction_error_max_deg,
            reference: self.reference.clone(),
            nusselt,
            card,
            parts: self.parts.iter().map(PartTable::of).collect(),
            own: self
                .windless
                .own
                .iter()
                .map(|own| OwnTable {
                    element: name(own.element),
                    rest_c: own.rest_c,
                    noise_k: self.noise.get(own.element).map_or([1e-3; 2], |noise| [noise.low_k, noise.high_k]),
                    mesh_rad_s: own.mesh_rad_s.clone(),
                    r_k_per_w: own.r_k_per_w.clone(),
                    surface: own.surface.clone(),
                })
                .collect(),
            cross: self
                .windless
                .cross
                .iter()
                .map(|cross| CrossTable {
                    from: name(cross.from),
                    to: name(cross.to),
                    mesh_rad_s: cross.mesh_rad_s.clone(),
                    r_k_per_w: cross.r_k_per_w.clone(),
                    surface: cross.surface.clone(),
                })
                .collect(),
        }
    }
}

impl CardTable {
    pub fn config(&self) -> CardConfig {
        CardConfig {
            mean: self.mean.map(|x| x as f32),
            difference: self.difference.map(|x| x as f32),
            along: self.along.map(|x| x as f32),
            around: self.around.map(|x| x as f32),
            seen: self.seen.map(|x| x as f32),
            mean_share: self.mean_share as f32,
            difference_share: self.difference_share as f32,
        }
    }
}

impl OwnTable {
    fn own(&self, element: usize) -> Own {
        Own {
            element,
            name: self.element.clone(),
            rest_c: self.rest_c,
            mesh_rad_s: self.mesh_rad_s.clone(),
            r_k_per_w: self.r_k_per_w.clone(),
            layers: Vec::new(),
            surface: self.surface.clone(),
        }
    }
}

impl PartTable {
    fn of(part: &NewPart) -> Self {
        let PartConfig { axis, corner, area_m2, means, threefold } = part.surface;
        Self {
            element: part.element.clone(),
            axis: axis.map(f64::from),
            corner: corner.map(f64::from),
            area_m2: area_m2.into(),
            means: means.map(f64::from),
            threefold: threefold.map(f64::from),
            gain: part.gain,
            windless_w_k: part.windless_w_k,
        }
    }

    fn surface(&self) -> PartConfig {
        PartConfig {
            axis: self.axis.map(|x| x as f32),
            corner: self.corner.map(|x| x as f32),
            area_m2: self.area_m2 as f32,
            means: self.means.map(|x| x as f32),
            threefold: self.threefold.map(|x| x as f32),
        }
    }
}

fn same_length(source: &Source, key: &str, mesh: &[f64], other: &[f64]) -> Result<(), FileError> {
    if mesh.len() == other.len() && !mesh.is_empty() {
        return Ok(());
    }
    let sentence = format!("has {} rates and {} numbers that belong to them", mesh.len(), other.len());
    Err(source.refuse(key, sentence))
}

/// A head's text without a calibration that stands at its end.
pub fn without_calibration(text: &str) -> &str {
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        if line.trim_start().starts_with("[calibration") {
            return &text[..at];
        }
        at += line.len();
    }
    text
}
