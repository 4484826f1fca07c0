//! A thermal network: lumped heat capacities joined by conductances, integrated in time.
//!
//! ```text
//! C_i dT_i/dt = P_i + Σ_j g_ij (T_j − T_i) + Σ_b g_b (T_b − T_i) − Σ_r c_r (T_i⁴ − T_r⁴)
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | C_i, T_i | heat capacity and temperature of node i | J/K, K |
//! | P_i | heat put into node i, held during a step | W |
//! | g_ij, g_b | conductance to another node, to a body of fixed temperature T_b | W/K |
//! | c_r = ε σ A | radiation to surroundings at T_r | W/K⁴ |
//!
//! Integrated by the classical Runge–Kutta method of order four in substeps that follow the
//! stiffest rate of the network. What a link takes from one node it gives to the other in the same
//! expression, and the heat that leaves is summed with the weights of the method itself, so energy
//! is kept to rounding whatever the substep.
//!
//! A capacity may depend on the node's temperature, C = C_0 (1 + s T) with T in °C; then energy is
//! kept to the order of the method. Limits: constant conductances and fixed temperatures within a
//! step; nodes without gradient inside.

use std::ops::RangeInclusive;

use anemometry::gas::ZERO_CELSIUS_K;
use nalgebra::{DMatrix, DVector};

/// Temperatures in which a capacity that depends on them is bounded, K.
const CAPACITY_RANGE_K: RangeInclusive<f64> = 100.0..=700.0;

/// Largest product of substep and stiffest rate: the method then misses some 0.5⁵/120 = 3e-4 of
/// what the fastest transient moves in a substep, and much less of all slower ones.
const LARGEST_RATE_STEP: f64 = 0.5;

#[derive(Clone, Copy, Debug)]
struct ThermalLink {
    a: usize,
    b: usize,
    conductance_w_k: f64,
}

/// A link to a body of fixed temperature.
#[derive(Clone, Copy, Debug)]
pub struct Boundary {
    node: usize,
    pub conductance_w_k: f64,
    pub temperature_k: f64,
    /// Heat that has left by it since the network was made, J.
    heat_j: f64,
}

#[derive(Clone, Copy, Debug)]
struct Radiator {
    node: usize,
    coefficient_w_k4: f64,
    surroundings_k4: f64,
    /// Heat that has left by it since the network was made, J.
    heat_j: f64,
}

/// All ways that heat can take.
#[derive(Clone, Debug, Default)]
struct Paths {
    links: Vec<ThermalLink>,
    boundaries: Vec<Boundary>,
    radiators: Vec<Radiator>,
}

impl Paths {
    /// Adds to `heat_w` what flows into every node at `temperature_k`, and counts what leaves the
    /// network as flowing for so long.
    #[inline(always)]
    fn flow(&mut self, temperature_k: &[f64], heat_w: &mut [f64], counted_s: f64) {
        for link in &self.links {
            let flow = link.conductance_w_k * (temperature_k[link.a] - temperature_k[link.b]);
            heat_w[link.a] -= flow;
            heat_w[link.b] += flow;
        }
        for boundary in &mut self.boundaries {
            let flow = boundary.conductance_w_k * (temperature_k[boundary.node] - boundary.temperature_k);
            heat_w[boundary.node] -= flow;
            boundary.heat_j += counted_s * flow;
        }
        for radiator in &mut self.radiators {
            let squared = temperature_k[radiator.node] * temperature_k[radiator.node];
            let flow = radiator.coefficient_w_k4 * (squared * squared - radiator.surroundings_k4);
            heat_w[radiator.node] -= flow;
            radiator.heat_j += counted_s * flow;
        }
    }
}

/// Handle of a link to a fixed temperature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoundaryId(usize);

/// Handle of a radiating surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RadiatorId(usize);

