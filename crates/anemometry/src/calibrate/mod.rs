//! Calibration of a head in a wind tunnel: from its readings in known winds to a head file that
//! outputs unknown ones.
//!
//! | file | what |
//! |---|---|
//! | [`steady_winds`] | steady winds found in recordings |
//! | [`steady_table`] | steady winds of a user's own table |
//! | [`steady_wind`] | mean readings in one of them |
//! | [`drawn`] | what the surfaces of a head belong to, and which part of it each is |
//! | [`surfaces`] | the calibration of surfaces on a sphere, round a cylinder, of wires or of one element |
//! | [`card`] | the calibration of four dice on a card, in winds of its plane |
//! | [`compared`], [`cross_validation`] | errors in winds that were left out |
//! | [`calibrator`] | from a head, its network and its steady winds to the calibrated head |
//! | [`report`] | the calibration as text and as JSON |
//! | [`error`] | what is refused |

pub mod calibrator;
pub mod card;
pub mod compared;
pub mod cross_validation;
pub mod drawn;
pub mod error;
pub mod report;
pub mod steady_table;
pub mod steady_wind;
pub mod steady_winds;
pub mod surfaces;
pub mod uncertainty;

pub use calibrator::{Calibrator, NetworkSource};
pub use card::drawn::DrawnCard;
pub use compared::ComparisonSummary;
pub use cross_validation::Scheme;
pub use drawn::DrawnOptions;
pub use error::CalibrateError;
pub use report::CalibrationReport;
pub use steady_table::SteadyTable;
pub use steady_wind::{SteadyWind, SurfaceReading};
pub use surfaces::calibration::SurfaceCalibration;
pub use surfaces::choice::{ConvectionOptions, chosen};
pub use surfaces::cross_validation::{compare, cross_validate};
pub use surfaces::readings::{DrawnSurface, DrawnSurfaces, LossLaw};
pub use surfaces::solve::{calibrate, solve};
pub use surfaces::sought::{Gravity, SoughtConvection};
