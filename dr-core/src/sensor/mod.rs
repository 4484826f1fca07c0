//! From ADC codes to resistance, temperature and heating power, and from conductances to the wind.

pub mod platinum;
pub mod reading;
pub mod wind;

pub use platinum::Platinum;
pub use reading::{Channel, Input, Level, Reading};
