//! Diffusive models: a structure with memory as K relaxations on a geometric mesh of rates (thesis ch. 2).

pub mod mesh;
pub mod network;
pub mod observer;
pub mod real;
pub mod relaxation;
pub mod self_heating;
pub mod sliding;
pub mod symbol;

pub use network::{
    AlarmConfig, Convection, CrossConfig, FasterConfig, GainsConfig, Look, Network, NetworkState, OwnConfig,
};
pub use observer::{Observed, Observer, ObserverState};
pub use real::Real;
pub use relaxation::{RelaxationState, Relaxations};
pub use self_heating::{ORDER, SelfHeating, SelfHeatingConfig};
pub use sliding::{Reachability, equivalent_control, reachability, sliding_margins_w};
pub use symbol::Symbol;
