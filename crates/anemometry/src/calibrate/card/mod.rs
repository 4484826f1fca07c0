//! Calibration of the four dice of a card: from their readings in known winds of the card's plane
//! to the curves by which dr-core's [`card`](dr_core::wind::card_inverse) estimates unknown ones.
//!
//! ```text
//! Nu_i = c_i (q_i + G0 a_i) / (θ_i k a)          G0 = 4/√π k a
//! (D_p, D_q) = −Re^n (P(θ), Q(θ)) + (ε_p, ε_q) M
//! M = mean(√(Re E(θ)))                           E is 1 head-on
//! c_i = 1/(1 + ε_p p_i + ε_q q_i + ε_t p_i q_i)
//! ```
//!
//! The differences D follow by linear least squares for every n, and the n that leaves least is
//! taken; the mean M by Gauss–Newton, for knots and harmonics together. Gains c are not 1, as dice
//! that are not alike lose more or less in every wind.
//!
//! G0 is the conduction of a square on a plane into quiescent gas: the quiescent-gas network
//! includes it, and the wind adds to it. The error of each curve by itself follows from the
//! readings: `mean_share` and `difference_share` are what the fit leaves. With winds that are held
//! shorter than the card takes to cool (minutes) most of the former is what the card still
//! remembers, so hold them for about as long as winds last where they are to be told.
//!
//! *Limits.* Winds in the plane, in the frame in which the normal of the card and its tip are
//! given; no mounting is sought.
//!
//! | file | what |
//! |---|---|
//! | [`drawn`] | a card as drawn, and its winds |
//! | [`spread`] | which winds are missing |
//! | [`differences`], [`mean`] | the curves (D_p, D_q) and M |
//! | [`calibration`] | the result, as text, and as dr-core's configuration |
//! | [`solve`] | all steps in order, and the cross-validation |

pub mod calibration;
pub mod differences;
pub mod drawn;
pub mod mean;
pub mod solve;
pub mod spread;

pub use solve::{calibrate, cross_validate};
