//! Thermal networks: heat capacities joined by conductances, stepped exactly.
//!
//! ```text
//! C_i dT_i/dt = Σ_j G_ij (T_j − T_i) + G_i,gas (T_gas − T_i) + P_i
//! T(t + h) = Φ T(t) + Γ [P; T_gas],    [Φ Γ; 0 1] = exp([A B; 0 0] h)
//! ```
//!
//! C in J/K, G in W/K, P in W, T in °C. Exact for powers and a gas temperature that are held over
//! the step h (Van Loan 1978).

use nalgebra::{DMatrix, DVector};

/// A network of nodes, some of which are heated, and one gas around them.
#[derive(Debug, Clone)]
pub struct Network {
    capacity_j_per_k: DVector<f64>,
    /// Conductances between nodes: negative off the diagonal, on it what leaves the node, to the
    /// gas too.
    conductance_w_per_k: DMatrix<f64>,
    to_gas_w_per_k: DVector<f64>,
}

/// A network's exact step over one period.
#[derive(Debug, Clone)]
pub struct Step {
    transition: DMatrix<f64>,
    drive: DMatrix<f64>,
}

impl Network {
    /// Nodes with nothing between them.
    pub fn new(capacity_j_per_k: &[f64]) -> Self {
        let nodes = capacity_j_per_k.len();
        Self {
            capacity_j_per_k: DVector::from_column_slice(capacity_j_per_k),
            conductance_w_per_k: DMatrix::zeros(nodes, nodes),
            to_gas_w_per_k: DVector::zeros(nodes),
        }
    }

    /// Joins two nodes.
    pub fn join(&mut self, a: usize, b: usize, conductance_w_per_k: f64) {
        for (i, j) in [(a, b), (b, a)] {
            self.conductance_w_per_k[(i, i)] += conductance_w_per_k;
            self.conductance_w_per_k[(i, j)] -= conductance_w_per_k;
        }
    }

    /// Joins a node with the gas.
    pub fn cool(&mut self, node: usize, conductance_w_per_k: f64) {
        self.conductance_w_per_k[(node, node)] += conductance_w_per_k;
        self.to_gas_w_per_k[node] += conductance_w_per_k;
    }

    /// Takes a node's gas for something else that is held at 0 °C: it is cooled as before, but no
    /// longer by the gas.
    pub fn shelter(&mut self, node: usize) {
        self.to_gas_w_per_k[node] = 0.0;
    }

    pub fn nodes(&self) -> usize {
        self.capacity_j_per_k.len()
    }

    /// Steady rise of every node (row) per watt into every node (column), K/W. Symmetric: heat is
    /// reciprocal.
    ///
    /// # Panics
    /// If some node loses its heat nowhere.
    pub fn steady_gain_k_per_w(&self) -> DMatrix<f64> {
        self.conductance_w_per_k.clone().try_inverse().expect("every node loses its heat somewhere")
    }

    /// Rates of relaxation in rad/s, ascending.
    pub fn rates_rad_s(&self) -> Vec<f64> {
        // C^−½ G C^−½ is symmetric and has the eigenvalues of C^−1 G.
        let root = self.capacity_j_per_k.map(|capacity| capacity.sqrt().recip());
        let scaled = DMatrix::from_diagonal(&root) * &self.conductance_w_per_k * DMatrix::from_diagonal(&root);
        let mut rates: Vec<f64> = scaled.symmetric_eigenvalues().iter().copied().collect();
        rates.sort_by(f64::total_cmp);
        rates
    }

    /// Heat that the nodes hold above 0 °C, J.
    pub fn heat_j(&self, temperatures_c: &DVector<f64>) -> f64 {
        self.capacity_j_per_k.dot(temperatures_c)
    }

    /// Power that the nodes lose to a gas of 0 °C, W.
    pub fn loss_w(&self, temperatures_c: &DVector<f64>) -> f64 {
        self.to_gas_w_per_k.dot(temperatures_c)
    }

