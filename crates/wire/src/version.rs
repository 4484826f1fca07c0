//! Version of the protocol.

/// Version of messages and framing together. Whatever it becomes, a frame stays COBS with a zero at
/// its end, its first byte the version, its last two the CRC of all before: so either side can name
/// the version of the other.
///
/// Version 7 has what a host needs that logs for weeks, so that such hosts need no other version:
///
/// - Time: the number of a tick times the sample period is the board's clock, which a host compares
///   with its own; a time stamp would only repeat it.
/// - One recording over several connections: `Identity::starts` and `Identity::unique_id` tell
///   whether it is the same life of the same board, `Sample::tick` and `Event` what is missing.
/// - An alarm without samples: `Status::state`, `Status::history`, and `Event` in the tick of a
///   trip.
pub const VERSION: u8 = 7;
