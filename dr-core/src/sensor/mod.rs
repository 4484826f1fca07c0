//! From ADC codes to resistance, temperature and heating power.

pub mod platinum;
pub mod reading;

pub use platinum::Platinum;
pub use reading::{Channel, FrontEndInput, Level, Reading};
