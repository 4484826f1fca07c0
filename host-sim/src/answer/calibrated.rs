//! A head with a calibration: from its windless network and its steady winds to the file that is written.

use super::steady::Search;
use super::winds::Winds;
use crate::calibrate::{self, Calibration, HeldOut, Scheme, Steady, held_out};
use crate::head::calibration::{Curves, NewCalibration, NewPart};
use crate::head::{Answering, Head};
use crate::model::{Conditions, Model};
use crate::network::{ReadingNoise, Windless, reading_noise};
use crate::sensor::Species;

/// Folds of the cross-validation.
const FOLDS: usize = 10;
/// Overheat and period at which noise is told.
const TOLD_OVERHEAT_K: f64 = 30.0;

/// What any calibration begins with: a head, its network, and what of it looks into the wind.
pub struct Basis<'a> {
    pub head: &'a Head,
    pub windless: Windless,
    pub noise: Vec<ReadingNoise>,
    /// Places in the head of the parts' elements.
    pub places: Vec<usize>,
    /// The element that measures the gas.
    pub reference: Option<usize>,
    /// In which the network was identified.
    pub still: Conditions,
}

impl<'a> Basis<'a> {
    /// `model` is the windless network of `anemo network`.
    ///
    /// # Errors
    /// A sentence: what the network does not tell.
    pub fn new(head: &'a Head, model: &Model, places: Vec<usize>, reference: Option<usize>) -> Result<Self, String> {
        let windless = Windless::of(model, head)?;
        if let Some(&missing) = places.iter().find(|&&place| windless.own.iter().all(|own| own.element != place)) {
            return Err(format!(
                "network has no `{}`, which is a part of head `{}`: is it of another head?",
                head.elements[missing].name, head.name
            ));
        }
        let still = model.provenance.conditions.clone().ok_or("does not tell its gas")?;
        Ok(Self { head, windless, noise: reading_noise(model, head), places, reference, still })
    }

    /// What is looked for in recordings, of which `settle_s` is left out of every wind.
    pub fn search<'b>(&'b self, settle_s: f64, winds: Option<&'b Winds>) -> Search<'b> {
        Search {
            head: self.head,
            windless: &self.windless,
            noise: &self.noise,
            parts: &self.places,
            reference: self.reference,
            still: &self.still,
            settle_s,
            winds,
        }
    }
}

/// A sphere that is going to be calibrated, with all that is known of it.
pub struct Calibrator<'a> {
    basis: Basis<'a>,
    /// The parts as they are drawn.
    drawn: calibrate::Head,
}

/// One that is.
pub struct Calibrated {
    /// The file.
    pub text: String,
    pub head: Head,
    pub calibration: Calibration,
    pub directions: HeldOut,
    pub speeds: HeldOut,
}

impl<'a> Calibrator<'a> {
    /// `model` is the windless network of `anemo network`.
    ///
    /// # Errors
    /// A sentence: what the network, or the head, does not tell.
    pub fn new(head: &'a Head, model: &Model, diameter_m: f64) -> Result<Self, String> {
        let (places, drawn) = parts(head, diameter_m)?;
        let reference = head.elements.iter().position(|element| element.name == crate::sensor::reference::NAME);
        Ok(Self { basis: Basis::new(head, model, places, reference)?, drawn })
    }

    /// What is looked for in recordings, of which `settle_s` is left out of every wind.
    pub fn search<'b>(&'b self, settle_s: f64, winds: Option<&'b Winds>) -> Search<'b> {
        self.basis.search(settle_s, winds)
    }

