//! Slow errors over time, from one equation a slot: filter, likelihood and smoother.
//!
//! ```text
//! S_i   Matérn 3/2: standard deviation σ, time constant τ
//!       covariance over a time Δ: σ² (1 + λΔ) e^(−λΔ), λ = √3/τ
//! γ_i   random walk from a standard deviation σ_γ on, by η in the root of a second
//! both  jump where a jump was found, each by an unknown amount of standard deviation 3 mW or 3 %
//! e     ρ e + √(1 − ρ²) w: what the calibration misses, of standard deviation 1
//! y     Σ_i (a_i S_i + b_i γ_i) + k e + √r v, and of overheats Σ_i a_i S_i + v
//! ```
//!
//! Winds near to each other are missed alike, hence ρ: a steady wind says once what many varied
//! ones say often. What no equation tells stays at zero, with its standard deviation. The smoother
//! says of every slot how much a jump there would explain (P. de Jong, J. Penzer, *Diagnosing
//! shocks in time series*, J. Am. Stat. Assoc. 93 (1998) 796). It
//! is that of Bryson and Frazier, which inverts no covariance (G. J. Bierman, *Fixed interval
//! smoothing with discrete measurements*, Int. J. Control 18 (1973) 65).

use dr_core::wind::sphere::SECTORS;
use nalgebra::{SMatrix, SVector};

/// S, its slope over λ, γ, and e.
const STATES: usize = 3 * SECTORS + 1;
const SLOPE: usize = SECTORS;
const GAIN: usize = 2 * SECTORS;
const MISSED: usize = 3 * SECTORS;
/// S and γ.
pub const ERRORS: usize = 2 * SECTORS;

type State = SVector<f64, STATES>;
type Covariance = SMatrix<f64, STATES, STATES>;

/// Size and quickness of slow errors, before anything is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlowPrior {
    /// σ, mW.
    pub offset_mw: f64,
    /// τ, s.
    pub time_s: f64,
    /// σ_γ, %.
    pub gain_percent: f64,
    /// η, %/√s.
    pub gain_walk: f64,
    /// The common part of all surfaces is sought; if not, it stays zero, as uncertain as it was.
    pub is_common_sought: bool,
    /// Factor of the equations' variances; where it is more than 1, of k² as well.
    pub noise: f64,
}

/// One equation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlowEquation {
    /// y.
    pub value: f64,
    /// a, 1/mW.
    pub per_mw: [f64; SECTORS],
    /// b, 1/%.
    pub per_percent: [f64; SECTORS],
    /// r.
    pub variance: f64,
    /// k.
    pub missed: f64,
    /// ρ to the equation before.
    pub correlation: f64,
    /// Wind about which it is linear, m/s.
    pub wind_m_s: [f64; 3],
}

impl SlowEquation {
    /// y less what these errors explain.
    pub fn left(&self, errors: &SVector<f64, ERRORS>) -> f64 {
        let per = self.per_mw.iter().chain(&self.per_percent);
        self.value - per.zip(errors.iter()).map(|(per, error)| per * error).sum::<f64>()
    }

    /// Variance of the value by noise and calibration.
    pub fn own_variance(&self) -> f64 {
        self.variance + self.missed * self.missed
    }

    fn row(&self, noise: f64) -> State {
        let mut row = State::zeros();
        for i in 0..SECTORS {
            row[i] = self.per_mw[i];
            row[GAIN + i] = self.per_percent[i];
        }
        row[MISSED] = self.missed * noise.max(1.0).sqrt();
        row
    }
}

/// A jump of an error at the begin of a slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SlowJump {
    /// The slot.
    pub slot: usize,
    /// Error: S or γ.
    pub error: usize,
}

/// Standard deviation of a jump, mW or %.
const JUMP: f64 = 3.0;

