//! Calibration of a head of surfaces on a sphere, round a cylinder, of wires in a plane, or of one
//! element: amplitudes of its local Nusselt number, gains, zero-wind conductances and mounting.
//!
//! ```text
//! c_i (q_i + G0_i a_i) = θ_i (k A_i / d) Nu_i(r)
//! Nu_i = Σ_n a_n(Re) q_n(i, w),   r = R v ρ d / µ,   w = −r/|r|
//! ```
//!
//! Known: winds v, readings q, θ, a (see [`readings`]), the head as drawn (q_n comes from dr-core).
//! Sought: the amplitudes a_n(Re), as splines in ln Re or by King's law, gains c_i of mean one,
//! zero-wind conductances G0_i ≥ 0, the mounting R.
//!
//! | file | what |
//! |---|---|
//! | [`readings`] | input, checked |
//! | [`speeds`], [`spread`] | whether the winds determine the unknowns, and which are missing |
//! | [`spline`], [`family`] | amplitudes as functions of the Reynolds number, and their prior |
//! | [`sought`], [`stream`] | rise of the warmed gas, and what is behind the stem |
//! | [`choice`] | which convection the readings determine |
//! | [`mounting`] | the turn between tunnel and head |
//! | [`king`] | exponent and yaw factor of King's law |
//! | [`equations`], [`fit`] | weighted least squares |
//! | [`solve`] | all steps in order |
//! | [`calibration`], [`grade`] | the result, with errors, as text, and as dr-core's configurations; what it is worth |
//! | [`folds`], [`cross_validation`] | errors in winds that were left out, through dr-core's inverse |
//!
//! *What no wind can tell.* A common factor of all gains is one of all amplitudes: the mean gain is
//! one by definition. A common offset of G0 is, at one overheat in one gas, one of a_0: quiescent
//! gas among the readings settles it, where Nu is 2. Without it only k A / d holds G0, to 30 %,
//! which matters once the gas temperature is another than that of the calibration.
//!
//! *Accuracy* on ideal 10 mm spheres in CO2 of 1000 Pa, Re 11 to 305, gains and mounting unknown,
//! 0.1 % of noise (tests): 12 speeds from 10 directions tell directions that were left out to 0.17°
//! and 0.17 % of speed rms, bands of speeds that were left out to 0.4° and 0.5 %; the mounting is
//! found within 0.02° (two hemispheres: 0.06°). 6 speeds from 6 directions still do for 0.2° and
//! 0.4 % (two hemispheres: 0.5° and 0.3 %). What is left comes from the bend that the simulated
//! amplitudes have at Re 200. Gas 5 K warmer or colder than in the calibration costs nothing,
//! without quiescent gas among the readings 0.5 % of speed.
//!
//! *Limits.* The winds count as known exactly; their errors belong into the variances. One Prandtl
//! number.

pub mod calibration;
pub mod choice;
pub mod cross_validation;
pub mod equations;
pub mod family;
pub mod fit;
pub mod folds;
pub mod grade;
pub mod king;
pub mod mounting;
pub mod readings;
pub mod solve;
pub mod sought;
pub mod speeds;
pub mod spline;
pub mod spread;
pub mod stream;
