//! The emulated processor: what QEMU's STM32F405 leaves to its host.
//!
//! | file | what |
//! |---|---|
//! | `file_flash.rs` | sectors of the settings as a file |
//! | `semihosting.rs` | files and exit of the host |
//! | `virtual_log.rs` | words for people on the standard output |

pub mod file_flash;
pub mod semihosting;
mod virtual_log;
