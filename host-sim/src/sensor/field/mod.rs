//! Effects of the field: what a head meets outdoors and not in a tunnel. All of them are off unless
//! an experiment names them.
//!
//! | file | what | key |
//! |---|---|---|
//! | `sun` | sunlight, and heat put onto a surface | `[sun]`, `[[surface_heat]]` |
//! | `sky` | emissivity, and what surfaces radiate to | `[sky]` |
//! | `drift` | resistances, coatings and contacts that age | `[[drifts]]` |
//! | `gas_properties` | properties at film temperature | `gas.properties` |
//! | `buoyancy` | mixed convection | `[buoyancy]` |
//! | `stem` | a stem that the wind cools, and its wake | `[stem]` |
//! | `local_wind` | the wind that a sphere meets, after wake and buoyancy | |
//! | `applied` | all of them on one body | |

mod applied;
mod buoyancy;
mod drift;
mod gas_properties;
mod local_wind;
mod sky;
mod stem;
mod sun;

pub(super) use applied::AppliedField;
pub use buoyancy::{Buoyancy, BuoyancyModel};
pub use drift::{DriftQuantity, ElementDrift};
pub use gas_properties::GasProperties;
pub(super) use local_wind::LocalWind;
pub use sky::Sky;
pub use stem::{Stem, StemWake};
pub(super) use sun::HALF_COSINE;
pub use sun::{Sun, SurfaceHeat};

/// The effects of the field on a simulated sensor; none by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FieldEffects {
    /// Heat put onto surfaces.
    pub surface_heat: Vec<SurfaceHeat>,
    /// Sunlight.
    pub sun: Option<Sun>,
    /// What surfaces radiate to; without it, surroundings of the gas's mean temperature.
    pub sky: Option<Sky>,
    /// What ages.
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
