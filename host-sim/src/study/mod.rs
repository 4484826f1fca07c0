//! Studies of the whole instrument on the simulated sensors: what has to be reached, and what is: `anemo study`.
//!
//! | module | holds |
//! |---|---|
//! | [`wind`] | from records of still gas to the wind: the two spheres, by the numbers that the answers have to reach |

pub mod wind;