#[derive(Clone, Debug, Default)]
pub struct ThermalNetwork {
    temperature_k: Vec<f64>,
    capacity_j_k: Vec<f64>,
    inverse_capacity_k_j: Vec<f64>,
    /// Nodes whose capacity depends on their temperature, and its slope in 1/K.
    capacity_slopes: Vec<(usize, f64)>,
    paths: Paths,
    // Work space of a step, kept so that a step allocates nothing.
    stage_k: Vec<f64>,
    heat_w: Vec<f64>,
    change_k: Vec<f64>,
}

impl ThermalNetwork {
    /// Adds a node and returns its number.
    pub fn add_node(&mut self, capacity_j_k: f64, temperature_k: f64) -> usize {
        assert!(capacity_j_k > 0.0, "a node needs a heat capacity");
        self.capacity_j_k.push(capacity_j_k);
        self.inverse_capacity_k_j.push(1.0 / capacity_j_k);
        for vector in [&mut self.temperature_k, &mut self.stage_k] {
            vector.push(temperature_k);
        }
        self.heat_w.push(0.0);
        self.change_k.push(0.0);
        self.temperature_k.len() - 1
    }

    /// Lets the last node's capacity, so far that of 0 °C, depend on its temperature.
    pub fn slope_last_capacity(&mut self, slope_per_k: f64) {
        if slope_per_k != 0.0 && !self.is_empty() {
            self.capacity_slopes.push((self.len() - 1, slope_per_k));
        }
    }

    /// Joins two nodes, and returns the number of the link.
    pub fn link(&mut self, a: usize, b: usize, conductance_w_k: f64) -> usize {
        assert!(a != b && a.max(b) < self.len(), "a link joins two nodes");
        assert!(conductance_w_k > 0.0, "a link conducts");
        self.paths.links.push(ThermalLink { a, b, conductance_w_k });
        self.paths.links.len() - 1
    }

    /// A link has another conductance from now on.
    pub fn set_link(&mut self, link: usize, conductance_w_k: f64) {
        self.paths.links[link].conductance_w_k = conductance_w_k;
    }

    /// The link between two nodes, and its conductance, W/K.
    pub fn link_between(&self, a: usize, b: usize) -> Option<(usize, f64)> {
        let joins = |link: &ThermalLink| [link.a, link.b] == [a, b] || [link.b, link.a] == [a, b];
        let found = self.paths.links.iter().position(joins)?;
        Some((found, self.paths.links[found].conductance_w_k))
    }

    fn is_empty(&self) -> bool {
        self.temperature_k.is_empty()
    }

    /// Joins a node to a body of fixed temperature.
    pub fn link_to_fixed(&mut self, node: usize, conductance_w_k: f64, temperature_k: f64) -> BoundaryId {
        assert!(node < self.len(), "a boundary needs a node");
        self.paths.boundaries.push(Boundary { node, conductance_w_k, temperature_k, heat_j: 0.0 });
        BoundaryId(self.paths.boundaries.len() - 1)
    }

    /// Lets a node radiate to surroundings of fixed temperature; the coefficient is ε σ A.
    pub fn radiate(&mut self, node: usize, coefficient_w_k4: f64, surroundings_k: f64) -> RadiatorId {
        assert!(node < self.len(), "a radiator needs a node");
        let surroundings_k4 = surroundings_k.powi(4);
        self.paths.radiators.push(Radiator { node, coefficient_w_k4, surroundings_k4, heat_j: 0.0 });
        RadiatorId(self.paths.radiators.len() - 1)
    }

    /// A surface has another coefficient ε σ A and other surroundings from now on.
    pub fn set_radiator(&mut self, radiator: RadiatorId, coefficient_w_k4: f64, surroundings_k: f64) {
        let of = &mut self.paths.radiators[radiator.0];
        (of.coefficient_w_k4, of.surroundings_k4) = (coefficient_w_k4, surroundings_k.powi(4));
    }

    /// A boundary, whose conductance and temperature may change.
    pub fn boundary_mut(&mut self, boundary: BoundaryId) -> &mut Boundary {
        &mut self.paths.boundaries[boundary.0]
    }

    pub fn len(&self) -> usize {
        self.temperature_k.len()
    }

    pub fn temperature_k(&self, node: usize) -> f64 {
        self.temperature_k[node]
    }

