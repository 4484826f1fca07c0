//! Settings in flash: they survive resets and loss of power.
//!
//! | file | content |
//! |---|---|
//! | `record.rs` | one record in one sector, or in two that take turns |
//! | `server.rs` | carries out a host's requests, and returns the stored commands for a set-up |
//! | `findings.rs` | findings of a self-test on their way to the flash |
//! | `standby_lock.rs` | excludes writing while the instrument runs |
//!
//! The bytes of a record are in [`wire::settings`].

pub mod findings;
pub mod record;
pub mod server;
pub mod standby_lock;

pub use findings::PendingFindings;
pub use server::SettingsServer;
pub use standby_lock::StandbyLock;

#[cfg(test)]
pub(crate) mod mock;
