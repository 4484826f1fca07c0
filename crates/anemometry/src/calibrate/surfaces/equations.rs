//! The normal equations of a calibration at one point, and the points to which a step leads.
//!
//! ```text
//! q̂_i = θ_i (k A_i / d) Nu_i / c_i − γ_i g_i a_i          residual (q_i − q̂_i) / σ_i
//! G0_i = γ_i g_i,  g_i = k̄ A_i / d
//! c = 1 + Z u          Z: N × (N − 1), columns sum to zero, so that the mean of c is one
//! ```
//!
//! Unknowns in this order: coefficients of the amplitudes, u, γ, turns of the mounting, what is
//! sought of King's law, its exponent m and the square of its yaw factor, κ, and what is sought of
//! the stream ([`sought`](super::sought)), by which r moves. k̄ is the
//! mean of k over the readings, so that γ is about the Nusselt number at rest, Nu_0. The prior
//! enters as rows of its own: that of the [`family`](super::family), γ Nu_0 (1 ± `QUIESCENT`), u 0
//! ± `GAIN`, and for a turn about the only axis of a cylinder or of wires 0 ± `TURN`.

use std::borrow::Cow;

use dr_core::wind::FreeStream;
use dr_core::wind::nusselt::ORDERS;
use dr_core::wind::surface::LocalNusselt;
use nalgebra::{DMatrix, DVector, Vector3};

use super::family::{AmplitudeFamily, AmplitudeShape, BasisAt, SIZE};
use super::mounting::Mounting;
use super::readings::{CheckedReading, CheckedWind, SurfaceGeometry, met_m_s};

/// Relative standard error of γ before any reading: a reference gas some 20 K from the mean one,
/// and the areas as drawn, make half of it.
pub const QUIESCENT: f64 = 0.3;
/// Standard error of a gain before any reading.
const GAIN: f64 = 0.2;
/// Standard error of a turn about the only axis before any reading, rad.
const TURN: f64 = 0.1;

/// Step in Re, over which the slopes of amplitudes are taken.
const SLOPE_STEP: f64 = 1e-3;

/// U²/v² at least: that of a wind 0.06° from a wire of no yaw.
const LEAST_SEEN: f64 = 1e-6;

/// A sphere, its readings, and the shape of its amplitudes.
pub struct SurfaceProblem<'a> {
    /// The sphere.
    pub head: &'a SurfaceGeometry<'a>,
    /// Its readings.
    pub winds: &'a [CheckedWind],
    /// Amplitudes over the Reynolds number.
    pub family: AmplitudeFamily,
    /// g_i, W/K.
    pub quiescent_unit_w_k: Vec<f64>,
    /// Z
    pub spread: DMatrix<f64>,
    /// Unknowns of King's law.
    pub sought: Vec<LawUnknown>,
    /// A_n(Re) of every wind that is not still.
    at: Vec<Option<BasisAt>>,
}

/// An unknown of King's law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LawUnknown {
    /// m
    Exponent,
    /// κ
    YawSquare,
}

/// King's law at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SoughtLaw {
    /// m
    pub exponent: f64,
    /// κ: square of the yaw factor; of a single element 1.
    pub yaw_square: f64,
}

impl SoughtLaw {
    /// U²/v² at a cosine to the normal, not quite zero.
    fn seen_square(&self, cosine: f64) -> f64 {
        (cosine * cosine + self.yaw_square * (1.0 - cosine * cosine)).max(LEAST_SEEN)
    }

    /// (U/v)^m at a cosine to the normal.
    pub fn seen(&self, cosine: f64) -> f64 {
        libm::pow(self.seen_square(cosine), 0.5 * self.exponent)
    }
}

/// Weights of readings and of higher orders: the fit goes from coarse to fine.
#[derive(Debug, Clone, Copy)]
pub struct FitStage {
    /// Standard error of every Nusselt number beyond that of its reading.
    pub blur: f64,
    /// Size of the amplitudes from a_2 on.
    pub size: f64,
}

/// From afar: mean and a_1 alone show where the head points, with no valleys in which higher orders
/// make up for a wrong mounting.
pub const FIRST: FitStage = FitStage { blur: 0.2, size: 0.3 };
/// By the noise of the readings alone.
pub const LAST: FitStage = FitStage { blur: 0.0, size: SIZE };

