//! The benchmark of the whole instrument on the simulated sensors: what it has to reach, and what
//! it reaches. `anemo benchmark`.
//!
//! | module | holds |
//! |---|---|
//! | [`wind`] | from records of still gas to the wind: the two spheres, by the numbers that the estimates have to reach |

pub mod wind;
