//! Lists and texts of bounded length, which need no heap.

pub use dr_core::control::BOARD_ELEMENTS as MOST_ELEMENTS;

/// One entry an element: as many as are configured.
pub type List<T> = heapless::Vec<T, MOST_ELEMENTS>;

/// A short text.
pub type Name = heapless::String<32>;
