//! A card as drawn, and its winds in the numbers that are fitted; winds that are missing to determine
//! a card, before anything is fitted.

use dr_core::wind::SurfaceConfig;
use dr_core::wind::card_inverse::{CONDUCTION, DICE};
use recording::text::count;

use super::super::steady_wind::{CalibrateError, SteadyWind, SurfaceReading};

use crate::vector::{cross, dot, unit};

/// p_i, q_i: neighbours follow each other from the tip on.
pub(super) const PLACES: [[f64; 2]; DICE] = [[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]];
/// Greatest share of a wind that may lie across the plane.
const MOST_ACROSS: f64 = 0.02;

/// A card as drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnCard {
    /// Side of a die, m.
    pub side_m: f64,
    /// Outward.
    pub normal: [f64; 3],
    /// Along the boom; from it around is tip × normal.
    pub tip: [f64; 3],
}

/// A wind in the plane.
pub struct CardWind {
    /// √Re
    pub root: f64,
    /// Direction of where the gas goes to, from the tip around the boom, rad.
    pub angle: f64,
    /// M
    pub mean: f64,
    /// D_p, D_q
    pub differences: [f64; 2],
    /// The fourth combination, which no wind makes.
    pub twist: f64,
}

impl DrawnCard {
    fn around(&self) -> [f64; 3] {
        cross(unit(self.tip), unit(self.normal))
    }

    /// The dice as dr-core has them.
    pub fn dice(&self) -> [SurfaceConfig; DICE] {
        let (tip, around) = (unit(self.tip), self.around());
        PLACES.map(|[p, q]| SurfaceConfig {
            axis: self.normal.map(|x| x as f32),
            corner: std::array::from_fn(|k| (p * tip[k] + q * around[k]) as f32),
            area_m2: (self.side_m * self.side_m) as f32,
            means: [0.0; 5],
            threefold: [0.0; 3],
        })
    }

    /// G0 in a gas of this conductivity, W/K.
    pub fn quiescent_w_k(&self, conductivity_w_m_k: f64) -> f64 {
        f64::from(CONDUCTION) * conductivity_w_m_k * self.side_m
    }

    /// Conductance of a die, W/K.
    pub(super) fn conductance_w_k(&self, steady: &SteadyWind, reading: &SurfaceReading) -> f64 {
        let quiescent_w_k = self.quiescent_w_k(steady.gas.conductivity_w_m_k);
        (reading.power_w + quiescent_w_k * reading.above_reference_k) / reading.overheat_k
    }

    /// Reynolds number of 1 m/s.
    pub(super) fn reynolds_per_speed(&self, steady: &SteadyWind) -> f64 {
        steady.gas.density_kg_m3 * self.side_m / steady.gas.viscosity_pa_s
    }

    /// The wind in the plane of the card; none for quiescent gas.
    ///
    /// # Errors
    /// If a reading cannot be meant.
    fn wind(&self, steady: &SteadyWind) -> Result<Option<CardWind>, CalibrateError> {
        let readings: &[SurfaceReading; DICE] = (steady.surfaces.as_slice().try_into())
            .map_err(|_| steady.refuse(format!("{} dice were read, but a card has {DICE}", steady.surfaces.len())))?;
        if let Some(bad) = readings.iter().find(|of| !(of.overheat_k > 0.0 && of.power_w.is_finite())) {
            return Err(steady.refuse(format!("a die is {} K above the gas: it must be warmer", bad.overheat_k)));
        }
        let flat = [dot(steady.wind_m_s, unit(self.tip)), dot(steady.wind_m_s, self.around())];
        let (across, speed) = (dot(steady.wind_m_s, unit(self.normal)), libm::hypot(flat[0], flat[1]));
        if across.abs() > MOST_ACROSS * speed {
            let blown = format!("{across:.2} m/s of it blow across the card");
            return Err(steady.refuse(format!("{blown}: a card is calibrated in winds of its plane")));
        }
        if speed == 0.0 {
            return Ok(None);
        }
        let unit_w_k = steady.gas.conductivity_w_m_k * self.side_m;
        let nusselt = readings.map(|reading| self.conductance_w_k(steady, &reading) / unit_w_k);
        let sum = |of: fn([f64; 2]) -> f64| (0..DICE).map(|i| of(PLACES[i]) * nusselt[i]).sum::<f64>() / DICE as f64;
        Ok(Some(CardWind {
            root: (speed * self.reynolds_per_speed(steady)).sqrt(),
            angle: libm::atan2(flat[1], flat[0]),
            mean: sum(|_| 1.0),
            differences: [sum(|[p, _]| p), sum(|[_, q]| q)],
            twist: sum(|[p, q]| p * q),
        }))
    }
}

/// The winds of a card, but for quiescent gas.
///
/// # Errors
/// The label of the first reading that cannot be meant.
pub fn winds(drawn: &DrawnCard, steady: &[SteadyWind]) -> Result<Vec<CardWind>, CalibrateError> {
    steady.iter().filter_map(|steady| drawn.wind(steady).transpose()).collect()
}

/// Sectors of directions of which each needs a wind.
const SECTORS: usize = 12;
/// Fewest winds: some for every unknown.
const LEAST_WINDS: usize = 40;
/// Least ratio of the greatest to the least speed.
const LEAST_RATIO: f64 = 3.0;
/// Winds that are missing, a sentence each.
pub fn lacking(winds: &[CardWind]) -> Vec<String> {
    let mut lacking = Vec::new();
    if winds.len() < LEAST_WINDS {
        lacking.push(format!("{} given, at least {LEAST_WINDS} are needed", count(winds.len(), "wind")));
    }
    let (least, most) = ends(winds);
    if most < LEAST_RATIO * least {
        let fastest = format!("the fastest wind is {:.1} times as fast as the slowest", most / least);
        lacking.push(format!("{fastest}; {LEAST_RATIO} times are needed at least"));
    }
    let width = 360 / SECTORS;
    let sector = |wind: &CardWind| (wind.angle.to_degrees().rem_euclid(360.0) as usize / width).min(SECTORS - 1);
    for empty in (0..SECTORS).filter(|&n| winds.iter().all(|wind| sector(wind) != n)) {
        let [from, to] = [empty, empty + 1].map(|edge| edge * width);
        lacking.push(format!("no wind goes towards {from} to {to}° from the tip around the boom"));
    }
    lacking
}

/// Least and greatest Reynolds number.
pub fn ends(winds: &[CardWind]) -> (f64, f64) {
    winds.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), wind| {
        (least.min(wind.root * wind.root), most.max(wind.root * wind.root))
    })
}
