//! Statistics of the wind as meteorology defines them, by intervals of two or ten minutes.
//!
//! Source: World Meteorological Organization, Guide to Instruments and Methods of Observation
//! (WMO-No. 8), part I, chapter 5, measurement of surface wind: means of 2 and 10 min, gust as the
//! greatest mean of 3 s, standard deviations of speed and direction.
//!
//! | file | what |
//! |---|---|
//! | [`wind_series`] | the estimates of an interval, which of them count, and their statistics |
//! | [`eddy`] | friction velocity, heat flux, Obukhov length |
//! | [`averaging`] | a recording, interval by interval |
//! | [`reference_check`] | a head beside a reference anemometer |
//! | [`report`] | options; text, JSON and table |

pub mod averaging;
pub mod eddy;
pub mod reference_check;
pub mod report;
pub mod wind_series;

pub use averaging::{AveragingError, average};
pub use report::AveragingOptions;
pub use report::MeteorologyReport;
