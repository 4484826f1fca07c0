//! Lists and texts of bounded length, which need no heap.

/// Most elements of any instrument; `Identity` contains the number of a board.
pub const MOST_ELEMENTS: usize = 16;

/// One entry an element: as many as are configured.
pub type List<T> = heapless::Vec<T, MOST_ELEMENTS>;

/// A short text.
pub type Name = heapless::String<32>;