/// A point in the space of the unknowns.
#[derive(Debug, Clone)]
pub struct FitPoint {
    /// Coefficients of the amplitudes.
    pub coefficients: Vec<f64>,
    /// c
    pub gains: Vec<f64>,
    /// γ
    pub quiescent: Vec<f64>,
    /// R
    pub mounting: Mounting,
    /// King's law, where its exponent or yaw factor is sought.
    pub law: SoughtLaw,
    /// Unknowns of the stream.
    pub stream: Vec<f64>,
}

/// H and b of H δ = b, and what is left over.
pub struct SurfaceEquations {
    /// H
    pub h: DMatrix<f64>,
    /// b
    pub b: DVector<f64>,
    /// Σ of squares, of the readings and of the prior.
    pub cost: f64,
    /// Sum of squares of the readings alone, and their share of H.
    pub chi_square: f64,
    /// H of the readings alone.
    pub of_readings: DMatrix<f64>,
    /// Rows of the design in σ, wind by wind, surface by surface.
    pub rows: Vec<Vec<f64>>,
    /// σ of every reading over its convective power.
    pub relative_errors: Vec<f64>,
    /// (q − q̂) / σ, wind by wind, surface by surface.
    pub residuals: Vec<f64>,
    /// Σ ((q − q̂) / (θ k A Nu / (d c)))²
    pub relative_square: f64,
}

impl<'a> SurfaceProblem<'a> {
    /// The problem of a sphere in these winds.
    pub fn new(head: &'a SurfaceGeometry<'a>, winds: &'a [CheckedWind], family: AmplitudeFamily) -> Self {
        let n = head.surfaces.len();
        let mean = |i: usize| winds.iter().map(|wind| wind.rows[i].unit_w_k).sum::<f64>() / winds.len() as f64;
        let quiescent_unit_w_k = (0..n).map(mean).collect();
        let at = winds.iter().map(|wind| (!wind.is_quiescent()).then(|| family.at(wind.reynolds))).collect();
        Self { head, winds, family, quiescent_unit_w_k, spread: sum_zero(n), sought: Vec::new(), at }
    }

    /// Point as drawn: no amplitudes beyond quiescent gas yet, gains of one.
    pub fn drawn(&self) -> FitPoint {
        let n = self.head.surfaces.len();
        FitPoint {
            coefficients: vec![0.0; self.family.count()],
            gains: vec![1.0; n],
            quiescent: vec![self.family.at_rest; n],
            mounting: Mounting::drawn(self.head.form(), &self.head.surfaces),
            law: SoughtLaw { exponent: 0.5, yaw_square: 1.0 },
            stream: self.head.drawn.convection.start(),
        }
    }

    /// Between the warmest and the coldest quiescent gas, K.
    pub fn quiescent_range_k(&self) -> f64 {
        let still = self.winds.iter().filter(|wind| wind.is_quiescent()).map(|wind| wind.gas_k);
        still.clone().reduce(f64::max).zip(still.reduce(f64::min)).map_or(0.0, |(most, least)| most - least)
    }

    /// First of u.
    pub fn first_gain(&self) -> usize {
        self.family.count()
    }

    /// First of γ.
    pub fn first_quiescent(&self) -> usize {
        self.first_gain() + self.spread.ncols()
    }

    /// First turn of the mounting.
    pub fn first_turn(&self) -> usize {
        self.first_quiescent() + self.head.surfaces.len()
    }

    /// First of what is sought of King's law.
    pub fn first_of_law(&self, place: &FitPoint) -> usize {
        self.first_turn() + place.mounting.turns.ncols()
    }

    /// First of what is sought of the stream.
    pub fn first_of_stream(&self, place: &FitPoint) -> usize {
        self.first_of_law(place) + self.sought.len()
    }

    /// Number of unknowns.
    pub fn unknowns(&self, place: &FitPoint) -> usize {
        self.first_of_stream(place) + place.stream.len()
    }

    /// Tells whether the stream of a point can be.
    pub fn has_stream(&self, place: &FitPoint) -> bool {
        place.stream.is_empty() || self.head.drawn.convection.free_stream(&place.stream).is_some()
    }

