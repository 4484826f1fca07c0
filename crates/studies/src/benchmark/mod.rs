//! The benchmarks of instrument and identification: what they have to reach, and what they reach.
//! `studies benchmark`.
//!
//! | module | holds |
//! |---|---|
//! | [`drift`] | a heater of known gain in a room that moves: is the gain right, and as sure as it says |
//! | [`field`] | sun, sky, drifts, another gas, a cooled stem: what they do to the wind, and whether it is said |
//! | [`field_correction`] | the same with slow errors corrected |
//! | [`field_own`] | effects that were in the calibration, too |
//! | [`field_judged`] | how wrong estimates are, and whether they say so |
//! | [`heads`] | heads of every form, from nothing to wind |
//! | [`measured`] | measured records: the beginning identified, the rest predicted |
//! | [`modes`] | constant temperature, current and power on one head |
//! | [`wind`] | from records of still gas to the wind: the two spheres, by the numbers that the estimates have to reach |

pub mod drift;
pub mod field;
pub mod field_correction;
pub mod field_judged;
pub mod field_own;
pub mod heads;
pub mod measured;
pub mod mems;
pub mod modes;
pub mod wind;
