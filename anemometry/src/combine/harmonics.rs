//! Real spherical harmonics, orthonormal in the mean over the sphere.
//!
//! ```text
//! Y_l0 = p_l0,  Y_lm = √2 p_lm cos mφ,  Y_l−m = √2 p_lm sin mφ
//! p_mm = p_m−1,m−1 sin θ √((2m+1)/2m),  p_lm = √((4l²−1)/(l²−m²)) (cos θ p_l−1,m − √(((l−1)²−m²)/(4(l−1)²−1)) p_l−2,m)
//! ```

/// How many there are up to a degree.
pub const fn count(degree: usize) -> usize {
    (degree + 1) * (degree + 1)
}

/// All harmonics up to a degree in a direction, a unit vector.
pub fn harmonics([x, y, z]: [f64; 3], degree: usize) -> Vec<f64> {
    let mut values = vec![0.0; count(degree)];
    // (sin θ)^m (cos mφ, sin mφ) without its angle.
    let (mut cosine, mut sine) = (1.0, 0.0);
    let mut diagonal = 1.0;
    for m in 0..=degree {
        if m > 0 {
            (cosine, sine) = (x * cosine - y * sine, x * sine + y * cosine);
            let m = m as f64;
            diagonal *= ((2.0 * m + 1.0) / (2.0 * m)).sqrt();
        }
        let (mut before, mut here) = (0.0, diagonal);
        for l in m..=degree {
            if l > m {
                let (l, m) = (l as f64, m as f64);
                let scale = ((4.0 * l * l - 1.0) / (l * l - m * m)).sqrt();
                let back = (((l - 1.0).powi(2) - m * m) / (4.0 * (l - 1.0).powi(2) - 1.0)).max(0.0).sqrt();
                (before, here) = (here, scale * (z * here - back * before));
            }
            let middle = l * l + l;
            if m == 0 {
                values[middle] = here;
            } else {
                values[middle + m] = std::f64::consts::SQRT_2 * here * cosine;
                values[middle - m] = std::f64::consts::SQRT_2 * here * sine;
            }
        }
    }
    values
}

/// So many directions, even over the sphere (Fibonacci's lattice).
pub fn even_directions(count: usize) -> Vec<[f64; 3]> {
    let golden = std::f64::consts::PI * (1.0 + 5_f64.sqrt());
    let direction = |n: usize| {
        let n = n as f64 + 0.5;
        let z = 1.0 - 2.0 * n / count as f64;
        let (sine, cosine) = (golden * n).sin_cos();
        let across = (1.0 - z * z).sqrt();
        [across * cosine, across * sine, z]
    };
    (0..count).map(direction).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_orthonormal_in_the_mean() {
        const DEGREE: usize = 6;
        let directions = even_directions(20_000);
        let all: Vec<Vec<f64>> = directions.iter().map(|of| harmonics(*of, DEGREE)).collect();
        for i in 0..count(DEGREE) {
            for j in 0..=i {
                let mean = all.iter().map(|of| of[i] * of[j]).sum::<f64>() / all.len() as f64;
                assert!((mean - f64::from(u8::from(i == j))).abs() < 2e-3, "{i} {j}: {mean}");
            }
        }
    }

    #[test]
    fn those_of_the_first_degree_are_the_direction() {
        let [y, z, x] = [1, 2, 3].map(|n| harmonics([0.48, 0.6, 0.64], 1)[n] / 3_f64.sqrt());
        assert!((x - 0.48).abs() < 1e-12 && (y - 0.6).abs() < 1e-12 && (z - 0.64).abs() < 1e-12);
    }
}
