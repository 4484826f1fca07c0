//! From codes to what an element measures: resistance, temperature and heating power of a platinum
//! resistor, voltage shift of a capacitor's dielectric.

pub mod capacitor;
pub mod platinum;
pub mod reading;

pub use capacitor::Capacitor;
pub use platinum::Platinum;
pub use reading::{Channel, FrontEndInput, Level, Reading};