/// Equations with the jumps between them.
#[derive(Debug, Clone, Copy)]
pub struct SlowSeries<'a> {
    /// One a slot, where there is one.
    pub slots: &'a [Option<SlowEquation>],
    /// Length of a slot, s.
    pub slot_s: f64,
    /// In any order.
    pub jumps: &'a [SlowJump],
    /// Equations of overheats that alternate, in any order.
    pub overheats: &'a [OverheatEquation],
}

/// Equations of S at a slot, from halves of two overheats: four equations y = A S + v, v of
/// variance 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OverheatEquation {
    /// The slot.
    pub slot: usize,
    /// y.
    pub value: SVector<f64, SECTORS>,
    /// A, 1/mW.
    pub per_mw: SMatrix<f64, SECTORS, SECTORS>,
}

/// S in mW and γ in % at a slot, with their covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlowErrorsAt {
    /// S, then γ.
    pub errors: SVector<f64, ERRORS>,
    /// Covariance of both.
    pub covariance: SMatrix<f64, ERRORS, ERRORS>,
}

/// Knowledge of the filter at a slot.
struct PassedSlot {
    state: State,
    covariance: Covariance,
    /// Updates of its equations, one after the other.
    updates: Vec<FilterUpdate>,
}

/// Change by one equation.
struct FilterUpdate {
    row: State,
    gain: State,
    /// Variance of the innovation.
    variance: f64,
    innovation: f64,
    /// ρ by which e was changed before.
    rho: f64,
}

impl FilterUpdate {
    /// Takes an equation of a value and its variance into what is known.
    fn of(state: &mut State, known: &mut Covariance, row: State, (value, variance): (f64, f64), rho: f64) -> Self {
        let carried = *known * row;
        let variance = row.dot(&carried) + variance;
        let gain = carried / variance;
        let innovation = value - row.dot(state);
        *state += gain * innovation;
        *known -= gain * carried.transpose();
        Self { row, gain, variance, innovation, rho }
    }

    /// Its part of −2 ln of the likelihood.
    fn doubt(&self) -> f64 {
        libm::log(self.variance) + self.innovation * self.innovation / self.variance
    }
}

/// Runs forward; returns −2 ln of the likelihood.
fn filter(prior: &SlowPrior, series: &SlowSeries<'_>, mut each: impl FnMut(PassedSlot)) -> f64 {
    let (transition, added) = transition(prior, series.slot_s);
    let mut state = State::zeros();
    let mut covariance = Covariance::zeros();
    for (first, size) in [(0, prior.offset_mw), (SLOPE, prior.offset_mw), (GAIN, prior.gain_percent)] {
        for (i, j) in pairs() {
            covariance[(first + i, first + j)] = size * size * prior.sought(i, j);
        }
    }
    covariance[(MISSED, MISSED)] = 1.0;
    let mut doubt = 0.0;
    for (n, slot) in series.slots.iter().enumerate() {
        if n > 0 {
            state = transition * state;
            covariance = transition * covariance * transition.transpose() + added;
            for jump in series.jumps.iter().filter(|jump| jump.slot == n) {
                covariance[(place(jump.error), place(jump.error))] += JUMP * JUMP;
            }
        }
        let mut updates = Vec::new();
        if let Some(equation) = slot {
            let rho = equation.correlation;
            state[MISSED] *= rho;
            for i in 0..MISSED {
                covariance[(i, MISSED)] *= rho;
                covariance[(MISSED, i)] *= rho;
            }
            covariance[(MISSED, MISSED)] = rho * rho * covariance[(MISSED, MISSED)] + 1.0 - rho * rho;
            let variance = prior.noise * equation.variance;
            let row = equation.row(prior.noise);
            updates.push(FilterUpdate::of(&mut state, &mut covariance, row, (equation.value, variance), rho));
        }
        for of in series.overheats.iter().filter(|of| of.slot == n) {
            for (per_mw, value) in of.per_mw.row_iter().zip(&of.value) {
                let mut row = State::zeros();
                row.rows_mut(0, SECTORS).copy_from(&per_mw.transpose());
                updates.push(FilterUpdate::of(&mut state, &mut covariance, row, (*value, 1.0), 1.0));
            }
        }
        doubt += updates.iter().map(FilterUpdate::doubt).sum::<f64>();
        each(PassedSlot { state, covariance, updates });
    }
    doubt
}