    /// Unknowns that are not negative, with their values: γ, κ, and those of the rise.
    pub fn not_negative(&self, place: &FitPoint) -> Vec<(usize, f64)> {
        let quiescent = place.quiescent.iter().enumerate().map(|(i, still)| (self.first_quiescent() + i, *still));
        let yaw = self.sought.iter().position(|of| *of == LawUnknown::YawSquare);
        let of_rise = place.stream.iter().take(self.head.drawn.convection.of_rise()).copied().enumerate();
        let rise = of_rise.map(|(k, value)| (self.first_of_stream(place) + k, value));
        quiescent.chain(yaw.map(|k| (self.first_of_law(place) + k, place.law.yaw_square))).chain(rise).collect()
    }

    /// The point that a step leads to.
    pub fn moved(&self, place: &FitPoint, by: &DVector<f64>) -> FitPoint {
        let by = by.as_slice();
        let (gain, still, turn) = (self.first_gain(), self.first_quiescent(), self.first_turn());
        let (turns, of_law) = by[turn..].split_at(place.mounting.turns.ncols());
        let (of_law, of_stream) = of_law.split_at(self.sought.len());
        let mut law = place.law;
        for (unknown, by) in self.sought.iter().zip(of_law) {
            match unknown {
                LawUnknown::Exponent => law.exponent += by,
                LawUnknown::YawSquare => law.yaw_square += by,
            }
        }
        let gains = &self.spread * DVector::from_column_slice(&by[gain..still]);
        let plus = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + b).collect();
        FitPoint {
            coefficients: plus(&place.coefficients, &by[..gain]),
            gains: plus(&place.gains, gains.as_slice()),
            quiescent: plus(&place.quiescent, &by[still..turn]),
            mounting: place.mounting.turned(turns),
            law,
            stream: plus(&place.stream, of_stream),
        }
    }

    /// The equations at a point.
    pub fn equations(&self, place: &FitPoint, stage: FitStage) -> SurfaceEquations {
        let m = self.unknowns(place);
        let mut sums = NormalSums { h: DMatrix::zeros(m, m), b: DVector::zeros(m), cost: 0.0 };
        let (mut rows, mut residuals, mut relative_errors) = (Vec::new(), Vec::new(), Vec::new());
        let mut relative_square = 0.0;
        let mut row = vec![0.0; m];
        let convection = &self.head.drawn.convection;
        let free = convection.free_stream(&place.stream).unwrap_or_default();
        let moved = convection.moved(&place.stream);
        for (wind, at) in self.winds.iter().zip(&self.at) {
            let stream = match (place.stream.is_empty(), at) {
                (false, _) => self.moving(place, wind, &free, &moved),
                (true, None) => None,
                (true, Some(at)) => Some(StreamAt {
                    at: Cow::Borrowed(at),
                    amplitudes: self.family.amplitudes(at, &place.coefficients),
                    from: -place.mounting.inward(wind.towards),
                    speed_ln: libm::log(wind.reynolds / self.family.most_reynolds),
                    moves: Vec::new(),
                    slopes: [0.0; ORDERS],
                }),
            };
            for (i, CheckedReading { reading, unit_w_k }) in wind.rows.iter().enumerate() {
                row.fill(0.0);
                let unit_w = reading.overheat_k * unit_w_k;
                let error_w = libm::hypot(reading.variance_w2.sqrt(), stage.blur * unit_w);
                let weight = unit_w / (place.gains[i] * error_w);
                let nusselt = match &stream {
                    Some(stream) if self.family.shape == AmplitudeShape::Law => {
                        self.law_row(place, i, stream, weight, &mut row)
                    }
                    Some(stream) => self.wind_row(place, i, stream, weight, &mut row),
                    None => {
                        if self.family.is_rest_sought {
                            row[self.family.count() - 1] = weight;
                        }
                        self.family.rest(&place.coefficients)
                    }
                };
                for k in 0..self.spread.ncols() {
                    row[self.first_gain() + k] = -weight * nusselt / place.gains[i] * self.spread[(i, k)];
                }
                let still = self.quiescent_unit_w_k[i] * reading.above_reference_k / error_w;
                row[self.first_quiescent() + i] = -still;
                let residual = reading.power_w / error_w - (weight * nusselt - still * place.quiescent[i]);
                sums.add(&row, residual);
                residuals.push(residual);
                relative_errors.push((weight * nusselt).recip());
                rows.push(row.clone());
                relative_square += (residual / (weight * nusselt)).powi(2);
            }
        }
        let (chi_square, mut of_readings) = (sums.cost, sums.h.clone());
        self.prior(place, stage, &mut sums);
        let NormalSums { mut h, b, cost } = sums;
        h.fill_lower_triangle_with_upper_triangle();
        of_readings.fill_lower_triangle_with_upper_triangle();
        SurfaceEquations { h, b, cost, chi_square, of_readings, rows, relative_errors, residuals, relative_square }
    }

    /// The stream that is met in a wind, if there is one, and how its Reynolds vector moves with
    /// what is sought of it.
    fn moving(
        &self,
        place: &FitPoint,
        wind: &CheckedWind,
        free: &FreeStream,
        moved: &[(FreeStream, f64)],
    ) -> Option<StreamAt<'_>> {
        let vector = |stream: &FreeStream| {
            place.mounting.inward(met_m_s(stream, wind).map(|v_m_s| v_m_s * wind.reynolds_per_speed))
        };
        let here = vector(free);
        let reynolds = here.norm();
        if reynolds <= 0.0 {
            return None;
        }
        let at = self.family.at(reynolds);
        let amplitudes = self.family.amplitudes(&at, &place.coefficients);
        let [below, above] = [-SLOPE_STEP, SLOPE_STEP]
            .map(|by| self.family.amplitudes(&self.family.at(reynolds * libm::exp(by)), &place.coefficients));
        Some(StreamAt {
            amplitudes,
            slopes: std::array::from_fn(|n| (above[n] - below[n]) / (2.0 * SLOPE_STEP)),
            at: Cow::Owned(at),
            from: -here / reynolds,
            speed_ln: libm::log(reynolds / self.family.most_reynolds),
            moves: moved.iter().map(|(stream, step)| (vector(stream) - here) / (step * reynolds)).collect(),
        })
    }

    /// Nu of surface `i`, and its derivatives to amplitudes and turns, each times `weight`.
    fn wind_row(&self, place: &FitPoint, i: usize, stream: &StreamAt<'_>, weight: f64, row: &mut [f64]) -> f64 {
        let StreamAt { at, amplitudes, from, moves, slopes, .. } = stream;
        let means: [LocalNusselt; ORDERS] =
            self.head.surfaces[i].per_amplitude([from.x as f32, from.y as f32, from.z as f32]);
        for (place, shares) in row.iter_mut().zip(at.iter()) {
            *place = weight * shares.iter().zip(&means).map(|(share, of)| share * f64::from(of.nusselt)).sum::<f64>();
        }
        let (mut nusselt, mut gradient) = (0.0, Vector3::zeros());
        for (a, mean) in amplitudes.iter().zip(&means) {
            nusselt += a * f64::from(mean.nusselt);
            gradient += Vector3::from(mean.gradient.map(f64::from)) * *a;
        }
        // A small turn δ moves w by δ × w; at a Reynolds number of one the gradient is −∂Nu/∂w
        // across w.
        self.turn_row(place, gradient.cross(from), weight, row);
        let slope: f64 = slopes.iter().zip(&means).map(|(slope, mean)| slope * f64::from(mean.nusselt)).sum();
        for (k, by) in moves.iter().enumerate() {
            row[self.first_of_stream(place) + k] = weight * (gradient - slope * from).dot(by);
        }
        nusselt
    }

    /// The same by King's law itself.
    fn law_row(&self, place: &FitPoint, i: usize, stream: &StreamAt<'_>, weight: f64, row: &mut [f64]) -> f64 {
        let (law, factor) = (place.law, place.coefficients[1]);
        let axis = Vector3::from(self.head.surfaces[i].axis().map(f64::from));
        let cosine = axis.dot(&stream.from);
        let seen_square = law.seen_square(cosine);
        let power = libm::exp(law.exponent * stream.speed_ln) * law.seen(cosine);
        row[0] = weight;
        row[1] = weight * power;
        for (k, unknown) in self.sought.iter().enumerate() {
            let per_unit = match unknown {
                LawUnknown::Exponent => stream.speed_ln + 0.5 * libm::log(seen_square),
                LawUnknown::YawSquare => 0.5 * law.exponent * (1.0 - cosine * cosine) / seen_square,
            };
            row[self.first_of_law(place) + k] = weight * factor * power * per_unit;
        }
        let turning = -factor * power * law.exponent * cosine * (1.0 - law.yaw_square) / seen_square;
        self.turn_row(place, (turning * axis).cross(&stream.from), weight, row);
        self.family.at_rest + place.coefficients[0] + factor * power
    }

    /// Derivatives to the turns of the mounting.
    fn turn_row(&self, place: &FitPoint, torque: Vector3<f64>, weight: f64, row: &mut [f64]) {
        for k in 0..place.mounting.turns.ncols() {
            row[self.first_turn() + k] = weight * torque.dot(&place.mounting.turns.fixed_view::<3, 1>(0, k));
        }
    }

    fn prior(&self, place: &FitPoint, stage: FitStage, sums: &mut NormalSums) {
        let mut row = vec![0.0; sums.b.len()];
        let mut known = |factors: &[(usize, f64)], residual: f64| {
            row.fill(0.0);
            factors.iter().for_each(|(k, factor)| row[*k] = *factor);
            sums.add(&row, residual);
        };
        for factors in self.family.prior(stage.size) {
            let value: f64 = factors.iter().map(|(k, factor)| factor * place.coefficients[*k]).sum();
            known(&factors, -value);
        }
        // Columns of Z are orthonormal: u = Zᵀ (c − 1).
        let gains = DVector::from_fn(place.gains.len(), |i, _| place.gains[i] - 1.0);
        for (k, u) in self.spread.tr_mul(&gains).iter().enumerate() {
            known(&[(self.first_gain() + k, 1.0 / GAIN)], -u / GAIN);
        }
        let error = QUIESCENT * self.family.at_rest;
        for (i, still) in place.quiescent.iter().enumerate() {
            known(&[(self.first_quiescent() + i, 1.0 / error)], (self.family.at_rest - still) / error);
        }
        let first = self.first_of_stream(place);
        for (factors, value) in self.head.drawn.convection.prior() {
            let now: f64 = factors.iter().map(|(k, factor)| factor * place.stream[*k]).sum();
            let factors: Vec<(usize, f64)> = factors.into_iter().map(|(k, factor)| (first + k, factor)).collect();
            known(&factors, value - now);
        }
        if !self.head.form().is_sphere() {
            let turned = Vector3::from(place.mounting.vector());
            for (k, turn) in place.mounting.turns.column_iter().enumerate() {
                known(&[(self.first_turn() + k, 1.0 / TURN)], -turned.dot(&turn.fixed_rows::<3>(0)) / TURN);
            }
        }
    }
}

