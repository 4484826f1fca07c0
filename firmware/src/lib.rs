//! The parts of the firmware that know no board: drivers on embedded-hal, and the handling of what
//! comes over the links. They build for the host as well, where they are tested.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
// What runs on the board must not panic. Indices are looked for in the image, where most of them
// are gone: `cargo xtask safety`.
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable))]

pub mod azimuth;
pub mod check_ins;
pub mod control_loop;
pub mod crash_record;
pub mod cut_off;
pub mod dead_man;
pub mod drivers;
pub mod estimates;
pub mod flag;
pub mod inbox;
pub mod interlock;
/// Processors: the parts that need no hardware.
pub mod mcu {
    /// STM32F405.
    pub mod stm32f4 {
        pub mod circle;
        pub mod reset_flags;
    }
}
pub mod outbox;
pub mod phase;
pub mod proof;
pub mod queue;
pub mod settings;
