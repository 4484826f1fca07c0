//! The image of the sensor board, unmodified, on models of its processor, converter and sensor.

pub mod adc;
pub mod board;
pub mod complaint;
pub mod host_line;
pub mod image;
pub mod log;
pub mod machine;
pub mod plant;
pub mod processor;
pub mod soc;
pub mod stream;
pub mod time;
pub mod witness;
