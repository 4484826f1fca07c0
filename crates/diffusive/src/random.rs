//! Normal random numbers with the same bits on every system.
//!
//! A ziggurat of 256 layers of equal area (Marsaglia and Tsang 2000, J. Stat. Softw. 5, 8).
//! `rand_distr` has it, too, but with the platform's exponential and logarithm.

use std::sync::LazyLock;

use rand_chacha::rand_core::Rng;
use rand_distr::Distribution;

/// Where the tail begins.
const TAIL: f64 = 3.654_152_885_361_009;
/// Area of each layer.
const AREA: f64 = 0.004_928_673_233_99;

/// Widths of the layers, the widest first, and the density at each.
static LAYERS: LazyLock<[(f64, f64); 257]> = LazyLock::new(|| {
    let mut layers = [(0.0, 1.0); 257];
    layers[0] = (AREA / density(TAIL), density(AREA / density(TAIL)));
    layers[1] = (TAIL, density(TAIL));
    for i in 2..256 {
        let (x, f) = layers[i - 1];
        let x = (-2.0 * libm::log(AREA / x + f)).sqrt();
        layers[i] = (x, density(x));
    }
    layers
});

/// The density at x over that at 0.
fn density(x: f64) -> f64 {
    libm::exp(-x * x / 2.0)
}

/// The normal distribution with mean 0 and variance 1.
pub struct StandardNormal;

impl Distribution<f64> for StandardNormal {
    fn sample<R: Rng + ?Sized>(&self, random: &mut R) -> f64 {
        let layers = &*LAYERS;
        loop {
            let bits = random.next_u64();
            let (layer, u) = ((bits & 0xff) as usize, (bits >> 12) as f64 / (1_u64 << 51) as f64 - 1.0);
            let ((x, f), (next_x, next_f)) = (layers[layer], layers[layer + 1]);
            let x = u * x;
            if x.abs() < next_x {
                return x;
            }
            if layer == 0 {
                return beyond(random).copysign(u);
            }
            if next_f + (f - next_f) * ((random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64) < density(x) {
                return x;
            }
        }
    }
}

/// Draws from the tail.
fn beyond<R: Rng + ?Sized>(random: &mut R) -> f64 {
    let mut open = || ((random.next_u64() >> 12) as f64 + 0.5) / (1_u64 << 52) as f64;
    loop {
        let (x, y) = (-libm::log(open()) / TAIL, -libm::log(open()));
        if 2.0 * y >= x * x {
            return TAIL + x;
        }
    }
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng as _;
    #[expect(clippy::disallowed_types, reason = "a second opinion")]
    use rand_distr::StandardNormal as Theirs;

    use super::*;

    #[test]
    fn the_last_layer_ends_at_the_top() {
        let (x, f) = LAYERS[255];
        // The two constants have twelve digits.
        assert!((x * (1.0 - f) / AREA - 1.0).abs() < 2e-9, "{x} {f}");
        assert_eq!(LAYERS[256], (0.0, 1.0));
    }

    #[test]
    fn draws_are_those_of_another_library() {
        let (mut ours, mut theirs) = (ChaCha8Rng::seed_from_u64(4), ChaCha8Rng::seed_from_u64(4));
        for n in 0..1_000_000 {
            let ours = StandardNormal.sample(&mut ours);
            let theirs: f64 = Theirs.sample(&mut theirs);
            assert!((ours - theirs).abs() < 1e-12 * theirs.abs().max(1e-3), "draw {n}: {ours} for {theirs}");
        }
    }
}
