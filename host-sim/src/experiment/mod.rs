//! Experiments: what every element does, for how long, in which gas and wind.
//!
//! | table | keys |
//! |---|---|
//! | top | `title`, `head` and optionally `models` (paths from this file), `observe` (true or false), `host_timeout_s` (0 … 86 400), `sample_period_s` (0.001 … 1), `duration_s`, `seed` |
//! | `[gas]` | `species` ("co2" or "air"), `pressure_pa`, `temperature_c`, and optionally `swing = { amplitude_k, period_s, start_s }`: a sine about that temperature, zero at its start, which is 0 if not given |
//! | `[support]` | `temperature_c`; without it, the gas's |
//! | `[front_end]` | `noise_v_rms`, `resistance_error_percent`, `coefficient_error_percent`, `current_error_percent`, and by element `current_ratio_error_ppm = { … }`; 0 if not given |
//! | `[currents]` | one line an element whose levels are not the head's: `{ low_a, high_a }` |
//! | `[wind_output]` | for a head with a calibration: `bandwidth_hz` (0.5 … 50, 2 if not given) of the convective powers, `interval_s` (0.01 or a tick if not given), `fixed` (true keeps the bandwidth when the wind jumps) |
//! | `[drives]` | one line an element; one without is passive |
//! | `[[changes]]` | `start_s`, and `drives` of elements that do something else from then on |
//! | `[[wind]]` | `start_s`, `speed_m_s`, and optionally `label`, `azimuth_deg`, `elevation_deg`, and what blows on top of the mean (below) |
//! | `[tunnel]` | in place of `[[wind]]`, the runs of a car ([`wind`]): `track_m`, `speeds_m_min`, `pause_s`, and optionally `first_pause_s`, `order_seed`, `azimuth_deg`, `elevation_deg` |
//! | `[sweep]` | in place of `[[wind]]`, many winds of all directions ([`sweep`]): `winds`, `least_m_s`, `most_m_s`, `hold_s`, and optionally `still_s`, `stem_cone_deg`, `plane`, `seed` |
//! | `gas.properties`, `[sun]`, `[[surface_heat]]`, `[sky]`, `[[drifts]]`, `[buoyancy]`, `[stem]` | effects of the field on a simulated sensor ([`crate::sensor::field`]) |
//! | `[[faults]]` | `start_s`, `element`, `kind` ("open" or "shorted"): a simulated resistor that breaks |
//!
//! A drive is `"passive"`, `{ level = "high" }`, `{ power_w = … }`, `{ temperature_c = … }`,
//! `{ prbs = { order, bit_time_s, seed } }` or `{ setpoints = { low_c, high_c, dwell_s, seed } }`.
//!
//! On top of a `[[wind]]`'s mean may blow, with times from its start ([`crate::sensor::wind`] has
//! the formulas):
//!
//! | key | value |
//! |---|---|
//! | `turbulence` | `{ intensity, correlation_time_s }`, `{ spectrum = "von-karman", intensity, length_m }` or `{ spectrum = "kaimal", intensity, height_m }` |
//! | `gust` | `{ start_s, duration_s, rise_m_s }`, and optionally `azimuth_deg`, `elevation_deg` |
//! | `sine` | `{ amplitude_m_s, frequency_hz }` of the speed |
//! | `swing` | `{ amplitude_deg, frequency_hz }` of the azimuth |
//! | `dust_devil` | `{ time_s, miss_m, core_radius_m, swirl_m_s }`, and optionally `inflow_m_s`, `travel_m_s`, `travel_azimuth_deg` |
//!
//! Starts of tables and durations are whole numbers of sample periods; what is not is refused with
//! the nearest that would be.
//!
//! Gas, support, front end and wind belong to the simulated sensor; on a real one they are a note
//! of the conditions. The [`models`], where there are some, judge the set-points: in a gas that
//! swings by its mean. Drives are judged by its whole range.

mod checked;
mod drives;
mod grid;
pub mod models;
mod read;
mod scenario;
pub mod sweep;
mod table;
pub mod wind;

pub use checked::Experiment;
pub use drives::DriveChange;
pub use grid::{TickGrid, time_s};
pub use scenario::{ScenarioError, scenario};

#[cfg(test)]
mod tests;
