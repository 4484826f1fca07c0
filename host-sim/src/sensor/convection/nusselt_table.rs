//! Convection by a table that somebody measured or computed: Nu by Reynolds number and angle.
//!
//! The angle is that between the surface's normal and the direction the wind comes from. Between
//! the rows the table is straight in ln Re, between the columns in the angle; below the first row
//! Nu goes as √Re from its value at rest, above the last as the power of the last two rows, which
//! is `extrapolated`. Limits: one gas (no Prandtl number); a continuum around the length.

use super::flow::continuum;
use crate::sensor::error::SensorError;
use anemometry::gas::IdealGas;
use anemometry::head::body::NusseltGrid;
use anemometry::vector::{dot, length};

/// Convection by a table in one gas.
#[derive(Clone, Debug)]
pub struct TableConvection {
    grid: NusseltGrid,
    normals: Vec<Option<[f64; 3]>>,
    reynolds_per_speed: f64,
    conductance_per_nusselt_w_k: f64,
}

impl TableConvection {
    /// Refuses a gas so thin that it is no continuum around the length.
    pub fn new(gas: &IdealGas, grid: NusseltGrid, normals: Vec<Option<[f64; 3]>>) -> Result<Self, SensorError> {
        continuum(gas, grid.length_m)?;
        let mut convection = Self { grid, normals, reynolds_per_speed: 0.0, conductance_per_nusselt_w_k: 0.0 };
        convection.follow(gas);
        Ok(convection)
    }

    /// The same in another gas.
    pub fn follow(&mut self, gas: &IdealGas) {
        self.reynolds_per_speed = gas.reynolds(1.0, self.grid.length_m);
        self.conductance_per_nusselt_w_k = gas.conductivity_w_m_k / self.grid.length_m * self.grid.area_m2;
    }

    /// Area of a surface, m².
    pub fn area_m2(&self) -> f64 {
        self.grid.area_m2
    }

    /// Tells whether this wind is beyond the last row.
    pub fn extrapolated(&self, wind_m_s: [f64; 3]) -> bool {
        self.reynolds_per_speed * length(wind_m_s) > self.grid.reynolds.last().copied().unwrap_or(f64::MAX)
    }

    /// Conductance of every surface to the gas, W/K.
    pub fn conductance_w_k(&self, wind_m_s: [f64; 3], conductance_w_k: &mut [f64]) {
        let speed = length(wind_m_s);
        for (conductance, normal) in conductance_w_k.iter_mut().zip(&self.normals) {
            let cosine = normal.map_or(1.0, |normal| -dot(normal, wind_m_s) / speed.max(f64::MIN_POSITIVE));
            let angle_deg = libm::acos(cosine.clamp(-1.0, 1.0)).to_degrees();
            *conductance = self.conductance_per_nusselt_w_k * self.nusselt(self.reynolds_per_speed * speed, angle_deg);
        }
    }

    fn nusselt(&self, reynolds: f64, angle_deg: f64) -> f64 {
        let NusseltGrid { reynolds: rows, nusselt, nusselt_at_rest, .. } = &self.grid;
        let at = |row: usize| self.at_angle(&nusselt[row], angle_deg);
        if reynolds < rows[0] {
            return nusselt_at_rest + (at(0) - nusselt_at_rest) * (reynolds / rows[0]).sqrt();
        }
        let row = rows.partition_point(|&row| row <= reynolds).min(rows.len() - 1) - 1;
        let share = libm::log(reynolds / rows[row]) / libm::log(rows[row + 1] / rows[row]);
        let (low, high) = (at(row), at(row + 1));
        if share > 1.0 { low * libm::pow(high / low, share) } else { low + share * (high - low) }
    }

    fn at_angle(&self, row: &[f64], angle_deg: f64) -> f64 {
        let angles = &self.grid.angles_deg;
        let next = angles.partition_point(|&angle| angle <= angle_deg);
        if next == 0 || next == angles.len() {
            return row[next.saturating_sub(1)];
        }
        let share = (angle_deg - angles[next - 1]) / (angles[next] - angles[next - 1]);
        row[next - 1] + share * (row[next] - row[next - 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use anemometry::gas::Species;

    #[test]
    fn it_goes_through_its_points_and_between_them_as_it_says() {
        let gas = IdealGas::new(Species::Air, 101_325.0, 293.15).unwrap();
        let grid = NusseltGrid {
            length_m: 0.01,
            area_m2: 1e-4,
            reynolds: vec![100.0, 400.0, 1600.0],
            angles_deg: vec![0.0, 90.0, 180.0],
            nusselt: vec![vec![10.0, 6.0, 4.0], vec![20.0, 12.0, 8.0], vec![40.0, 24.0, 16.0]],
            nusselt_at_rest: 2.0,
        };
        let table = TableConvection::new(&gas, grid, vec![Some([1.0, 0.0, 0.0]), None]).unwrap();
        let per_speed = gas.reynolds(1.0, 0.01);
        let nusselt = |reynolds: f64, degrees: f64| {
            let speed = reynolds / per_speed;
            let (sin, cos) = libm::sincos(degrees.to_radians());
            let mut all = [0.0; 2];
            table.conductance_w_k([-speed * cos, speed * sin, 0.0], &mut all);
            all.map(|g| g / (gas.conductivity_w_m_k / 0.01 * 1e-4))
        };
        for (reynolds, degrees, expected) in [
            (100.0, 0.0, 10.0),
            (400.0, 90.0, 12.0),
            (200.0, 0.0, 15.0),
            (400.0, 45.0, 16.0),
            (25.0, 0.0, 6.0),
            (0.0, 0.0, 2.0),
            // Above: as the square root, as the last rows do.
            (6400.0, 180.0, 32.0),
        ] {
            let [found, whole] = nusselt(reynolds, degrees);
            assert!((found / expected - 1.0).abs() < 1e-6, "Re {reynolds} at {degrees}°: {found} for {expected}");
            if degrees == 0.0 {
                assert!((whole / expected - 1.0).abs() < 1e-6);
            }
        }
        assert!(table.extrapolated([1.01 * 1600.0 / per_speed, 0.0, 0.0]));
        assert!(!table.extrapolated([0.99 * 1600.0 / per_speed, 0.0, 0.0]));
    }
}
