//! Proof tests of what the safety of the heaters rests on, while the instrument runs.
//!
//! | file | what |
//! |---|---|
//! | `flash` | checksum of the image in flash, against the one that the build has put there |
//! | `ram` | which words of the RAM are tested next |

pub mod flash;
pub mod ram;
