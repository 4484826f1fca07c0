//! Heat that elements without a surface gain on ways that the identification did not have: from a
//! support at another temperature, by a stem in the wind. It is 0 where all is as it was.

use std::fmt;

use serde::Serialize;

/// Less heat than this is no drift that matters: 0.01 % of R₀ of a core of sphere B, which is 0.2 %
/// of speed.
const MATTERS_W: f64 = 1e-3;
/// Heats whose sizes are nearer to each other than this ratio are of one cause.
const ALIKE: f64 = 0.5;

/// Statistics of one element's.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UnknownHeat {
    /// Name of the element.
    pub element: String,
    /// Mean, W.
    pub mean_w: f64,
    /// Least and greatest, W.
    pub range_w: [f64; 2],
    /// Place of the element in the head.
    #[serde(skip)]
    pub place: usize,
    #[serde(skip)]
    count: u64,
}

impl UnknownHeat {
    /// Of an element of which nothing is known yet.
    pub fn new(element: String, place: usize) -> Self {
        Self { element, place, mean_w: 0.0, range_w: [f64::INFINITY, f64::NEG_INFINITY], count: 0 }
    }

    /// Adds the heat at an estimate.
    pub fn add(&mut self, heat_w: f64) {
        self.count += 1;
        self.mean_w += (heat_w - self.mean_w) / self.count as f64;
        self.range_w = [self.range_w[0].min(heat_w), self.range_w[1].max(heat_w)];
    }

    /// Whether anything was added.
    pub fn is_known(&self) -> bool {
        self.count > 0
    }
}

/// Two elements whose heats no support explains, in words: it gives both the same sign.
pub fn contradiction(heats: &[UnknownHeat]) -> Option<String> {
    let least = heats.iter().min_by(|a, b| a.mean_w.total_cmp(&b.mean_w))?;
    let most = heats.iter().max_by(|a, b| a.mean_w.total_cmp(&b.mean_w))?;
    let (gained_w, lost_w) = (most.mean_w, -least.mean_w);
    (gained_w.min(lost_w) > MATTERS_W.max(ALIKE * gained_w.max(lost_w))).then(|| {
        format!(
            "heat of {most} and {least} has opposite signs, which no support gives: the resistor of one has drifted, and the wind is wrong by it"
        )
    })
}

impl fmt::Display for UnknownHeat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [least, most] = self.range_w.map(|of| 1e3 * of);
        write!(f, "`{}` {:.2} mW ({least:.2} to {most:.2})", self.element, 1e3 * self.mean_w)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_range_are_of_what_was_added() {
        let mut heat = UnknownHeat::new("core1".to_owned(), 4);
        assert!(!heat.is_known());
        [1e-3, -2e-3, 4e-3].into_iter().for_each(|of| heat.add(of));
        assert_eq!(heat.to_string(), "`core1` 1.00 mW (-2.00 to 4.00)");
        assert!(heat.is_known());
    }

    #[test]
    fn a_core_that_gains_what_the_other_loses_has_drifted() {
        let heats = |means_w: [f64; 2]| {
            let mut heats = vec![UnknownHeat::new("core1".to_owned(), 4), UnknownHeat::new("core2".to_owned(), 5)];
            heats.iter_mut().zip(means_w).for_each(|(heat, mean_w)| heat.add(mean_w));
            heats
        };
        let said = contradiction(&heats([-7.35e-3, 7.92e-3])).unwrap();
        assert!(said.starts_with("heat of `core2` 7.92 mW (7.92 to 7.92) and `core1` -7.35 mW"), "{said}");
        // A support, next to nothing, and a core in the wind beside one that is not.
        for other in [[12e-3, 12e-3], [-12e-3, -12e-3], [0.5e-3, -0.5e-3], [-3.8e-3, 1.1e-3], [0.0, 0.0]] {
            assert_eq!(contradiction(&heats(other)), None, "{other:?}");
        }
        assert_eq!(contradiction(&[]), None);
    }
}
