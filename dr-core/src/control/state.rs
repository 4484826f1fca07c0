//! The controller's shared types: run state, heater levels, an element's configuration, and the
//! result of one tick.

use super::guard::{Cause, Limits, Trip};
use crate::sensor::{Channel, Level};

/// Run state of the instrument.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RunState {
    /// Sensing, all heaters low.
    #[default]
    Standby,
    /// Every element follows its drive.
    Running,
    /// All heaters low until acknowledged.
    Tripped(Trip),
    /// In a self-test that heats, for its planned length.
    Testing,
}

impl RunState {
    /// The state in one word.
    pub(crate) fn word(self) -> u32 {
        match self {
            Self::Standby => 0,
            Self::Running => 1,
            Self::Tripped(Trip { cause, element }) => {
                2 | (cause as u32) << 8 | u32::from(element.unwrap_or(0xff)) << 16
            }
            Self::Testing => 3,
        }
    }

    /// The trip of a state's word, if it is tripped.
    pub(crate) fn tripped_of(word: u32) -> Option<Trip> {
        let [2, cause, element, 0] = word.to_le_bytes() else { return None };
        let cause = Cause::from_repr(usize::from(cause))?;
        Some(Trip { cause, element: (element != 0xff).then_some(element) })
    }
}

/// Request of a self-test for one tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Probe {
    /// No request.
    None,
    /// Readings may be of another input or missing and do not trip. Not granted while running.
    Blind,
    /// This element at the high level. Granted while testing, if its reading is valid.
    Pulse(u8),
}

/// Most elements of any controller: as many as a mask of levels or readings has bits. Boards have
/// fewer.
pub const MOST_ELEMENTS: usize = usize::BITS as usize;

/// Most elements of a board: as many as masks have bits where they travel, and as its messages and
/// settings have room for.
pub const BOARD_ELEMENTS: usize = u16::BITS as usize;

/// Levels of all elements: bit i is set while element i is at its high level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Heaters(#[cfg_attr(feature = "serde", serde(with = "board_mask"))] pub usize);

/// A mask of elements as it travels: that of a board. One of more elements is refused.
#[cfg(feature = "serde")]
pub mod board_mask {
    use serde::{Deserialize, Deserializer, Serialize, Serializer, ser::Error};

    /// Writes it.
    ///
    /// # Errors
    /// If it is not that of a board, or as `to` has them.
    pub fn serialize<S: Serializer>(mask: &usize, to: S) -> Result<S::Ok, S::Error> {
        u16::try_from(*mask).map_err(|_| S::Error::custom("no board has so many elements"))?.serialize(to)
    }

    /// Reads it.
    ///
    /// # Errors
    /// As `from` has them.
    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<usize, D::Error> {
        u16::deserialize(from).map(usize::from)
    }
}

impl Heaters {
    /// Tells whether element `i` is at its high level.
    pub const fn is_high(self, i: usize) -> bool {
        i < MOST_ELEMENTS && self.0 >> i & 1 == 1
    }

    /// The level of element `i`.
    pub(crate) const fn level(self, i: usize) -> Level {
        if self.is_high(i) { Level::High } else { Level::Low }
    }
}

/// An element's wiring and limits.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ElementConfig {
    /// From code to resistance, temperature and power.
    pub channel: Channel,
    /// Limits of plausible readings.
    pub limits: Limits,
}

/// Result of one tick. In the lists only the first `elements` entries are valid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tick<const N: usize> {
    /// Number of the tick since the start of the run.
    pub tick: u32,
    /// Number of configured elements.
    pub elements: u8,
    /// Levels held until the next tick.
    pub heaters: Heaters,
    /// Bit i is set if element i had a good reading in this tick.
    pub valid: usize,
    /// Temperatures at this tick, °C; the last good one where the reading was not.
    pub temperature_c: [f32; N],
    /// Heating power held until the next tick, W.
    pub power_w: [f32; N],
    /// Equivalent control of each element by its observer, W: the conduction into its structure; 0
    /// without a model. Only while observing.
    pub equivalent_power_w: Option<[f32; N]>,
    /// The state after this tick.
    pub state: RunState,
    /// The trip of this tick.
    pub trip: Option<Trip>,
}
