//! The image of the sensor board, unmodified, on models of its processor, converter and sensor.

pub mod processor;
pub mod time;
