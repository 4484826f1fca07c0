//! Diffusive models: a structure with memory as K relaxations on a logarithmic grid of rates
//! (diffusive mesh; thesis ch. 2).

pub mod convection_observer;
pub mod mesh;
pub mod observer;
pub mod real;
pub mod relaxation;
pub mod self_heating;
pub mod sliding;
pub mod symbol;

pub use convection_observer::config::{
    AlarmConfig, BOARD_FASTER_ELEMENTS, BOARD_PAIRS, FasterGainsConfig, GainsConfig, NetworkCrossHeatingConfig,
    NetworkSelfHeatingConfig,
};
pub use convection_observer::{ConvectionEstimate, ConvectionObserver, ConvectionObserverState, TickInput};
pub use observer::{ObservedPower, Observer, ObserverState};
pub use real::Real;
pub use relaxation::{RelaxationState, Relaxations};
pub use self_heating::{ORDER, SelfHeating, SelfHeatingConfig};
pub use sliding::{Reachability, equivalent_control, reachability, sliding_margins_w};
pub use symbol::Symbol;