    /// The calibrated head, and how well it answers winds that were held out.
    ///
    /// # Errors
    /// A sentence: which winds are missing, or why nothing can be fitted.
    pub fn calibrated(
        &self,
        steady: &[Steady],
        species: Species,
        recordings: usize,
        direction_error_max_deg: f64,
    ) -> Result<Calibrated, String> {
        let said = |error: calibrate::CalibrateError| error.to_string();
        let calibration = calibrate::calibrate(&self.drawn, steady).map_err(said)?;
        let directions = held_out(&self.drawn, steady, Scheme::Directions, FOLDS).map_err(said)?;
        let speeds = held_out(&self.drawn, steady, Scheme::Speeds, FOLDS).map_err(said)?;
        let overall = directions.overall();
        let basis = &self.basis;
        let names = basis.head.names();
        let new = NewCalibration {
            made_from: format!(
                "{} winds of {recordings} recordings; held out: direction {:.2}° rms, speed {:.2} % rms",
                calibration.winds,
                overall.direction_rms_deg,
                100.0 * overall.speed_rms
            ),
            species,
            reference_gas_c: basis.still.gas_temperature_c,
            diameter_m: calibration.diameter_m,
            direction_error_max_deg,
            reference: basis.reference.map(|element| names[element].to_owned()),
            curves: Curves::Nusselt(
                calibration.least_reynolds,
                calibration.most_reynolds,
                calibration.amplitudes.to_vec(),
            ),
            parts: new_parts(&calibration),
            windless: &basis.windless,
            noise: &basis.noise,
            names: &names,
        };
        let (text, head) = new.with_head(basis.head)?;
        Ok(Calibrated { text, head, calibration, directions, speeds })
    }
}

/// Standard deviation of a part's conductance at 30 K and 1 kHz, W/K, at a bandwidth, if it can be had.
pub fn conductance_noise_w_k(head: &Head, bandwidth_hz: f64) -> Option<f64> {
    let calibration = head.calibration.as_ref()?;
    let answering = Answering { bandwidth_hz, every_s: 0.01, fixed: true };
    let (_, observer) = calibration.commands(&answering, 1e-3).ok()?;
    let place = calibration.parts.first()?;
    let at = observer.own.iter().position(|(own, _)| own == place)?;
    Some(observer.sd_w[at] / TOLD_OVERHEAT_K)
}

/// Places in the head and geometry of what looks into the wind: four sectors of a tetrahedron, or two hemispheres.
fn parts(head: &Head, diameter_m: f64) -> Result<(Vec<usize>, calibrate::Head), String> {
    use dr_core::sensor::wind::sphere;
    let outward: Vec<(usize, [f64; 3])> = head
        .elements
        .iter()
        .enumerate()
        .filter_map(|(place, element)| element.normal.map(|normal| (place, normal)))
        .collect();
    let narrow = |v: [f64; 3]| v.map(|x| x as f32);
    let shapes: Vec<_> = match outward.len() {
        4 => sphere::tetrahedral_sectors(diameter_m as f32).to_vec(),
        2 => sphere::hemispheres(diameter_m as f32).to_vec(),
        count => {
            return Err(format!(
                "head `{}` has {count} elements with an outward `normal`: four sectors of a sphere, or two hemispheres can be calibrated",
                head.name
            ));
        }
    };
    let parts = outward.iter().zip(shapes).enumerate().map(|(i, ((place, normal), mut config))| {
        config.axis = narrow(*normal);
        if outward.len() == 4 {
            // A corner of a sector is opposite to the axis of another.
            config.corner = narrow(outward[(i + 1) % 4].1.map(|x| -x));
        } else {
            // Any direction across the axis: a hemisphere has no corner.
            let least = (0..3).min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(0);
            config.corner = std::array::from_fn(|k| if k == least { 1.0 } else { 0.0 });
        }
        calibrate::HeadPart { name: head.elements[*place].name.clone(), config }
    });
    let parts = parts.collect();
    Ok((outward.iter().map(|(place, _)| *place).collect(), calibrate::Head { diameter_m, parts }))
}

fn new_parts(calibration: &Calibration) -> Vec<NewPart> {
    let of = |(part, surface): (&calibrate::CalibratedPart, _)| NewPart {
        element: part.name.clone(),
        surface,
        gain: part.gain,
        windless_w_k: part.still_w_k,
    };
    calibration.parts.iter().zip(calibration.part_configs()).map(of).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn a_network_that_lacks_a_part_of_the_head_is_refused_by_its_name() {
        // It has hemisphere 1 and a core.
        let model = crate::network::windless::tests::model();
        let head = Head::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../heads/sphere-a.toml")).unwrap();
        let refused = Calibrator::new(&head, &model, 0.01).err().unwrap();
        assert_eq!(refused, "network has no `hemisphere2`, which is a part of head `sphere-a`: is it of another head?");
    }
}
