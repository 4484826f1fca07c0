//! Targets of faults.

use dr_core::control::Heaters;
use host_sim::instrument::emulated::Emulated;
use host_sim::instrument::{InstrumentError, LockStepController};
use host_sim::settings::{Settings, read_all, write_requests};
use wire::{LinkCounters, Provocation};

/// A running instrument to which things can happen.
pub trait Subject: LockStepController {
    /// A tick passes in which the front end says nothing; the levels as they stand then.
    ///
    /// # Errors
    /// If it cannot be reached.
    fn silence(&mut self) -> Result<Heaters, InstrumentError>;

    /// Bytes that come over the host link.
    ///
    /// # Errors
    /// If it cannot be reached.
    fn hear(&mut self, bytes: &[u8]) -> Result<(), InstrumentError>;

    /// Seconds that it has been up, and what it has counted of those bytes till then.
    ///
    /// # Errors
    /// If it cannot be reached.
    fn counted(&mut self) -> Result<(u32, LinkCounters), InstrumentError>;

    /// Something happens inside of it.
    ///
    /// # Errors
    /// If it cannot be reached.
    fn harm(&mut self, harm: Provocation) -> Result<(), InstrumentError>;

    /// A bit flips in what decides; `which` of the things, of which element.
    ///
    /// # Errors
    /// If it cannot be reached.
    fn upset(&mut self, which: usize, element: usize, bit: u32) -> Result<bool, InstrumentError>;

    /// All settings that it keeps.
    ///
    /// # Errors
    /// If it cannot be reached, or keeps none.
    fn kept(&mut self) -> Result<Settings, InstrumentError>;

    /// Stores settings while the supply fails after so many bytes. Whether it has failed: all may
    /// have been written by then.
    ///
    /// # Errors
    /// If it cannot be reached, or keeps none.
    fn store_with_a_cut(&mut self, settings: &Settings, after_bytes: u32) -> Result<bool, InstrumentError>;
}

impl Subject for Emulated {
    fn silence(&mut self) -> Result<Heaters, InstrumentError> {
        Ok(Emulated::silence(self)?.heaters)
    }

    fn hear(&mut self, bytes: &[u8]) -> Result<(), InstrumentError> {
        self.inject(bytes)
    }

    fn counted(&mut self) -> Result<(u32, LinkCounters), InstrumentError> {
        Ok(self.status().map_or((0, LinkCounters::default()), |status| (status.uptime_s, status.link)))
    }

    fn harm(&mut self, harm: Provocation) -> Result<(), InstrumentError> {
        self.provoke(harm)?;
        if !matches!(harm, Provocation::BitFlip { .. }) {
            self.reborn()?;
        }
        Ok(())
    }

    /// Its memory is hit anywhere, by [`harm`](Self::harm).
    fn upset(&mut self, _: usize, _: usize, _: u32) -> Result<bool, InstrumentError> {
        Ok(false)
    }

    fn kept(&mut self) -> Result<Settings, InstrumentError> {
        read_all(self)?.settings.map_err(InstrumentError::Settings)
    }

    fn store_with_a_cut(&mut self, settings: &Settings, after_bytes: u32) -> Result<bool, InstrumentError> {
        let requests = write_requests(settings).map_err(|error| InstrumentError::Protocol(error.to_string()))?;
        self.ask_with_a_cut(after_bytes, &requests)
    }
}