/// Place of S or γ in the state.
const fn place(error: usize) -> usize {
    if error < SECTORS { error } else { error + SECTORS }
}

/// Transition of a slot and what it adds to the covariance; e changes with the equations.
fn transition(prior: &SlowPrior, slot_s: f64) -> (Covariance, Covariance) {
    let a = 3.0_f64.sqrt() * slot_s / prior.time_s;
    let decay = libm::exp(-a);
    let [[ss, sd], [ds, dd]] = [[1.0 + a, a], [-a, 1.0 - a]].map(|row| row.map(|x| decay * x));
    let (mut transition, mut added) = (Covariance::identity(), Covariance::zeros());
    for (i, j) in pairs() {
        let variance = prior.offset_mw.powi(2) * prior.sought(i, j);
        for ((row, column), value, of_added) in [
            ((0, 0), ss, 1.0 - ss * ss - sd * sd),
            ((0, SLOPE), sd, -ss * ds - sd * dd),
            ((SLOPE, 0), ds, -ss * ds - sd * dd),
            ((SLOPE, SLOPE), dd, 1.0 - ds * ds - dd * dd),
        ] {
            if i == j {
                transition[(row + i, column + i)] = value;
            }
            added[(row + i, column + j)] = variance * of_added;
        }
        added[(GAIN + i, GAIN + j)] = prior.gain_walk.powi(2) * slot_s * prior.sought(i, j);
    }
    (transition, added)
}

/// −2 ln of the likelihood of the equations.
pub fn doubt(prior: &SlowPrior, series: &SlowSeries<'_>) -> f64 {
    filter(prior, series, |_| {})
}

/// Slow errors at every slot, each from all equations; and the jump that would explain most beyond
/// them, with the square that it takes out of the residuals.
pub fn smooth(prior: &SlowPrior, series: &SlowSeries<'_>) -> (Vec<SlowErrorsAt>, Option<(SlowJump, f64)>) {
    let mut passed = Vec::with_capacity(series.slots.len());
    filter(prior, series, |of| passed.push(of));
    let (transition, _) = transition(prior, series.slot_s);
    // The adjoint of state and covariance behind the slot's update.
    let (mut pull, mut known) = (State::zeros(), Covariance::zeros());
    let mut found = Vec::with_capacity(series.slots.len());
    let mut jump: Option<(SlowJump, f64)> = None;
    for (slot, of) in passed.iter().enumerate().rev() {
        let state = of.state - of.covariance * pull;
        let covariance = of.covariance - of.covariance * known * of.covariance;
        found.push(SlowErrorsAt {
            errors: SVector::from_fn(|i, _| state[place(i)]),
            covariance: SMatrix::from_fn(|i, j| covariance[(place(i), place(j))] + prior.not_sought(i, j)),
        });
        for FilterUpdate { row, gain, variance, innovation, rho } in of.updates.iter().rev() {
            let kept = Covariance::identity() - gain * row.transpose();
            pull = kept.transpose() * pull - row * (innovation / variance);
            known = kept.transpose() * known * kept + row * row.transpose() / *variance;
            pull[MISSED] *= rho;
            for i in 0..STATES {
                known[(i, MISSED)] *= rho;
                known[(MISSED, i)] *= rho;
            }
        }
        for error in (0..ERRORS).filter(|&error| slot > 0 && prior.is_sought(error)) {
            let at = place(error);
            // The largest explanation, less the cost of any jump.
            let explains = pull[at].powi(2) / (known[(at, at)] + 1.0 / (JUMP * JUMP));
            if jump.is_none_or(|(_, most)| explains > most) {
                jump = Some((SlowJump { slot, error }, explains));
            }
        }
        pull = transition.transpose() * pull;
        known = transition.transpose() * known * transition;
    }
    found.reverse();
    (found, jump)
}