    pub fn capacity_j_k(&self, node: usize) -> f64 {
        self.capacity_j_k[node]
    }

    /// Heat in a node, J, up to a constant: C T, or the integral of C.
    pub fn heat_j(&self, node: usize) -> f64 {
        let (capacity_j_k, temperature_k) = (self.capacity_j_k[node], self.temperature_k[node]);
        let slope = self.capacity_slopes.iter().find(|(sloping, _)| *sloping == node);
        let rise = slope.map_or(0.0, |(_, slope)| 0.5 * slope * (temperature_k - ZERO_CELSIUS_K).powi(2));
        capacity_j_k * (temperature_k + rise)
    }

    /// Heat in all nodes, J, up to a constant.
    #[cfg(test)]
    pub fn stored_heat_j(&self) -> f64 {
        (0..self.len()).map(|node| self.heat_j(node)).sum()
    }

    /// Heat that has left through a boundary since the network was made, J.
    pub fn boundary_heat_j(&self, boundary: BoundaryId) -> f64 {
        self.paths.boundaries[boundary.0].heat_j
    }

    /// Heat that has left by radiation since the network was made, J.
    pub fn radiator_heat_j(&self, radiator: RadiatorId) -> f64 {
        self.paths.radiators[radiator.0].heat_j
    }

    /// An upper bound of the network's fastest rate, 1/s: Gershgorin's circles of C^−½ G C^−½,
    /// which has the rates as eigenvalues. A small capacity on a large one is bounded closely;
    /// circles of C⁻¹ G would give twice its rate.
    pub fn stiffest_rate_per_s(&self) -> f64 {
        let mut inverse_k_j: Vec<f64> = self.capacity_j_k.iter().map(|capacity_j_k| 1.0 / capacity_j_k).collect();
        for &(node, slope_per_k) in &self.capacity_slopes {
            let ends = [*CAPACITY_RANGE_K.start(), *CAPACITY_RANGE_K.end()];
            let least = ends.map(|end_k| factor(slope_per_k, end_k)).into_iter().fold(f64::MAX, f64::min);
            inverse_k_j[node] /= least;
        }
        let mut circle: Vec<f64> = self.total_conductance_w_k().iter().zip(&inverse_k_j).map(|(g, c)| g * c).collect();
        for link in &self.paths.links {
            let (a, b) = (link.a, link.b);
            let coupling = link.conductance_w_k * (inverse_k_j[a] * inverse_k_j[b]).sqrt();
            circle[a] += coupling;
            circle[b] += coupling;
        }
        circle.into_iter().fold(0.0, f64::max)
    }

    /// Number of equal substeps in which `interval_s` can be integrated if no rate exceeds
    /// `stiffest_rate_per_s`.
    pub fn substeps(interval_s: f64, stiffest_rate_per_s: f64) -> usize {
        (interval_s * stiffest_rate_per_s / LARGEST_RATE_STEP).ceil().max(1.0) as usize
    }

    fn total_conductance_w_k(&self) -> Vec<f64> {
        let mut total = vec![0.0; self.len()];
        for link in &self.paths.links {
            total[link.a] += link.conductance_w_k;
            total[link.b] += link.conductance_w_k;
        }
        for boundary in &self.paths.boundaries {
            total[boundary.node] += boundary.conductance_w_k;
        }
        for radiator in &self.paths.radiators {
            total[radiator.node] += 4.0 * radiator.coefficient_w_k4 * self.temperature_k[radiator.node].powi(3);
        }
        total
    }

