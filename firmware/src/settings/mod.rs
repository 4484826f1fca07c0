//! What an instrument keeps in its flash, over resets and while its supply is gone.
//!
//! | file | what |
//! |---|---|
//! | `guarded.rs` | flash in which an erase that the supply did not see through is finished at the next start |
//! | `store.rs` | values under keys, in three sectors that take turns |
//! | `clerk.rs` | answers a host's requests, and says what an instrument is to be told at its start |
//! | `findings.rs` | what a self-test has found, on its way to the flash |
//! | `busy.rs` | who may write when: never while the instrument runs |
//!
//! The numbers of the keys and the bytes of the values are in [`wire::settings`].

pub mod busy;
pub mod clerk;
pub mod findings;
pub mod guarded;
pub mod store;

pub use busy::Busy;
pub use clerk::Clerk;
pub use findings::Findings;
pub use store::{Store, StoreError};

#[cfg(test)]
pub(crate) mod mock;
