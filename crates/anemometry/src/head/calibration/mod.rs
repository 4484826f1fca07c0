//! The calibration of a head: what it takes to output the wind.
//!
//! The table `[calibration]` stands at the end of a head file, where `anemo calibrate` writes it:
//!
//! | table | keys |
//! |---|---|
//! | `[calibration]` | `made_from` (in words), `made_on` (day), `version` (1), `former` (what it was before a scale), `species`, `reference_gas_c` (gas of the quiescent-gas network), `support_c` (its support, if known), `diameter_m`, `direction_error_max_deg`, optionally `reference` (the element that measures the gas) |
//! | `[calibration.conditions]` | least and greatest of its winds: `gas_c`, `pressure_pa`, `surface_c`; `check`, `run` and `wind` compare |
//! | `[calibration.nusselt]` | `least_reynolds`, `most_reynolds`, `amplitudes` (32 rows of a_0 … a_5); without it the head outputs conductances only |
//! | `[calibration.card]` | in its place for four dice on a card: `least_reynolds`, `most_reynolds`, `mean` and `difference` (12 values over √Re from 0), `along`, `around`, `seen` (8 harmonics each), `mean_share`, `difference_share`; see [`dr_core::wind::card_inverse`] |
//! | `[calibration.uncertainty]` | what the calibration adds to the uncertainty of the wind: `conductance_share`, `speed_share`, `direction_deg` (4 each, at Reynolds numbers in geometric progression), `chi_square_most`; without it only the noise counts; see [`dr_core::wind::calibration_uncertainty`] |
//! | `[calibration.correction]` | slow errors that are taken out, by `anemo wind --write-head`: `made_from` (in words), `made_on` (day), and of every surface `[[calibration.correction.surfaces]]` with `element`, `offset_w` (heat beside the wind), `offset_u_w`, `gain_change` (share), `gain_change_u`; see [`dr_core::wind::slow_errors`] |
//! | `[[calibration.surfaces]]` | `element`, `axis` and `corner` in the tunnel's frame, `area_m2`, `means`, `threefold`, `gain`, `quiescent_w_k` |
//! | `[[calibration.self_heating]]` | `element`, `rest_c`, `noise_k` (low and high level), `mesh_rad_s`, `r_k_per_w`, `surface` (m_k, for an element that the wind cools) |
//! | `[[calibration.cross_heating]]` | `from`, `to`, `mesh_rad_s`, `r_k_per_w`, `surface` |
//!
//! It holds for the gas's species, and for the temperature of the support of the identification;
//! see [`dr_core::wind::anemometer`] and [`dr_core::model::convection_observer`] for what the
//! numbers do.
//!
//! | file | holds |
//! |---|---|
//! | [`table`] | the tables as they are written |
//! | `checks` | what is refused |
//! | [`checked`] | a checked calibration |
//! | `ageing` | its day, version, and a scale of its speed |
//! | [`correction`] | corrections that the head carries, as they are written |
//! | `corrected` | a calibration with them |
//! | [`conditions`] | what it was made in |
//! | `differences` | what follows in other conditions |
//! | [`commands`] | it as commands of the board's anemometer |
//! | `new` | a calibration that was just made, on its way to the file |

mod ageing;
pub mod checked;
mod checks;
pub mod commands;
pub mod conditions;
mod corrected;
pub mod correction;
mod differences;
mod new;
pub mod table;

pub use checks::{DIAMETER_M, DIRECTION_ERROR_MAX_DEG};
pub use table::PropertyTemperature;
