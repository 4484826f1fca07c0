//! The spectrum of a stream of symbols, by octaves.
//!
//! The power of an octave is that of the difference of neighbouring means, ½⟨(mean of m symbols −
//! mean of the next m)²⟩ for m = 1, 2, 4 …: the Allan variance of the stream, whose octave has its
//! middle near a period of 2 m T_s. Noise that a loop shapes falls faster than the 1/m of
//! independent symbols, until the charge itself moves.

use serde::Serialize;

/// Differences that a power is the mean of, at least.
const LEAST_DIFFERENCES: usize = 8;

/// One octave.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StreamOctave {
    /// 2 m T_s, s.
    pub period_s: f64,
    /// Of symbols of ±1; white noise of independent symbols has 1/m.
    pub power: f64,
}

/// All octaves for which a stream is long enough, the fastest first.
pub fn octaves(symbols: &[f64], symbol_time_s: f64) -> Vec<StreamOctave> {
    let mut all = Vec::new();
    let mut length = 1;
    while symbols.len() / length > LEAST_DIFFERENCES {
        let means: Vec<f64> =
            symbols.chunks_exact(length).map(|chunk| chunk.iter().sum::<f64>() / length as f64).collect();
        let squares: f64 = means.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
        let power = 0.5 * squares / (means.len() - 1) as f64;
        all.push(StreamOctave { period_s: 2.0 * length as f64 * symbol_time_s, power });
        length *= 2;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_alternating_stream_is_all_in_the_first_octave_and_a_slow_one_in_its_own() {
        let alternating: Vec<f64> = (0..1024).map(|n| if n % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let found = octaves(&alternating, 0.5);
        assert_eq!((found[0].period_s, found[0].power), (1.0, 2.0));
        assert!(found[1..].iter().all(|octave| octave.power == 0.0));
        let slow: Vec<f64> = (0..1024).map(|n| if n / 16 % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let most = octaves(&slow, 1.0).into_iter().max_by(|a, b| a.power.total_cmp(&b.power)).unwrap();
        assert_eq!((most.period_s, most.power), (32.0, 2.0));
    }
}