/// The stream of one wind at a place.
struct StreamAt<'a> {
    at: Cow<'a, BasisAt>,
    amplitudes: [f64; ORDERS],
    /// w in the head's frame.
    from: Vector3<f64>,
    /// ln(Re/Re_most)
    speed_ln: f64,
    /// Change of r with what is sought of it, over Re.
    moves: Vec<Vector3<f64>>,
    /// d a_n / d ln Re
    slopes: [f64; ORDERS],
}

/// Upper triangle of H, b and the cost.
struct NormalSums {
    h: DMatrix<f64>,
    b: DVector<f64>,
    cost: f64,
}

impl NormalSums {
    fn add(&mut self, row: &[f64], residual: f64) {
        for (j, &y) in row.iter().enumerate().filter(|(_, y)| **y != 0.0) {
            self.b[j] += y * residual;
            for (i, &x) in row[..=j].iter().enumerate() {
                self.h[(i, j)] += x * y;
            }
        }
        self.cost += residual * residual;
    }
}

/// An orthonormal basis of the vectors of length n that sum to zero (Helmert).
fn sum_zero(n: usize) -> DMatrix<f64> {
    DMatrix::from_fn(n, n - 1, |i, k| {
        let size = ((k + 1) * (k + 2)) as f64;
        match i {
            _ if i <= k => 1.0 / size.sqrt(),
            _ if i == k + 1 => -((k + 1) as f64) / size.sqrt(),
            _ => 0.0,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_basis_of_the_gains_is_orthonormal_and_keeps_the_mean() {
        for n in 2..6 {
            let z = sum_zero(n);
            assert!((z.tr_mul(&z) - DMatrix::identity(n - 1, n - 1)).amax() < 1e-15);
            assert!((0..n - 1).all(|k| z.column(k).sum().abs() < 1e-15));
        }
    }
}