    /// The exact step with the powers of the first `heated` nodes as inputs, and the gas
    /// temperature as the last.
    pub fn step(&self, heated: usize, period_s: f64) -> Step {
        let (nodes, inputs) = (self.nodes(), heated + 1);
        let mut generator = DMatrix::zeros(nodes + inputs, nodes + inputs);
        for i in 0..nodes {
            let capacity = self.capacity_j_per_k[i];
            for j in 0..nodes {
                generator[(i, j)] = -self.conductance_w_per_k[(i, j)] / capacity;
            }
            if i < heated {
                generator[(i, nodes + i)] = capacity.recip();
            }
            generator[(i, nodes + heated)] = self.to_gas_w_per_k[i] / capacity;
        }
        let exponential = diffusive::predict::exponential::exponential(&(generator * period_s));
        Step {
            transition: exponential.view((0, 0), (nodes, nodes)).into_owned(),
            drive: exponential.view((0, nodes), (nodes, inputs)).into_owned(),
        }
    }
}

impl Step {
    /// One period further: powers of the heated nodes, then the gas temperature.
    pub fn advance(&self, temperatures_c: &mut DVector<f64>, inputs: &DVector<f64>) {
        *temperatures_c = &self.transition * &*temperatures_c + &self.drive * inputs;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair() -> Network {
        let mut network = Network::new(&[0.02, 0.5]);
        network.join(0, 1, 0.01);
        network.cool(0, 0.002);
        network.cool(1, 0.004);
        network
    }

    #[test]
    fn one_node_answers_by_its_exponential() {
        let mut network = Network::new(&[0.1]);
        network.cool(0, 0.02);
        let step = network.step(1, 0.3);
        let mut temperature = DVector::from_element(1, 18.0);
        for n in 1..=50 {
            step.advance(&mut temperature, &DVector::from_vec(vec![0.05, 18.0]));
            // P/G (1 − e^(−t G/C)) above the gas
            let expected = 18.0 + 2.5 * (1.0 - libm::exp(-0.06 * f64::from(n)));
            assert!((temperature[0] - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn steps_may_be_of_any_length_and_end_in_the_steady_state() {
        let inputs = DVector::from_vec(vec![0.03, 20.0]);
        let (fine, coarse) = (pair().step(1, 0.01), pair().step(1, 10.0));
        let (mut a, mut b) = (DVector::zeros(2), DVector::zeros(2));
        (0..1000).for_each(|_| fine.advance(&mut a, &inputs));
        coarse.advance(&mut b, &inputs);
        // 1000 roundings of 20 °C
        assert!((&a - &b).amax() < 1e-11, "{a} {b}");
        (0..10_000).for_each(|_| coarse.advance(&mut b, &inputs));
        // By hand: 0.03 W and G = [0.012 −0.01; −0.01 0.014] give 0.03 · [0.014; 0.01] / 6.8e-5.
        assert!((b[0] - 20.0 - 0.03 * 0.014 / 6.8e-5).abs() < 1e-9);
        assert!((b[1] - 20.0 - 0.03 * 0.01 / 6.8e-5).abs() < 1e-9);
        assert!((pair().steady_gain_k_per_w()[(1, 0)] - 0.01 / 6.8e-5).abs() < 1e-9);
    }

    #[test]
    fn heat_is_kept_or_lost_to_the_gas_and_nowhere_else() {
        // Over a step so short that the temperatures hardly move, dQ = (P − loss) h.
        let (network, h) = (pair(), 1e-4);
        let mut temperatures = DVector::from_vec(vec![31.0, 12.0]);
        let before = network.heat_j(&temperatures);
        let loss = network.loss_w(&temperatures);
        network.step(1, h).advance(&mut temperatures, &DVector::from_vec(vec![0.03, 0.0]));
        let gained = (network.heat_j(&temperatures) - before) / h;
        // h times the greatest rate, 0.6/s, is 6e-5 of the largest flow, 0.2 W; the difference of
        // 6.6 J adds 1e-15/h.
        assert!((gained - (0.03 - loss)).abs() < 2e-5, "{gained}");
    }

    #[test]
    fn rates_are_those_of_the_characteristic_polynomial() {
        // λ² − (G00/C0 + G11/C1) λ + det G/(C0 C1) = 0
        let (sum, product): (f64, f64) = (0.012 / 0.02 + 0.014 / 0.5, 6.8e-5 / 0.01);
        let root = (sum * sum / 4.0 - product).sqrt();
        let rates = pair().rates_rad_s();
        assert!((rates[0] - (sum / 2.0 - root)).abs() < 1e-14 && (rates[1] - (sum / 2.0 + root)).abs() < 1e-14);
    }
}