    /// One Runge–Kutta step of `step_s` with the powers held. `power_w` has one entry a node.
    pub fn step(&mut self, step_s: f64, power_w: &[f64]) {
        // Weight of each stage in the mean slope, and how far from the start the *next* stage is
        // taken.
        const STAGES: [(f64, f64); 4] = [(1.0 / 6.0, 0.5), (1.0 / 3.0, 0.5), (1.0 / 3.0, 1.0), (1.0 / 6.0, 0.0)];
        let n = self.temperature_k.len();
        assert_eq!(power_w.len(), n, "one power a node");
        self.stage_k.copy_from_slice(&self.temperature_k);
        self.change_k.fill(0.0);
        for (weight, ahead) in STAGES {
            self.heat_w.copy_from_slice(power_w);
            let weighted_s = weight * step_s;
            self.paths.flow(&self.stage_k, &mut self.heat_w, weighted_s);
            for &(node, slope_per_k) in &self.capacity_slopes {
                self.inverse_capacity_k_j[node] =
                    1.0 / (self.capacity_j_k[node] * factor(slope_per_k, self.stage_k[node]));
            }
            let ahead_s = ahead * step_s;
            let (change, stage) = (&mut self.change_k[..n], &mut self.stage_k[..n]);
            let (start, inverse) = (&self.temperature_k[..n], &self.inverse_capacity_k_j[..n]);
            for i in 0..n {
                let slope = self.heat_w[i] * inverse[i];
                change[i] += weighted_s * slope;
                stage[i] = start[i] + ahead_s * slope;
            }
        }
        for (temperature, change) in self.temperature_k.iter_mut().zip(&self.change_k) {
            *temperature += change;
        }
    }

    /// Sets all temperatures to the steady state under `power_w`.
    #[cfg(test)]
    pub fn settle(&mut self, power_w: &[f64]) {
        self.hold(power_w, &[]);
    }

    /// Sets all temperatures to the steady state under `power_w`, with some nodes held at
    /// temperatures, K, by Newton's method (one step would do without radiation); returns the heat
    /// that each of these needs, W.
    pub fn hold(&mut self, power_w: &[f64], held_k: &[(usize, f64)]) -> Vec<f64> {
        held_k.iter().for_each(|&(node, temperature_k)| self.temperature_k[node] = temperature_k);
        for _ in 0..20 {
            let mut residual_w = self.net_heat_w(power_w);
            let mut matrix = self.jacobian_w_k();
            for &(node, _) in held_k {
                matrix.row_mut(node).fill(0.0);
                (matrix[(node, node)], residual_w[node]) = (1.0, 0.0);
            }
            let correction = matrix.lu().solve(&DVector::from(residual_w));
            let correction = correction.unwrap_or_else(|| DVector::from_element(self.len(), f64::NAN));
            for (temperature, correction) in self.temperature_k.iter_mut().zip(&correction) {
                *temperature += correction;
            }
            if correction.iter().all(|c| c.abs() < 1e-10) {
                break;
            }
        }
        let net_w = self.net_heat_w(power_w);
        held_k.iter().map(|&(node, _)| power_w[node] - net_w[node]).collect()
    }

    /// Heat that flows into every node at the present temperatures, W.
    fn net_heat_w(&mut self, power_w: &[f64]) -> Vec<f64> {
        let mut net_w = power_w.to_vec();
        self.paths.flow(&self.temperature_k, &mut net_w, 0.0);
        net_w
    }

    /// Time constants of all nodes together at the present conductances and temperatures, s, from
    /// the slowest: eigenvalues of C^−½ G C^−½.
    pub fn time_constants_s(&self) -> Vec<f64> {
        let mut matrix = self.jacobian_w_k();
        let root: Vec<f64> = self.capacity_j_k.iter().map(|capacity_j_k| capacity_j_k.sqrt()).collect();
        let pairs = (0..self.len()).flat_map(|i| (0..self.len()).map(move |j| (i, j)));
        pairs.for_each(|(i, j)| matrix[(i, j)] /= root[i] * root[j]);
        let rates = matrix.symmetric_eigenvalues();
        let mut time_constants_s: Vec<f64> = rates.iter().map(|rate| 1.0 / rate).collect();
        time_constants_s.sort_by(|a, b| b.total_cmp(a));
        time_constants_s
    }

