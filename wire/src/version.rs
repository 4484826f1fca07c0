//! Version of the protocol.

/// Version of messages and framing together.
pub const VERSION: u8 = 6;
