//! Heat that elements without a surface gain on ways that the identification did not have: from a
//! support at another temperature, by a stem in the wind. It is 0 where all is as it was.

use std::fmt;

use serde::Serialize;

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
}
