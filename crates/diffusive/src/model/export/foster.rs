//! The Foster network: every pole is a resistor and a capacitor side by side, all of them in series
//! (theory of normalised states).
//!
//! ```text
//! η_k = ξ_k R_k,    C_k = 1/η_k,    R_k C_k = 1/ξ_k
//! ```
//!
//! R_k in K/W, η_k in K/J, C_k in J/K. A pole whose R_k is zero is a short-cut and has no cell. A
//! negative R_k, as cross-heating has it, makes a cell of two negative elements: it is no piece of
//! matter, but sums and simulates like any other.

/// One resistor and capacitor side by side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// ξ_k, rad/s.
    pub rate_rad_s: f64,
    /// R_k, K/W.
    pub resistance_k_per_w: f64,
}

impl Cell {
    /// η_k, K/J.
    pub fn symbol_k_per_j(&self) -> f64 {
        self.rate_rad_s * self.resistance_k_per_w
    }

    /// C_k, J/K.
    pub fn capacitance_j_per_k(&self) -> f64 {
        1.0 / self.symbol_k_per_j()
    }

    /// 1/ξ_k, s.
    pub fn time_constant_s(&self) -> f64 {
        1.0 / self.rate_rad_s
    }
}

/// The cells of all poles that are not zero, in the order of the mesh.
pub fn foster(mesh_rad_s: &[f64], r_k_per_w: &[f64]) -> Vec<Cell> {
    let all = mesh_rad_s.iter().zip(r_k_per_w);
    let cells = all.map(|(&rate_rad_s, &resistance_k_per_w)| Cell { rate_rad_s, resistance_k_per_w });
    cells.filter(|cell| cell.resistance_k_per_w != 0.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_stores_what_its_time_constant_says_and_zeros_have_none() {
        let cells = foster(&[0.5, 2.0, 8.0], &[10.0, 0.0, 0.25]);
        assert_eq!(cells.len(), 2);
        // τ = 2 s over 10 K/W
        assert_eq!((cells[0].time_constant_s(), cells[0].capacitance_j_per_k()), (2.0, 0.2));
        assert_eq!((cells[1].symbol_k_per_j(), cells[1].capacitance_j_per_k()), (2.0, 0.5));
    }
}
