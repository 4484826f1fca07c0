//! Simple laws of response beside a diffusive model, compared by what they forecast.
//!
//! Charge in a dielectric, a heater, or any other system of one input u and one output y is often
//! described by one formula for its answer to a step. Each law here is such a formula, linear in
//! the input and applied to any input by convolution:
//!
//! ```text
//! y(t_n) = y_rest + Σ_i A_i [Σ_m u_m (S_i(t_n − t_m) − S_i(t_n − t_{m+1}))  +  c_i D_i(t_n − t_0)]
//!
//! exponentials              S_i = 1 − exp(−t/τ_i)       one to four of them
//! stretched exponential     S = 1 − exp(−(t/τ)^β)       0 < β ≤ 1
//! square root of time       S = √t
//! ```
//!
//! with u held from row to row, A in units of y by units of u, τ in s. Source: M. T. Atienza, PhD
//! thesis, UPC 2017, (2.63–2.68), and what is cited there for charge trapping in MEMS.
//!
//! Initial state: nothing is known of the input before the first row. Every law is given the same
//! freedom: an unknown rest value, and for each of its terms an unknown decay of the term's own
//! shape, D = S(∞) − S(t) (−√t for the square root), as if the input had been held at an unknown
//! level until the first row. For exponentials this is the most general history that there is; for
//! the other two it is the one that their formula describes by one number.
//!
//! A record is cut in two. All laws are fitted to the first part by one driver, the diffusive model
//! is identified from it by [`identify`](crate::identify::identify) with its defaults but for an
//! offset that stands, and all
//! forecast the second part, whose input is known and whose output is not looked at. [`compare()`]
//! does it all; [`LawsReport`] is the table.
//!
//! ```
//! use diffusive::identify::record::RecordTable;
//! use diffusive::laws::{FittedPart, compare};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // A relaxation of 20 s, driven by symbols ±1 that change in no simple rhythm.
//! let (mut state, mut shift, mut symbols) = (0.0, Vec::new(), Vec::new());
//! for n in 0..600_u32 {
//!     let symbol = if (n / 7 * 7919) % 13 < 6 { 1.0 } else { -1.0 };
//!     symbols.push(symbol);
//!     shift.push(0.1 + 0.5 * state);
//!     state += (1.0 - (-1.0_f64 / 20.0).exp()) * (symbol - state);
//! }
//! let columns = |name: &str, values| vec![(name.to_owned(), values)];
//! let (input, output) = (columns("symbol", symbols), columns("shift (V)", shift));
//! let mut record = RecordTable::new(1.0, input, output)?;
//! let report = compare(&mut record, FittedPart::default(), &mut |_, _, _| {})?;
//! let one = &report.laws[0];
//! assert!((one.terms[0].time_constant_s.unwrap() - 20.0).abs() < 1e-6);
//! assert!((one.terms[0].gain - 0.5).abs() < 1e-6 && one.held_out.rmse < 1e-6);
//! # Ok(())
//! # }
//! ```
//!
//! | file | holds |
//! |---|---|
//! | `law` | the laws: terms, shapes, bounds, starts of the search |
//! | `kernel` | step responses and their slopes by shape |
//! | `stream` | convolution of a step response with the input: by FFT, or a recursion |
//! | `products` | columns of a law, and their products |
//! | `fit` | variable projection: shapes by damped descent from several starts |
//! | `record` | the record, cut in two, and what is refused |
//! | `model_line` | the diffusive model, as one more law |
//! | `verdict` | which forecasts differ by more than noise |
//! | `compare`, `report` | the driver, and the table |
//!
//! Limits: one segment without gaps; rows whose output is missing are left out; conditions do not
//! change (labels are not looked at).

mod compare;
mod fit;
mod kernel;
mod law;
mod model_line;
mod products;
mod record;
mod report;
mod stream;
mod verdict;

pub use compare::compare;
pub use law::ResponseLaw;
pub use record::FittedPart;
pub use report::{LawForecast, LawTerm, LawsReport, PartFigures};

#[cfg(test)]
mod tests;
