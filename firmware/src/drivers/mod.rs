//! Drivers of the sensor board, written against embedded-hal 1.0 so that they build and are tested
//! on the host.
//!
//! From the ADC to the controller: [`ads131e06`] reads one conversion of all six elements,
//! [`data_ready`] notices those that were lost, [`settled_mean`] makes one
//! [`dr_core::sensor::reading::Reading`] an element and tick of the conversions that [`tick_plan`]
//! has counted, and [`heater_pins`] puts the controller's decision on the current sources. The
//! circuit around them is in `docs/reference/board.md`.

pub mod ads131e06;
pub mod data_ready;
pub mod heater_pins;
pub mod settled_mean;
pub mod tick_plan;
