//! The simulated sensors in their wind tunnel, with their front end.
//!
//! | file | what |
//! |---|---|
//! | [`convection`] | conductance of every surface to the gas, for any wind vector |
//! | `network` | thermal network in f64, integrated; never a diffusive model, so that identification meets something else |
//! | `construction` | what a head is made of: its own `[body]`, or one of the project's heads by name, which it must match |
//! | `assembly` | a network of it, rods as cells |
//! | `specimen` | one of many, where the file states tolerances |
//! | `body` | what all of them do: take heat, lose it and account for it |
//! | `survey` | steady powers, gains and time constants, without letting time pass |
//! | `config`, `error` | what a sensor is made from, with swings of gas and support; why it cannot be made |
//! | [`wind`] | held entries, and turbulence, gusts, sines and dust devils on top of them |
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
mod error;
pub mod field;
mod front_end;
mod network;
mod simulated;
mod specimen;
mod survey;
pub mod wind;

pub use body::Flows;
pub use config::{SensorConfig, TemperatureSwing, TimedFault};
pub use construction::{Construction, construction_of};
pub use error::SensorError;
pub use front_end::{Imperfections, ResistorFault};
pub use simulated::{Sensor, SensorTruth};
pub use survey::{BodySurvey, OperatingPoint};
pub use wind::{DirectionSwing, DustDevil, Gust, Sine, Spectrum, Turbulence, WindEntry};

#[cfg(test)]
mod tests;
