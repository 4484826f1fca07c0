//! Version of the protocol.

/// Version of messages and framing together. Whatever it becomes, a frame stays COBS with a zero at
/// its end, its first byte the version, its last two the CRC of all before: so either side can name
/// the version of the other.
pub const VERSION: u8 = 7;