impl SlowPrior {
    /// Size of an error, mW or %.
    const fn size(&self, error: usize) -> f64 {
        if error < SECTORS { self.offset_mw } else { self.gain_percent }
    }

    /// Tells whether an error may be other than zero.
    fn is_sought(&self, error: usize) -> bool {
        self.size(error) > 0.0
    }

    /// Covariance of two surfaces' errors over σ².
    fn sought(&self, i: usize, j: usize) -> f64 {
        let own = if i == j { 1.0 } else { 0.0 };
        if self.is_common_sought { own } else { own - 1.0 / SECTORS as f64 }
    }

    /// Difference of that from independent errors.
    fn not_sought(&self, a: usize, b: usize) -> f64 {
        if self.is_common_sought || (a < SECTORS) != (b < SECTORS) {
            0.0
        } else {
            self.size(a).powi(2) / SECTORS as f64
        }
    }
}

/// All pairs of surfaces.
fn pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..SECTORS).flat_map(|i| (0..SECTORS).map(move |j| (i, j)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SLOT_S: f64 = 10.0;

    fn prior(offset_mw: f64, gain_percent: f64) -> SlowPrior {
        SlowPrior { offset_mw, time_s: 1e5, gain_percent, gain_walk: 0.0, is_common_sought: true, noise: 1.0 }
    }

    /// Equations of winds that turn by the golden angle, or of one wind, for offsets that `truth`
    /// gives, of unit noise from a fixed sequence.
    fn slots(turning: bool, truth: impl Fn(usize) -> [f64; SECTORS]) -> Vec<Option<SlowEquation>> {
        let equation = |n: usize| {
            let angle = if turning { 2.4 * n as f64 } else { 0.3 };
            let per_mw = core::array::from_fn(|i| 10.0 + 20.0 * libm::sin(angle * (1.0 + i as f64) + i as f64));
            let explained: f64 = per_mw.iter().zip(truth(n)).map(|(a, s)| a * s).sum();
            // Uniform of variance 1.
            let noise = 12.0_f64.sqrt() * ((n as f64 * 0.754_877_666).fract() - 0.5);
            let correlation = if turning { 0.0 } else { 1.0 };
            let per_percent = [0.0; SECTORS];
            Some(SlowEquation {
                value: explained + noise,
                per_mw,
                per_percent,
                variance: 1.0,
                missed: 1.0,
                correlation,
                wind_m_s: [1.0, 0.0, 0.0],
            })
        };
        (0..100).map(equation).collect()
    }

    #[test]
    fn varied_winds_tell_every_offset_within_what_is_stated() {
        let slots = slots(true, |_| [3.0, 0.0, -1.0, 0.5]);
        let (found, jump) =
            smooth(&prior(3.0, 0.0), &SlowSeries { slots: &slots, slot_s: SLOT_S, jumps: &[], overheats: &[] });
        for (i, truth) in [3.0, 0.0, -1.0, 0.5].into_iter().enumerate() {
            let (off, u) = (found[50].errors[i] - truth, found[50].covariance[(i, i)].sqrt());
            // A hundred equations of 20/mW and noise √2 leave some 0.01 mW.
            assert!(u < 0.05 && off.abs() < 3.0 * u, "{i}: {off} ± {u}");
        }
        assert!(jump.is_none_or(|(_, explains)| explains < 30.0), "{jump:?}");
    }

    #[test]
    fn halves_of_two_overheats_tell_every_offset_without_any_wind() {
        let truth = SVector::from([3.0, 0.0, -1.0, 0.5]);
        let equation = |n: usize| {
            let per_mw = SMatrix::from_fn(|i, j| if i == j { 5.0 } else { 0.5 * (n + i) as f64 % 1.0 });
            let noise =
                SVector::from_fn(|i, _| 12.0_f64.sqrt() * ((n as f64 * 0.754_877_666 + i as f64 * 0.3).fract() - 0.5));
            OverheatEquation { slot: 10 * n, value: per_mw * truth + noise, per_mw }
        };
        let overheats: Vec<_> = (0..10).map(equation).collect();
        let series = SlowSeries { slots: &[None; 100], slot_s: SLOT_S, jumps: &[], overheats: &overheats };
        let (found, jump) = smooth(&prior(3.0, 0.0), &series);
        for i in 0..SECTORS {
            let (off, u) = (found[50].errors[i] - truth[i], found[50].covariance[(i, i)].sqrt());
            // Ten equations of 5/mW leave 0.2/√10 mW.
            assert!((0.05..0.08).contains(&u) && off.abs() < 3.0 * u, "{i}: {off} ± {u}");
        }
        assert!(jump.is_none_or(|(_, explains)| explains < 30.0), "{jump:?}");
        // Nothing of gains.
        let gains = smooth(&SlowPrior { gain_percent: 1.0, ..prior(3.0, 0.0) }, &series).0[50];
        assert!((gains.covariance[(SECTORS, SECTORS)] - 1.0).abs() < 1e-9, "{gains:?}");
    }

    #[test]
    fn a_steady_wind_says_one_number_however_long_it_blows() {
        let slots = slots(false, |_| [3.0, 0.0, 0.0, 0.0]);
        let (found, _) =
            smooth(&prior(3.0, 0.0), &SlowSeries { slots: &slots, slot_s: SLOT_S, jumps: &[], overheats: &[] });
        let block = found[50].covariance.fixed_view::<SECTORS, SECTORS>(0, 0).into_owned();
        let open = block.symmetric_eigenvalues().iter().filter(|&&of| of > 0.9 * 9.0).count();
        assert_eq!(open, 3);
    }

    #[test]
    fn a_jump_is_found_where_it_is_and_what_all_share_stays_if_it_is_not_sought() {
        let slots = slots(true, |n| if n < 60 { [0.0; SECTORS] } else { [0.0, 2.0, 0.0, 0.0] });
        let own = SlowPrior { offset_mw: 0.01, ..prior(0.01, 0.0) };
        let (_, jump) = smooth(&own, &SlowSeries { slots: &slots, slot_s: SLOT_S, jumps: &[], overheats: &[] });
        let (jump, explains) = jump.unwrap();
        assert!(jump == SlowJump { slot: 60, error: 1 } && explains > 100.0, "{jump:?} {explains}");

        let all = self::slots(true, |_| [1.0; SECTORS]);
        let not = SlowPrior { is_common_sought: false, ..prior(3.0, 0.0) };
        let (found, _) = smooth(&not, &SlowSeries { slots: &all, slot_s: SLOT_S, jumps: &[], overheats: &[] });
        let (sum, ones) =
            (found[50].errors.rows(0, SECTORS).sum(), found[50].covariance.fixed_view::<4, 4>(0, 0).sum());
        // The mean of four independent errors of 3 mW is uncertain by 1.5 mW.
        assert!(sum.abs() < 1e-9 && (ones.sqrt() / 4.0 - 1.5).abs() < 1e-6, "{sum} {ones}");
    }

    #[test]
    fn the_likelihood_prefers_errors_of_the_size_that_there_is() {
        let slots = slots(true, |_| [3.0, 0.0, -1.0, 0.5]);
        let series = SlowSeries { slots: &slots, slot_s: SLOT_S, jumps: &[], overheats: &[] };
        let [none, small, right] = [0.0, 0.03, 2.0].map(|mw| doubt(&prior(mw, 0.0), &series));
        assert!(right < small && small < none, "{none} {small} {right}");
        let quiet = self::slots(true, |_| [0.0; SECTORS]);
        let series = SlowSeries { slots: &quiet, ..series };
        assert!(doubt(&prior(0.0, 0.0), &series) < doubt(&prior(2.0, 0.0), &series));
    }
}