    /// Conductance matrix at the present temperatures, −∂(net heat)/∂T.
    fn jacobian_w_k(&self) -> DMatrix<f64> {
        let mut matrix = DMatrix::from_diagonal(&DVector::from(self.total_conductance_w_k()));
        for link in &self.paths.links {
            matrix[(link.a, link.b)] -= link.conductance_w_k;
            matrix[(link.b, link.a)] -= link.conductance_w_k;
        }
        matrix
    }
}

/// Capacity at a temperature over that at 0 °C.
fn factor(slope_per_k: f64, temperature_k: f64) -> f64 {
    let bounded_k = temperature_k.clamp(*CAPACITY_RANGE_K.start(), *CAPACITY_RANGE_K.end());
    1.0 + slope_per_k * (bounded_k - ZERO_CELSIUS_K)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    /// Two bodies, one on a cold wall, one in a gas: every kind of path but radiation.
    fn linear_network() -> ThermalNetwork {
        let mut network = ThermalNetwork::default();
        let chip = network.add_node(3e-3, 260.0);
        let body = network.add_node(0.118, 250.0);
        let core = network.add_node(0.075, 240.0);
        network.link(chip, body, 0.5);
        network.link(body, core, 6e-4);
        network.link_to_fixed(body, 5e-4, 220.0);
        network.link_to_fixed(core, 1.2e-3, 230.0);
        network
    }

    fn with_radiation() -> ThermalNetwork {
        let mut network = linear_network();
        network.radiate(1, 0.03 * 5.670374419e-8 * 8e-5, 220.0);
        network
    }

    #[test]
    fn agrees_with_the_matrix_exponential_of_the_linear_part() {
        let mut network = linear_network();
        let n = network.len();
        let power = [0.042, 0.0, 0.01];
        // dT/dt = A T + b as one homogeneous system of order n + 1.
        let conductance = network.jacobian_w_k();
        let mut system = DMatrix::<f64>::zeros(n + 1, n + 1);
        for i in 0..n {
            for j in 0..n {
                system[(i, j)] = -conductance[(i, j)] / network.capacity_j_k(i);
            }
        }
        let fixed = [0.0, 5e-4 * 220.0, 1.2e-3 * 230.0];
        for i in 0..n {
            system[(i, n)] = (power[i] + fixed[i]) / network.capacity_j_k(i);
        }
        let duration_s = 0.01;
        let exact = diffusive::predict::exponential::exponential(&(system * duration_s))
            * DVector::from_iterator(n + 1, (0..n).map(|i| network.temperature_k(i)).chain([1.0]));
        let substeps = ThermalNetwork::substeps(duration_s, network.stiffest_rate_per_s());
        for _ in 0..substeps {
            network.step(duration_s / substeps as f64, &power);
        }
        // The chip starts 10 K from its equilibrium; the first substep misses 3e-4 of the 4 K that
        // it moves, and forgets half of it.
        for i in 0..n {
            assert!((network.temperature_k(i) - exact[i]).abs() < 1.2e-3, "node {i}");
        }
        assert!((network.temperature_k(2) - exact[2]).abs() < 1e-6, "slow node");
    }

    #[test]
    fn is_of_fourth_order() {
        let run = |substeps: usize| {
            let mut network = with_radiation();
            for _ in 0..substeps {
                network.step(0.02 / substeps as f64, &[0.042, 0.0, 0.01]);
            }
            network.temperature_k(0)
        };
        let reference = run(4096);
        let ratio = (run(16) - reference) / (run(32) - reference);
        // Halving the step divides the error by 2⁴, the next order adds a few percent.
        assert!((ratio - 16.0).abs() < 3.0, "{ratio}");
    }

    #[test]
    fn heat_in_is_heat_out_and_heat_stored() {
        let mut network = with_radiation();
        let stored = network.stored_heat_j();
        let power = [0.042, 0.0, 0.01];
        let (step_s, steps) = (2e-3, 500_000);
        for _ in 0..steps {
            network.step(step_s, &power);
        }
        let given = power.iter().sum::<f64>() * step_s * steps as f64;
        let Paths { boundaries, radiators, .. } = &network.paths;
        let by_boundary = boundaries.iter().map(|boundary| boundary.heat_j);
        let left: f64 = by_boundary.chain(radiators.iter().map(|radiator| radiator.heat_j)).sum();
        let balance = given - left - (network.stored_heat_j() - stored);
        // Rounding only: half a million sums of f64 on 52 J given and 50 J stored.
        assert!((balance / given).abs() < 1e-10, "{balance} J of {given} J");
    }

    #[test]
    fn time_constants_are_those_by_hand() {
        // Two nodes of 1 and 2 J/K joined by 1 W/K, the second to a wall by 1 W/K: G C⁻¹ has the
        // trace 2 and the determinant ½.
        let mut network = ThermalNetwork::default();
        network.add_node(1.0, 300.0);
        network.add_node(2.0, 300.0);
        network.link(0, 1, 1.0);
        network.link_to_fixed(1, 1.0, 300.0);
        let rates = network.time_constants_s().into_iter().map(|time_s| 1.0 / time_s);
        for (rate, expected) in rates.zip([1.0 - 0.5_f64.sqrt(), 1.0 + 0.5_f64.sqrt()]) {
            assert!((rate - expected).abs() < 1e-12, "{rate} for {expected}");
        }
    }

    #[test]
    fn a_capacity_that_grows_with_temperature_takes_the_heat_of_its_integral() {
        // 1 J/K at 0 °C and 0.4 % more a kelvin, insulated but for a link to nothing cold: 10 W for
        // 5 s from 0 °C are 50 J = T + 0.002 T², T = 45.9 K.
        let mut network = ThermalNetwork::default();
        network.add_node(1.0, ZERO_CELSIUS_K);
        network.slope_last_capacity(4e-3);
        let before = network.stored_heat_j();
        for _ in 0..500 {
            network.step(0.01, &[10.0]);
        }
        let rise = network.temperature_k(0) - ZERO_CELSIUS_K;
        assert!((rise + 0.002 * rise * rise - 50.0).abs() < 1e-6, "{rise}");
        assert!((network.stored_heat_j() - before - 50.0).abs() < 1e-6);
    }

    #[test]
    fn settles_where_time_stepping_ends() {
        let power = [0.042, 0.0, 0.01];
        let mut settled = with_radiation();
        settled.settle(&power);
        let mut stepped = settled.clone();
        for _ in 0..10_000 {
            stepped.step(2e-3, &power);
        }
        for i in 0..settled.len() {
            assert!((settled.temperature_k(i) - stepped.temperature_k(i)).abs() < 1e-9, "node {i}");
        }
        // Holding the chip where it settled needs the power that it settled under.
        let mut held = with_radiation();
        let needed_w = held.hold(&[0.0, 0.0, 0.01], &[(0, settled.temperature_k(0))]);
        assert!((needed_w[0] - 0.042).abs() < 1e-9, "{needed_w:?}");
        assert!((held.temperature_k(2) - settled.temperature_k(2)).abs() < 1e-8);
        // All heat leaves through the two boundaries and by radiation.
        let left = 5e-4 * (settled.temperature_k(1) - 220.0)
            + 1.2e-3 * (settled.temperature_k(2) - 230.0)
            + 0.03 * 5.670374419e-8 * 8e-5 * (settled.temperature_k(1).powi(4) - 220.0_f64.powi(4));
        assert!((left - 0.052).abs() < 1e-12, "{left}");
    }

    #[test]
    fn substeps_follow_the_stiffest_rate() {
        let network = linear_network();
        // The chip: 0.5 W/K on 3 mJ/K with 0.118 J/K behind it. Its true rate is 0.5 (1/3e-3 +
        // 1/0.118); the bound has to lie above, and less than a fifth.
        let rate = 0.5 * (1.0 / 3e-3 + 1.0 / 0.118);
        let bound = network.stiffest_rate_per_s();
        assert!((1.0..1.2).contains(&(bound / rate)), "{bound} for {rate}");
        assert_eq!(ThermalNetwork::substeps(0.01, bound), 4);
        assert_eq!(ThermalNetwork::substeps(1e-4, bound), 1);
    }
}
