//! A flag that one task raises and another one takes.

use core::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// The flag.
pub struct Flag(AtomicBool);

impl Flag {
    /// A flag that is raised already, or not.
    pub const fn new(is_raised: bool) -> Self {
        Self(AtomicBool::new(is_raised))
    }

    /// Raises it.
    pub fn raise(&self) {
        self.set(true);
    }

    /// Raises or lowers it.
    pub fn set(&self, is_raised: bool) {
        self.0.store(is_raised, Relaxed);
    }

    /// Returns whether it is raised.
    pub fn is_raised(&self) -> bool {
        self.0.load(Relaxed)
    }

    /// Returns whether it was raised, and lowers it.
    ///
    /// Not one step: a flag that is raised between the two is served by the task that takes it now.
    pub fn take(&self) -> bool {
        let is_raised = self.is_raised();
        if is_raised {
            self.set(false);
        }
        is_raised
    }
}
