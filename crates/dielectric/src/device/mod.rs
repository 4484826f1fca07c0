//! A device: one MEMS capacitor with its limits, the meter that reads it, and what simulates it.
//!
//! | table | keys |
//! |---|---|
//! | top | `name` |
//! | `[capacitor]` | `curvature_f_v2` (α), `offset_f` (C₀), `pull_in_v` (the membrane falls at so many volts, beyond the shift) |
//! | `[limits]` | `bias_max_v` either way, `shift_max_v` either way, `capacitance_max_f` |
//! | `[meter]` | `full_scale_f`; of a real one `frequency_hz`, `level_v`; of a simulated one `noise_f` rms a reading |
//! | `[simulation]` | `temperature_c` and `humidity_percent` at which C₀ is as above, and its shares `offset_per_k`, `offset_per_percent`, `offset_per_hour`; `charging_per_k`, the share by which charging grows |
//! | `[[simulation.carriers]]` | `polarity` of the bias under which they charge, and a diffusive bank: [`Carriers`] |

mod carriers;
mod content;
mod table;

pub use carriers::{Carriers, Polarity};
pub use content::{Device, MeterRange, Simulation};
