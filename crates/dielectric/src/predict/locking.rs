//! Charge locking: where a loop of first order repeats the same few symbols, so that a whole range
//! of set-points gives one mean symbol.
//!
//! Under a periodic stream with p ones in q symbols, evenly spread, b_n = ⌊(n+1) p/q⌋ − ⌊n p/q⌋,
//! the model settles to a periodic shift y_n. A loop that puts a one wherever y_n lies below its
//! set-point repeats that stream for every set-point T with
//!
//! max { y_n : b_n = 1 } < T ≤ min { y_n : b_n = 0 }
//!
//! A loop of second order cannot stay there: the sum of its errors grows until a symbol changes.

use dr_core::model::mesh;
use serde::Serialize;

/// A plateau.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Plateau {
    /// Ones, p.
    pub ones: usize,
    /// Symbols, q.
    pub symbols: usize,
    /// Mean symbol, 2 p/q − 1.
    pub mean_symbol: f64,
    /// Set-points from here, V …
    pub from_v: f64,
    /// … up to here, V.
    pub to_v: f64,
}

/// Response to a stream of symbols.
#[derive(Debug, Clone, PartialEq)]
pub struct SymbolResponse {
    /// Shift without symbols, V.
    pub offset_v: f64,
    /// Parts that add up.
    pub parts: Vec<ResponsePart>,
    /// T_s, s.
    pub symbol_time_s: f64,
}

/// Relaxations that one input of a model drives.
#[derive(Debug, Clone, PartialEq)]
pub struct ResponsePart {
    /// ξ_k, rad/s.
    pub rates_rad_s: Vec<f64>,
    /// R_k, V a symbol.
    pub gains_v: Vec<f64>,
    /// Response at once, V a symbol.
    pub feed_through_v: f64,
    /// Symbols by which all of it is late.
    pub dead_time: usize,
}

impl SymbolResponse {
    /// Shift under the same symbol for ever, V beyond the offset.
    pub fn steady_v(&self) -> f64 {
        self.parts.iter().map(|part| part.gains_v.iter().sum::<f64>() + part.feed_through_v).sum()
    }

    /// Voltage shifts at the start of every symbol of a stream that repeats for ever, V.
    pub fn periodic_v(&self, bits: &[bool]) -> Vec<f64> {
        let mut shifts_v = vec![self.offset_v; bits.len()];
        for part in &self.parts {
            let own_v = part.periodic_v(bits, self.symbol_time_s);
            for (n, shift_v) in shifts_v.iter_mut().enumerate() {
                *shift_v += own_v[(n + bits.len() - part.dead_time % bits.len()) % bits.len()];
            }
        }
        shifts_v
    }

    /// The plateau of p ones in q symbols, if set-points lock to it.
    pub fn plateau(&self, ones: usize, symbols: usize) -> Option<Plateau> {
        let bits: Vec<bool> = (0..symbols).map(|n| (n + 1) * ones / symbols > n * ones / symbols).collect();
        let shifts_v = self.periodic_v(&bits);
        let of = |bit: bool| shifts_v.iter().zip(&bits).filter(move |(_, own)| **own == bit).map(|(v, _)| *v);
        let from_v = of(true).fold(f64::NEG_INFINITY, f64::max);
        let to_v = of(false).fold(f64::INFINITY, f64::min);
        let mean_symbol = 2.0 * ones as f64 / symbols as f64 - 1.0;
        (from_v < to_v).then_some(Plateau { ones, symbols, mean_symbol, from_v, to_v })
    }

    /// All plateaus of up to `most` symbols that are wider than `least_v`, by their set-points.
    pub fn plateaus(&self, most: usize, least_v: f64) -> Vec<Plateau> {
        let mut all: Vec<Plateau> = (2..=most)
            .flat_map(|symbols| (1..symbols).map(move |ones| (ones, symbols)))
            .filter(|(ones, symbols)| greatest_common_divisor(*ones, *symbols) == 1)
            .filter_map(|(ones, symbols)| self.plateau(ones, symbols))
            .filter(|plateau| plateau.to_v - plateau.from_v > least_v)
            .collect();
        all.sort_by(|a, b| a.from_v.total_cmp(&b.from_v));
        all
    }
}

