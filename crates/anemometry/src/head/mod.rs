//! Sensor heads: the elements of a sensor, their wiring, their limits and their calibration.
//!
//! A head file is TOML. An element takes the keys that it does not have from the table of its kind:
//!
//! | table | keys |
//! |---|---|
//! | top | `name`, optionally `sensor` ("sphere-a", "sphere-b" or "rems"): the simulation of this head |
//! | `[adc]` | `full_scale_v` (the code's end), `bits` (two's complement, 8 … 24), optionally `compliance_v` (of the current sources) |
//! | `[guard]` | `missing_limit_ticks`, `unreachable_limit_s`, `stuck_limit_ticks` |
//! | `[kinds.…]` | defaults for the elements of that kind, which may be any word |
//! | `[[elements]]` | `name`, optionally `kind` and `normal` (outward), `platinum`, `current_low_a`, `current_high_a`, `resistance_min_ohm`, `resistance_max_ohm`, `temperature_max_c`, optionally `layers` (0 … 3, between element and surface) and `current_high_nominal_a` (where `current_high_a` is measured: what the source was made for, and the simulation is) |
//! | `[body]` | optional, in place of `sensor`, see [`body`] |
//! | `[calibration]` | optional, see [`calibration`] |
//!
//! One code is full_scale_v / 2^(bits−1) V. Elements of a simulated head are those of its sensor,
//! by name and in order; a sphere's may be followed by one more, `reference`. Numbers are checked
//! by dr-core's own constructors, as the board will.
//!
//! | file | holds |
//! |---|---|
//! | [`mod@file`] | a head file, checked |
//! | [`element`], [`nominal`] | an element of it, and its data sheet |
//! | [`body`] | the table `[body]`: what simulates it |
//! | [`calibration`] | the table `[calibration]`, read and written |
//! | `currents` | a head with high currents that were measured |
//! | [`output`] | bandwidth and interval of wind estimates |
//! | [`setup`] | a calibration as commands of the board's anemometer |
//! | [`table`] | the file as it is written |
//! | `variant` | a head with other values of its unknown numbers |
//! | [`error`] | what is refused beside the file |

pub mod body;
pub mod calibration;
mod currents;
pub mod element;
pub mod error;
pub mod file;
pub mod nominal;
pub mod output;
pub mod setup;
pub mod table;
mod variant;

pub use element::HeadElement;
pub use file::Head;
pub use nominal::{NominalElement, PlatinumKind};
pub use output::WindOutput;
