//! Noise spectrum of a channel by Welch's method: the mean periodogram of half-overlapping segments
//! under a Hann window.
//!
//! ```text
//! S(f) = 2 |X(f)|² / (f_s Σ w²)      one-sided power density, unit²/Hz;  shown: √S, unit/√Hz
//! ```
//!
//! Source: P. D. Welch, IEEE Trans. Audio Electroacoust. AU-15, 70 (1967). Each segment loses its
//! mean. Neighbouring frequencies are averaged to at most 40 a decade.

use realfft::RealFftPlanner;

/// Longest and shortest segment.
const SEGMENT: [usize; 2] = [4096, 64];
/// Points of the result a decade of frequency, at most.
const PER_DECADE: f64 = 40.0;

/// Amplitude density over frequency.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct NoiseSpectrum {
    /// Hz, increasing.
    pub frequency_hz: Vec<f64>,
    /// Unit of the channel over √Hz.
    pub density: Vec<f64>,
}

/// The spectrum of evenly spaced samples at this rate; `None` while they are too few. Segments with
/// a sample that is no number are left out.
pub fn welch(samples: &[f32], rate_hz: f64) -> Option<NoiseSpectrum> {
    let [longest, shortest] = SEGMENT;
    let length = (samples.len() / 2 + 1).next_power_of_two() / 2;
    let length = length.min(longest);
    if length < shortest || rate_hz.is_nan() || rate_hz <= 0.0 {
        return None;
    }
    let hann: Vec<f64> =
        (0..length).map(|n| libm::sin(std::f64::consts::PI * n as f64 / length as f64).powi(2)).collect();
    let weight: f64 = hann.iter().map(|w| w * w).sum();
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(length);
    let (mut input, mut output) = (transform.make_input_vec(), transform.make_output_vec());
    let mut power = vec![0.0; output.len()];
    let mut segments = 0.0;
    for segment in samples.windows(length).step_by(length / 2) {
        let mean = segment.iter().copied().map(f64::from).sum::<f64>() / length as f64;
        if !mean.is_finite() {
            continue;
        }
        for ((place, &sample), w) in input.iter_mut().zip(segment).zip(&hann) {
            *place = (f64::from(sample) - mean) * w;
        }
        // Lengths are those of the plan.
        transform.process(&mut input, &mut output).ok()?;
        power.iter_mut().zip(&output).for_each(|(sum, bin)| *sum += bin.norm_sqr());
        segments += 1.0;
    }
    if segments == 0.0 {
        return None;
    }
    let scale = 2.0 / (rate_hz * weight * segments);
    Some(averaged(power.iter().map(|sum| sum * scale).enumerate().skip(1), rate_hz / length as f64))
}

/// Means of power over equal steps of the logarithm of frequency, as amplitudes.
fn averaged(bins: impl Iterator<Item = (usize, f64)>, step_hz: f64) -> NoiseSpectrum {
    let mut spectrum = NoiseSpectrum { frequency_hz: Vec::new(), density: Vec::new() };
    let mut group: Vec<(f64, f64)> = Vec::new();
    let place = |bin: f64| (libm::log10(bin) * PER_DECADE).floor();
    let close = |group: &mut Vec<(f64, f64)>, spectrum: &mut NoiseSpectrum| {
        let count = group.len() as f64;
        if count > 0.0 {
            spectrum.frequency_hz.push(group.iter().map(|(bin, _)| bin).sum::<f64>() / count * step_hz);
            spectrum.density.push((group.iter().map(|(_, power)| power).sum::<f64>() / count).sqrt());
        }
        group.clear();
    };
    for (bin, power) in bins {
        let bin = bin as f64;
        if group.last().is_some_and(|&(before, _)| place(before) != place(bin)) {
            close(&mut group, &mut spectrum);
        }
        group.push((bin, power));
    }
    close(&mut group, &mut spectrum);
    spectrum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_noise_has_its_density_at_all_frequencies() {
        // A sequence of ±1 by a 16-bit maximal-length shift register is white: σ² = 1, so the
        // one-sided density is √(2/f_s).
        let mut register = 0xace1_u16;
        let noise: Vec<f32> = (0..65_535)
            .map(|_| {
                let bit = (register ^ (register >> 2) ^ (register >> 3) ^ (register >> 5)) & 1;
                register = (register >> 1) | (bit << 15);
                if bit == 1 { 1.0 } else { -1.0 }
            })
            .collect();
        let spectrum = welch(&noise, 1000.0).unwrap();
        let expected = (2.0 / 1000.0_f64).sqrt();
        // 31 half-overlapping segments and at least 12 bins a point: 3 % of standard error, and
        // 15 % is five of them.
        let upper = spectrum.frequency_hz.iter().zip(&spectrum.density).filter(|(f, _)| **f > 50.0 && **f < 490.0);
        for (frequency_hz, density) in upper {
            assert!((density / expected - 1.0).abs() < 0.15, "{frequency_hz} Hz: {density} of {expected}");
        }
    }

    #[test]
    fn a_sine_stands_at_its_frequency_with_its_power() {
        // 12.5 Hz is a bin of 4096 samples at 100 Hz: 512; A²/2 is spread over three bins by Hann.
        let sine: Vec<f32> =
            (0..16_384).map(|n| libm::sin(std::f64::consts::TAU * 0.125 * f64::from(n)) as f32).collect();
        let spectrum = welch(&sine, 100.0).unwrap();
        let (at, _) = spectrum.density.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).unwrap();
        assert!((spectrum.frequency_hz[at] - 12.5).abs() < 0.4, "{}", spectrum.frequency_hz[at]);
    }

    #[test]
    fn too_few_samples_have_no_spectrum_and_a_missing_one_costs_its_segments_only() {
        assert_eq!(welch(&[1.0; 100], 10.0), None);
        assert_eq!(welch(&[f32::NAN; 1000], 10.0), None);
        let mut samples: Vec<f32> = (0..16_384).map(|n| (n % 7) as f32).collect();
        samples[3] = f32::NAN;
        assert!(welch(&samples, 10.0).unwrap().density.iter().all(|density| density.is_finite()));
    }
}
