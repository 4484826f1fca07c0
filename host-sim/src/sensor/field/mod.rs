//! Effects of the field: what a head meets outdoors and not in a tunnel. All of them are off unless
//! an experiment names them.
//!
//! | file | what | key |
//! |---|---|---|
//! | `sun` | sunlight, and heat put onto a surface | `[sun]`, `[[surface_heat]]` |
//! | this one | emissivity, and what surfaces radiate to | `[sky]` |
//! | `drift` | resistances, coatings and contacts that age | `[[drifts]]` |
//! | this one | properties at film temperature | `gas.properties` |
//! | `buoyancy` | mixed convection | `[buoyancy]` |
//! | `stem` | a stem that the wind cools, and its wake | `[stem]` |
//! | this one | the wind that a sphere meets, after wake and buoyancy | |
//! | `applied` | all of them on one body | |
//!
//! # Sky
//!
//! Surfaces radiate to the sky by their emissivity:
//!
//! ```text
//! Q_i = ε σ A_i (T_i⁴ − T_sky⁴)
//! ```
//!
//! | symbol | key | unit |
//! |---|---|---|
//! | Q_i | heat radiated by surface i | W |
//! | ε | `emissivity`; without it, the head's of every surface | 1 |
//! | σ = 5.670374419e-8 | Stefan–Boltzmann constant, CODATA 2018 | W/(m²·K⁴) |
//! | A_i, T_i | area and temperature of surface i | m², K |
//! | T_sky | `temperature_c`; without it, the gas's mean | K |
//!
//! Limits: grey surfaces, one radiant temperature all around. The sky's temperature is that of a
//! black enclosure that radiates as sky and ground together do.
//!
//! # Gas properties
//!
//! A sphere's convection takes them at the film temperature:
//!
//! ```text
//! T_f,i = (T_i + T_g) / 2
//! G_i   = Nu_i(Re(T_f,i), Pr(T_f,i)) k(T_f,i) π d s_i
//! ```
//!
//! with surface i at T_i, gas at T_g in K, and density, viscosity, conductivity and heat capacity
//! of each surface's own T_f,i, at the gas's pressure. Source: film temperature, Incropera and
//! DeWitt, Fundamentals of Heat and Mass Transfer, ch. 6.
//!
//! Limits: each surface sees a stream of its own properties, though all share one layer. What is
//! beside a sphere keeps its own rule.

mod applied;
mod buoyancy;
mod drift;
mod stem;
mod sun;

pub(super) use applied::AppliedField;
pub use buoyancy::{Buoyancy, BuoyancyModel};
pub use drift::{DriftQuantity, ElementDrift};
pub(super) use stem::CooledStem;
pub use stem::{Stem, StemWake};
pub(super) use sun::HALF_COSINE;
pub use sun::{Sun, SurfaceHeat};

use serde::Deserialize;

use super::error::{SensorError, require};
use anemometry::gas::{IdealGas, ZERO_CELSIUS_K};

/// The effects of the field on a simulated sensor; none by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FieldEffects {
    /// Heat put onto surfaces.
    pub surface_heat: Vec<SurfaceHeat>,
    /// Sunlight.
    pub sun: Option<Sun>,
    /// Sky that surfaces radiate to; without it, surroundings of the gas's mean temperature.
    pub sky: Option<Sky>,
    /// Drifts.
    pub drifts: Vec<ElementDrift>,
    /// At which temperature convection takes the properties of the gas.
    pub gas_properties: GasProperties,
    /// Mixed convection.
    pub buoyancy: Option<Buoyancy>,
    /// The stem in the wind.
    pub stem: Option<Stem>,
}

impl FieldEffects {
    /// Keys of the effects that are switched on.
    pub fn keys(&self) -> Vec<&'static str> {
        let all = [
            ("surface_heat", !self.surface_heat.is_empty()),
            ("sun", self.sun.is_some()),
            ("sky", self.sky.is_some()),
            ("drifts", !self.drifts.is_empty()),
            ("gas.properties", self.gas_properties != GasProperties::Gas),
            ("buoyancy", self.buoyancy.is_some()),
            ("stem", self.stem.is_some()),
        ];
        all.into_iter().filter(|(_, on)| *on).map(|(key, _)| key).collect()
    }
}

/// Sky that surfaces radiate to.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sky {
    /// Radiant temperature, °C.
    pub temperature_c: Option<f64>,
    /// Emissivity of all surfaces.
    pub emissivity: Option<f64>,
}

impl Sky {
    fn check(&self) -> Result<(), SensorError> {
        if let Some(temperature_c) = self.temperature_c {
            let possible = temperature_c.is_finite() && temperature_c >= -ZERO_CELSIUS_K;
            require(possible, "sky.temperature_c", temperature_c, "-273.15 or more")?;
        }
        self.emissivity.map_or(Ok(()), |emissivity| {
            require((0.0..=1.0).contains(&emissivity), "sky.emissivity", emissivity, "0 to 1")
        })
    }
}

/// At which temperature properties are taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GasProperties {
    /// The gas's.
    #[default]
    Gas,
    /// The mean of gas and surface.
    Film,
}

/// From the wind to the one that a sphere meets.
#[derive(Clone, Copy, Debug, Default)]
pub struct LocalWind {
    /// Rise of the gas that the sphere warms.
    pub buoyancy: Option<Buoyancy>,
    /// Wake of the stem.
    pub stem: Option<Stem>,
}

impl LocalWind {
    /// The wake first, then the rise; `surface_k` are temperatures of the sphere's surfaces.
    pub fn around(&self, wind_m_s: [f64; 3], gas: &IdealGas, diameter_m: f64, surface_k: &[f64]) -> [f64; 3] {
        let behind_m_s = self.stem.map_or(wind_m_s, |stem| stem.wind_m_s(wind_m_s));
        self.buoyancy.map_or(behind_m_s, |buoyancy| {
            let mean_k = surface_k.iter().sum::<f64>() / surface_k.len() as f64;
            buoyancy.wind_m_s(behind_m_s, gas, diameter_m, mean_k - gas.temperature_k)
        })
    }
}
