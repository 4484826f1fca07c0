//! Simulated records for tests of identification: what a thermal experiment would have measured,
//! with the truth beside it.
//!
//! | module | simulates |
//! |---|---|
//! | [`foster`] | relaxations with given or random rates: any excitation, noise, start, quantisation, dead time, feed-through |
//! | [`rod`] | a heated head on a cooled rod in winds that switch |
//! | [`slow_rod`] | the same rod, recorded no longer than it takes to settle, and a second record to validate on |
//! | [`heads`] | several heads on one body that warm each other, each in its own wind |
//! | [`flux`] | a heat-flux sensor: a share of the heat passes at once, the rest as the plate warms, all of it late |
//!
//! Every record follows one convention: row n holds the outputs at n·Ts and the inputs over [n, n +
//! 1)·Ts. Thermal networks are stepped exactly ([`network`]), so what an identification leaves
//! above the noise is its own. All are seeded.

pub mod excitation;
pub mod flux;
pub mod foster;
pub mod heads;
pub mod network;
pub mod noise;
pub mod rod;
pub mod slow_rod;
mod table;

pub use excitation::Excitation;
pub use noise::Noise;
pub use table::{Column, write_csv};

/// The generator that everything here draws from.
pub type Random = rand_chacha::ChaCha8Rng;

/// A generator of its own for every purpose, so that a record's noise can change without its input.
pub fn random(seed: u64, stream: u64) -> Random {
    let mut random = <Random as rand_chacha::rand_core::SeedableRng>::seed_from_u64(seed);
    random.set_stream(stream);
    random
}
