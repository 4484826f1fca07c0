//! The simulated sensors in their wind tunnel, with their front end.
//!
//! | file | what |
//! |---|---|
//! | [`convection`] | conductance of every surface to the gas, for any wind vector |
//! | `network` | thermal network in f64, integrated; never a diffusive model, so that identification meets something else |
//! | `construction` | what a head is made of: its own `[body]`, or one of the project's heads by name |
//! | `assembly`, `rod` | a network of it |
//! | `specimen` | one of many, where the file states tolerances |
//! | `body` | what all of them do: take heat, lose it and account for it |
//! | `cooled_stem` | stems from which the wind takes heat |
//! | `survey` | steady powers, gains and time constants, without letting time pass |
//! | `matching` | whether a head is the sensor that it names |
//! | `config`, `error` | what a sensor is made from, and why it cannot be made |
//! | [`wind`] | held entries, and turbulence, gusts, sines and dust devils on top of them |
//! | `temperature_swing` | a gas or a support whose temperature swings |
//! | [`field`] | sun, sky, drifts, film properties, buoyancy, stem |
//! | `front_end` | currents, resistors, converter, faults |
//!
//! [`Sensor`] puts them together. One tick: the controller decides the heater bits,
//! [`Sensor::advance`] lets one sample period pass under them, [`Sensor::codes`] is what the
//! converter then reads and [`Sensor::truth`] what only a simulation knows. The same configuration,
//! seed included, gives the same bits.
//!
//! ```
//! use host_sim::sensor::{Sensor, SensorConfig};
//!
//! let mut sensor = Sensor::new(&SensorConfig::default())?;
//! let rest_c = sensor.truth().element_temperature_c[0];
//! for _ in 0..100 {
//!     sensor.advance(0b000001); // sector 1 at its high level, for a second
//! }
//! assert!(sensor.truth().element_temperature_c[0] > rest_c + 0.3);
//! assert!(sensor.codes()[0] > 0);
//! # Ok::<(), host_sim::sensor::SensorError>(())
//! ```

mod assembly;
mod body;
mod config;
mod construction;
pub mod convection;
mod cooled_stem;
mod error;
pub mod field;
mod front_end;
mod matching;
mod network;
mod rod;
mod simulated;
mod specimen;
mod survey;
mod temperature_swing;
mod truth;
pub mod wind;

pub use body::Flows;
pub use config::{SensorConfig, TimedFault};
pub use construction::Construction;
pub use error::SensorError;
pub use front_end::{Imperfections, ResistorFault};
pub use matching::construction_of;
pub use simulated::Sensor;
pub use survey::{BodySurvey, OperatingPoint};
pub use temperature_swing::TemperatureSwing;
pub use truth::SensorTruth;
pub use wind::{DirectionSwing, DustDevil, Gust, Sine, Spectrum, Turbulence, WindEntry};

#[cfg(test)]
mod tests;
