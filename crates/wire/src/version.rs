//! Version of the protocol.

/// Version of messages and framing together. Whatever it becomes, a frame stays COBS with a zero at
/// its end, its first byte the version, its last two the CRC of all before: so either side can name
/// the version of the other.
///
/// Since version 7 it has what a host needs that logs for weeks:
///
/// - Time: the number of a tick times the sample period is the board's clock, which a host compares
///   with its own; a time stamp would only repeat it.
/// - One recording over several connections: `Identity::starts` and `Identity::unique_id` tell
///   whether it is the same life of the same board, `Sample::tick` and `Event` what is missing.
/// - An alarm without samples: `Status::state`, `Status::history`, and `Event` in the tick of a
///   trip.
pub const VERSION: u8 = 8;