impl ResponsePart {
    /// The same of one part, but for its dead time.
    fn periodic_v(&self, bits: &[bool], symbol_time_s: f64) -> Vec<f64> {
        let input = |bit: bool| if bit { 1.0 } else { -1.0 };
        let mut shifts_v: Vec<f64> = bits.iter().map(|bit| self.feed_through_v * input(*bit)).collect();
        for (&rate, &gain_v) in self.rates_rad_s.iter().zip(&self.gains_v) {
            let step = mesh::gain(rate, symbol_time_s);
            // From zero through one period, which is the share `period` of the way to itself.
            let advance = |x: f64, bit: &bool| x + step * (input(*bit) - x);
            let period = mesh::gain(rate, symbol_time_s * bits.len() as f64);
            let mut x = bits.iter().fold(0.0, advance) / period;
            for (shift_v, bit) in shifts_v.iter_mut().zip(bits) {
                *shift_v += gain_v * x;
                x = advance(x, bit);
            }
        }
        shifts_v
    }
}

fn greatest_common_divisor(a: usize, b: usize) -> usize {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn response() -> SymbolResponse {
        let part =
            ResponsePart { rates_rad_s: vec![0.02, 0.3], gains_v: vec![1.0, 0.1], feed_through_v: 0.0, dead_time: 0 };
        SymbolResponse { offset_v: 0.2, parts: vec![part], symbol_time_s: 1.0 }
    }

    /// The mean bit of a loop of first order, simulated for long.
    fn mean_bit(response: &SymbolResponse, target_v: f64) -> f64 {
        let part = &response.parts[0];
        let mut x = vec![0.0; part.rates_rad_s.len()];
        let (mut ones, settle, count) = (0, 3000, 5040);
        // States that the loop sees now and later: the dead time is none or one.
        let mut late_v = 0.0;
        for n in 0..settle + count {
            let relaxed_v = x.iter().zip(&part.gains_v).map(|(x, gain)| x * gain).sum::<f64>();
            let shift_v = response.offset_v + if part.dead_time == 0 { relaxed_v } else { late_v };
            let bit = shift_v < target_v;
            ones += u32::from(bit && n >= settle);
            let symbol = if bit { 1.0 } else { -1.0 };
            late_v = relaxed_v + part.feed_through_v * symbol;
            for (x, rate) in x.iter_mut().zip(&part.rates_rad_s) {
                *x += mesh::gain(*rate, 1.0) * (symbol - *x);
            }
        }
        f64::from(ones) / f64::from(count)
    }

    #[test]
    fn a_simulated_loop_locks_just_where_the_plateaus_are() {
        locks(&response());
        // The response at once comes one symbol late.
        let mut late = response();
        late.parts[0] = ResponsePart { feed_through_v: 0.06, dead_time: 1, ..late.parts[0].clone() };
        locks(&late);
    }

    fn locks(response: &SymbolResponse) {
        let plateaus = response.plateaus(7, 0.0);
        assert!(plateaus.len() >= 3, "{plateaus:?}");
        for plateau in plateaus {
            let (width_v, bit) = (plateau.to_v - plateau.from_v, plateau.ones as f64 / plateau.symbols as f64);
            for share in [0.02, 0.5, 0.98] {
                let inside = mean_bit(response, plateau.from_v + share * width_v);
                assert!((inside - bit).abs() < 1e-9, "{plateau:?}, {share}: {inside}");
            }
            for target_v in [plateau.from_v - 0.05 * width_v, plateau.to_v + 0.05 * width_v] {
                assert!((mean_bit(response, target_v) - bit).abs() > 1e-5, "{plateau:?}, {target_v}");
            }
        }
    }

    #[test]
    fn a_stream_of_one_symbol_settles_to_its_steady_shift() {
        let shifts_v = response().periodic_v(&[true; 3]);
        assert!(shifts_v.iter().all(|shift_v| (shift_v - 1.3).abs() < 1e-12), "{shifts_v:?}");
    }
}
