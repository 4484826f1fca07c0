//! Settings in flash: they survive resets and loss of power.
//!
//! | file | what |
//! |---|---|
//! | `guarded.rs` | flash in which an interrupted erase is finished at the next start |
//! | `store.rs` | values under keys, in three sectors that take turns |
//! | `server.rs` | carries out a host's requests, and returns the stored settings for a set-up |
//! | `findings.rs` | findings of a self-test on their way to the flash |
//! | `standby_lock.rs` | excludes writing while the instrument runs |
//!
//! The numbers of the keys and the bytes of the values are in [`wire::settings`].

pub mod findings;
pub mod guarded;
pub mod server;
pub mod standby_lock;
pub mod store;

pub use findings::PendingFindings;
pub use server::SettingsServer;
pub use standby_lock::StandbyLock;
pub use store::Store;

#[cfg(test)]
pub(crate) mod mock;
