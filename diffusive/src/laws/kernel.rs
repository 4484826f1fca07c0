//! Step responses and their slopes by the logarithms of their shapes.
//!
//! ```text
//! exponential   S = 1 − e^(−s)     s = t/τ          ∂S/∂ln τ = −s e^(−s)
//! stretched     S = 1 − e^(−s)     s = (t/τ)^β      ∂S/∂ln τ = −β s e^(−s)
//!                                                   ∂S/∂ln β = s ln s e^(−s)
//! square root   S = √t
//! ```

/// How one term answers a unit step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StepKernel {
    Exponential,
    Stretched,
    SquareRoot,
}

/// At one time.
#[derive(Debug, Clone, Copy)]
pub struct StepAnswer {
    pub value: f64,
    /// What is left of it to go, D = S(∞) − S; −S where it has no end.
    pub left: f64,
    /// By the logarithm of each shape.
    pub slopes: [f64; 2],
}

impl StepKernel {
    /// How many shapes it has: ln τ, then ln β.
    pub fn shapes(self) -> usize {
        match self {
            Self::Exponential => 1,
            Self::Stretched => 2,
            Self::SquareRoot => 0,
        }
    }

    /// The answer a time after the step, with these shapes.
    pub fn answer(self, shapes: &[f64], time_s: f64) -> StepAnswer {
        if self == Self::SquareRoot {
            let value = time_s.sqrt();
            return StepAnswer { value, left: -value, slopes: [0.0; 2] };
        }
        let beta = shapes.get(1).map_or(1.0, |ln_beta| ln_beta.exp());
        if time_s <= 0.0 {
            return StepAnswer { value: 0.0, left: 1.0, slopes: [0.0; 2] };
        }
        let ln_s = beta * (time_s.ln() - shapes[0]);
        let s = ln_s.exp();
        let left = (-s).exp();
        // Long after, s may be infinite, and what is left of it is 0.
        let steep = if left > 0.0 { s * left } else { 0.0 };
        let by_beta = if steep > 0.0 { steep * ln_s } else { 0.0 };
        StepAnswer { value: -(-s).exp_m1(), left, slopes: [-beta * steep, by_beta] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_those_of_differences() {
        for kernel in [StepKernel::Exponential, StepKernel::Stretched] {
            for time_s in [1e-3, 0.5, 3.0, 40.0] {
                let shapes = [2_f64.ln(), 0.6_f64.ln()];
                let shapes = &shapes[..kernel.shapes()];
                for which in 0..kernel.shapes() {
                    let at = |by: f64| {
                        let mut moved = shapes.to_vec();
                        moved[which] += by;
                        kernel.answer(&moved, time_s).value
                    };
                    let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
                    // Central differences: 1e-10 of a third derivative of order 1, and 1e-16/1e-5
                    // of rounding.
                    let slope = kernel.answer(shapes, time_s).slopes[which];
                    assert!((slope - difference).abs() < 1e-9, "{kernel:?} {which} at {time_s}: {slope} {difference}");
                }
            }
        }
    }

    #[test]
    fn the_ends_of_time_have_an_answer() {
        let shapes = [0.0, 1.0_f64.ln()];
        for kernel in [StepKernel::Exponential, StepKernel::Stretched] {
            let (first, last) = (kernel.answer(&shapes, 0.0), kernel.answer(&shapes, 1e300));
            assert_eq!((first.value, first.left, first.slopes), (0.0, 1.0, [0.0; 2]));
            assert!(last.value == 1.0 && last.left == 0.0 && last.slopes.iter().all(|slope| *slope == 0.0), "{last:?}");
        }
    }
}
