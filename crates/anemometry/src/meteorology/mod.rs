//! Statistics of the wind as meteorology defines them, by intervals of two or ten minutes.
//!
//! Source: World Meteorological Organization, Guide to Instruments and Methods of Observation
//! (WMO-No. 8), part I, chapter 5, measurement of surface wind: means of 2 and 10 min, gust as the
//! greatest mean of 3 s, standard deviations of speed and direction.
//!
//! | file | what |
//! |---|---|
//! | [`counted`] | which estimates count |
//! | [`wind_series`] | the estimates of an interval, and their statistics |
//! | [`direction`] | mean and standard deviation of the direction |
//! | [`gust`] | the peak gust |
//! | [`eddy`] | friction velocity, heat flux, Obukhov length |
//! | [`cospectrum`] | share of a flux that a bandwidth and an interval hold |
//! | [`sampling`] | uncertainty of a covariance by the length of the record |
//! | [`options`] | what is averaged, and how |
//! | [`averaging`] | a recording, interval by interval |
//! | [`reference_check`] | a head beside a reference anemometer |
//! | [`report`] | text, JSON and table |

pub mod averaging;
pub mod cospectrum;
pub mod counted;
pub mod direction;
pub mod eddy;
pub mod gust;
pub mod options;
pub mod reference_check;
pub mod report;
pub mod sampling;
pub mod wind_series;

pub use averaging::{AveragingError, average};
pub use options::AveragingOptions;
pub use report::MeteorologyReport;
