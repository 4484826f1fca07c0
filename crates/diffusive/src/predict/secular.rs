//! Roots of the secular equation c + Σ η_k/(ξ_k − μ) = 0 for η_k > 0, each to the last digits of
//! its distance from every ξ_k.
//!
//! Between two neighbouring ξ_k the sum rises from −∞ to +∞, so that it has one root there; c > 0
//! adds one above the last, c < 0 one below the first. With c = 0 they are the transmission zeros
//! −μ of H(s) = Σ η_k/(s + ξ_k); with c = 1/ΔG the poles of H/(1 + ΔG·H).
//!
//! A root is kept as its distance from the nearer of its two neighbours and found by halving that
//! distance's bit pattern: 64 steps whatever the numbers are, and neither μ nor ξ_k − μ ever loses
//! digits to cancellation. Costs 64 K divisions a root.

/// A root μ = ξ_anchor + offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Root {
    anchor: usize,
    offset: f64,
}

impl Root {
    /// μ.
    pub fn value(self, rates: &[f64]) -> f64 {
        rates[self.anchor] + self.offset
    }

    /// ξ_k − μ, never 0.
    pub fn gap(self, rates: &[f64], k: usize) -> f64 {
        (rates[k] - rates[self.anchor]) - self.offset
    }
}

/// All roots, ascending. `rates` ascend strictly, `eta` are greater than zero, all are finite.
pub fn roots(rates: &[f64], eta: &[f64], constant: f64) -> Vec<Root> {
    let sum = |root: Root| constant + eta.iter().enumerate().map(|(k, eta)| eta / root.gap(rates, k)).sum::<f64>();
    let gamma: f64 = eta.iter().sum();
    // |c| = Σ η/|ξ − μ| ≤ Γ/(distance from the end)
    let beyond = gamma / constant.abs();
    let last = rates.len() - 1;
    let mut found = Vec::with_capacity(rates.len());
    if constant < 0.0 {
        found.push(halve(0, -1.0, beyond, &sum));
    }
    for k in 0..last {
        let half = 0.5 * (rates[k + 1] - rates[k]);
        let middle = Root { anchor: k, offset: half };
        found.push(if sum(middle) >= 0.0 { halve(k, 1.0, half, &sum) } else { halve(k + 1, -1.0, half, &sum) });
    }
    if constant > 0.0 {
        found.push(halve(last, 1.0, beyond, &sum));
    }
    found
}

/// The root on one side of a rate, at most `reach` away. The sum rises with μ.
fn halve(anchor: usize, side: f64, reach: f64, sum: &impl Fn(Root) -> f64) -> Root {
    // Bit patterns of positive numbers are in the order of the numbers.
    let (mut near, mut far) = (f64::MIN_POSITIVE.to_bits(), reach.max(f64::MIN_POSITIVE).to_bits());
    while far - near > 1 {
        let middle = near + (far - near) / 2;
        let root = Root { anchor, offset: side * f64::from_bits(middle) };
        // Next to its rate the sum is −∞ above and +∞ below.
        if sum(root) * side < 0.0 { near = middle } else { far = middle }
    }
    Root { anchor, offset: side * f64::from_bits(far) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_rates_have_the_root_of_the_linear_equation() {
        // η_1/(ξ_1 − μ) + η_2/(ξ_2 − μ) = 0 at μ = (η_1 ξ_2 + η_2 ξ_1)/Γ
        for (eta, exact) in [([3.0, 1.0], 7.75), ([1e-12, 1.0], 1.0 + 9e-12)] {
            let root = roots(&[1.0, 10.0], &eta, 0.0)[0];
            assert!((root.value(&[1.0, 10.0]) / exact - 1.0).abs() < 1e-14, "{root:?}");
            // The distance from the near rate has all its digits too: μ − ξ_1 = η_1 (ξ_2 − ξ_1)/Γ.
            let distance = eta[0] * 9.0 / (eta[0] + eta[1]);
            assert!((-root.gap(&[1.0, 10.0], 0) / distance - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn one_rate_with_a_constant_is_moved_by_the_constant() {
        // c + η/(ξ − μ) = 0 at μ = ξ + η/c
        assert!((roots(&[2.0], &[3.0], 4.0)[0].value(&[2.0]) - 2.75).abs() < 1e-15);
        assert!((roots(&[2.0], &[3.0], -4.0)[0].value(&[2.0]) - 1.25).abs() < 1e-15);
        assert!(roots(&[2.0], &[3.0], 0.0).is_empty());
    }
}
