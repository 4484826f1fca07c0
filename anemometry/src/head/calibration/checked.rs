//! A checked calibration, in f64.

use dr_core::wind::MOST_SURFACES;
use dr_core::wind::nusselt::POINTS;

use super::checks::CalibrationChecks;
use super::keys::CalibrationKeys;
use super::table::{CalibrationTable, SelfHeatingTable};
use crate::gas::Species;
use crate::head::element::HeadElement;
use crate::network::kalman::ReadingNoise;
use crate::network::parameters::{CrossHeatingParameters, QuiescentNetwork, SelfHeatingParameters};
use recording::text::suggest;
use recording::toml_file::{FileError, TomlSource};

/// A checked calibration, in f64.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    pub(super) table: CalibrationTable,
    /// The gas that it holds for.
    pub species: Species,
    /// Place in the head of the element that measures the gas.
    pub reference: Option<usize>,
    /// Places in the head of the elements of the surfaces.
    pub surfaces: Vec<usize>,
    /// The quiescent-gas network.
    pub network: QuiescentNetwork,
    /// Noise of readings, by element of the head.
    pub noise: Vec<ReadingNoise>,
}

impl Calibration {
    /// The calibration of a table.
    ///
    /// # Errors
    /// The key and line of what is not known, stands twice or cannot be.
    pub fn from_table(
        source: &TomlSource,
        table: CalibrationTable,
        elements: &[HeadElement],
    ) -> Result<Self, FileError> {
        let keys = CalibrationKeys(source);
        let names: Vec<&str> = elements.iter().map(|element| element.name.as_str()).collect();
        let place = |key: String, name: &str| {
            names.iter().position(|known| *known == name).ok_or_else(|| {
                let hint = suggest(name, names.iter().copied());
                keys.refuse(&key, format!("is `{name}`, which is no element of this head; {hint}"))
            })
        };
        let species = match table.species.as_str() {
            "co2" => Species::CarbonDioxide,
            "air" => Species::Air,
            other => return Err(keys.refuse("calibration.species", format!("is `{other}`: known are co2 and air"))),
        };
        keys.within("calibration.direction_error_max_deg", table.direction_error_max_deg, 0.01..=90.0, "°")?;
        let reference =
            table.reference.as_ref().map(|name| place("calibration.reference".to_owned(), name)).transpose()?;
        if ![2, MOST_SURFACES].contains(&table.surfaces.len()) {
            let sentence =
                format!("are {}: four sectors, two hemispheres or four dice belong here", table.surfaces.len());
            return Err(keys.refuse("calibration.surfaces", sentence));
        }
        let surfaces: Vec<usize> = (table.surfaces.iter().enumerate())
            .map(|(i, of)| place(format!("calibration.surfaces[{i}].element"), &of.element))
            .collect::<Result<_, _>>()?;
        if let Some(nusselt) = &table.nusselt
            && nusselt.amplitudes.len() != POINTS
        {
            let sentence = format!("has {} rows: {POINTS} belong here", nusselt.amplitudes.len());
            return Err(keys.refuse("calibration.nusselt.amplitudes", sentence));
        }
        if table.card.is_some() && (table.nusselt.is_some() || table.surfaces.len() != MOST_SURFACES) {
            let sentence = "belongs to four dice on a card, which have no [calibration.nusselt]";
            return Err(keys.refuse("calibration.card", sentence));
        }
        let mut own = Vec::with_capacity(table.self_heating.len());
        let mut noise = vec![ReadingNoise { low_k: 1e-3, high_k: 1e-3 }; elements.len()];
        for (i, of) in table.self_heating.iter().enumerate() {
            let key = format!("calibration.self_heating[{i}]");
            let element = place(format!("{key}.element"), &of.element)?;
            for noise_k in of.noise_k {
                keys.positive(&format!("{key}.noise_k"), noise_k, "K")?;
            }
            noise[element] = ReadingNoise { low_k: of.noise_k[0], high_k: of.noise_k[1] };
            same_length(keys, &key, &of.mesh_rad_s, &of.r_k_per_w)?;
            if let Some(surface) = &of.surface {
                same_length(keys, &key, &of.mesh_rad_s, surface)?;
            }
            own.push(self_heating(of, element));
        }
        let mut cross = Vec::with_capacity(table.cross_heating.len());
        for (i, of) in table.cross_heating.iter().enumerate() {
            let key = format!("calibration.cross_heating[{i}]");
            let (from, to) = (place(format!("{key}.from"), &of.from)?, place(format!("{key}.to"), &of.to)?);
            same_length(keys, &key, &of.mesh_rad_s, &of.r_k_per_w)?;
            same_length(keys, &key, &of.mesh_rad_s, &of.surface)?;
            let (mesh_rad_s, r_k_per_w) = (of.mesh_rad_s.clone(), of.r_k_per_w.clone());
            cross.push(CrossHeatingParameters { from, to, mesh_rad_s, r_k_per_w, surface: of.surface.clone() });
        }
        CalibrationChecks { keys, table: &table, reference, surfaces: &surfaces, own: &own, cross: &cross }.check()?;
        Ok(Self { species, reference, surfaces, network: QuiescentNetwork { own, cross }, noise, table })
    }

    /// Outward normal of the card, for a head that outputs the wind in the plane of a card only.
    pub fn card_normal(&self) -> Option<[f64; 3]> {
        self.table.card.as_ref().and(self.table.surfaces.first()).map(|of| of.axis)
    }

    /// Recordings and cross-validation of the calibration, in words.
    pub fn made_from(&self) -> &str {
        &self.table.made_from
    }
}

fn self_heating(of: &SelfHeatingTable, element: usize) -> SelfHeatingParameters {
    SelfHeatingParameters {
        element,
        name: of.element.clone(),
        rest_c: of.rest_c,
        mesh_rad_s: of.mesh_rad_s.clone(),
        r_k_per_w: of.r_k_per_w.clone(),
        layers: Vec::new(),
        surface: of.surface.clone(),
    }
}

fn same_length(keys: CalibrationKeys<'_>, key: &str, mesh: &[f64], other: &[f64]) -> Result<(), FileError> {
    if mesh.len() == other.len() && !mesh.is_empty() {
        return Ok(());
    }
    let sentence = format!("has {} rates and {} numbers that belong to them", mesh.len(), other.len());
    Err(keys.refuse(key, sentence))
}
