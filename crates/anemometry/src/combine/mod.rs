//! One wind vector from several instruments, each of which sees a part of it: cards or boards round
//! a boom, booms beside each other, wires or cylinders on different axes, a vane.
//!
//! ```text
//! w_i / |v| = Σ_j c_ij Y_j(v/|v|) + n_i          n_i of the variance s_i²(v/|v|) + σ_i²/|v|²
//! ```
//!
//! | symbol | meaning |
//! |---|---|
//! | v | the wind, where the gas goes to: everywhere, or in a plane |
//! | w_i | component i of what the instruments estimate, each in its own frame and for a wind in its plane; the speed by a single element; of a vane, which knows no speed, w_i in place of w_i/\|v\| |
//! | c | how an instrument answers to winds from everywhere, its shadows and those of its neighbours included |
//! | Y | functions of the direction ([`space`]), to the degree that is best in winds that were left out |
//! | s | what these leave of winds whose directions were left out, and the scatter of rows beyond σ, by direction: an instrument in the lee of its own body, or of a mast, loses its weight there |
//! | ρ | correlation of what is left of the components, in all directions alike |
//! | σ | standard uncertainty as the instrument states it |
//!
//! The estimate is the v for which the components are likeliest; speeds count by shares, since what
//! instruments do wrong goes with the speed.
//!
//! | file | what |
//! |---|---|
//! | [`instrument`] | what one says at a time |
//! | [`readings`] | files of `anemo wind`, row by row and as means of steady winds |
//! | [`vane`] | the direction by junctions round a warm core |
//! | [`space`] | directions, and functions of them |
//! | `direction_fit` | least squares by these, and what they leave of directions that were left out |
//! | [`combination`] | the fit, and the file of it |
//! | [`estimate`] | the wind |
//! | [`report`] | errors, as text and as JSON |
//!
//! *Limits.* Answers are taken to grow with the speed; what they do besides is part of s.

pub mod combination;
mod direction_fit;
pub mod estimate;
pub mod instrument;
pub mod readings;
pub mod report;
pub mod space;
pub mod vane;

pub use combination::{Combination, CombineError};
pub use estimate::CombinedWind;
