//! Prototype B as a thermal network: four silver sectors, a platinum chip on each, two core heaters, a support stem.
//!
//! ```text
//!   gas ── sector 1 ── chip 1        sectors 1 and 2 face core 1, sectors 3 and 4 core 2;
//!            │   ╲                   every sector also touches the three others,
//!            │    sector 2 …         and all four radiate to surroundings at gas temperature
//!          core 1 ══ core 2
//!               ╲    ╱
//!            stem, 8 cells ── support at a fixed temperature
//! ```
//!
//! | part | value | reason |
//! |---|---|---|
//! | sphere | 10 mm | thesis, prototype B |
//! | sector | 0.118 J/K | 0.5 g of silver, 235 J/(kg·K); at 0.6 mm its own gradient is 1e-3 of that to the gas |
//! | chip | 4.7 mJ/K | bare silicon, 2.5 × 2.5 × 0.5 mm, 2330 kg/m³, 650 J/(kg·K) at 250 K |
//! | chip to sector | 2 W/K | soldered: half its thickness 0.2, 25 µm of solder 0.1, spreading in 0.6 mm of silver 0.2 K/W |
//! | sector to core | 0.6 mW/K | gas gap and wires |
//! | sector to sector | 0.1 mW/K | three seams each |
//! | core | 75 mJ/K each | half of 0.15 J/K: two FR4 boards of 6 × 6 × 0.8 mm with copper, solder and resistor |
//! | core to core | 20 mW/K | the boards back to back, 36 mm² through 2 × 0.4 mm of FR4 at 0.3 W/(m·K), and some vias |
//! | stem | 1.2 mW/K, 0.2 J/K | from the cores to the support in 8 cells |
//! | emissivity | 0.03 | sputtered gold |
//!
//! The element that heats and senses is the chip on a sector, and the board itself in the core. What a chip reads right after a period
//! at the high level lies above its sector by power times contact (20 mK here). A one-bit loop turns part of that into an offset of
//! the mean: up to 9 mK at 100 Hz; glued with 20 µm of silver epoxy (0.5 W/K) it would be 25 mK.
//!
//! Limits: the chips lose nothing to the gas inside, the stem nothing to the wind; no temperature dependence of the parts.

use std::f64::consts::PI;

use super::convection::SECTORS;
use super::gas::{Gas, ZERO_CELSIUS_K};
use super::network::{BoundaryId, Network, RadiatorId};
use super::{CORES, ELEMENTS, SensorError};

/// Stefan–Boltzmann constant, W/(m²·K⁴).
const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8;

/// What the sphere is made of; the default is prototype B.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Construction {
    pub diameter_m: f64,
    pub sector_capacity_j_k: f64,
    pub chip_capacity_j_k: f64,
    pub chip_contact_w_k: f64,
    pub sector_to_core_w_k: f64,
    pub sector_to_sector_w_k: f64,
    pub core_capacity_j_k: f64,
    pub core_to_core_w_k: f64,
    pub stem_w_k: f64,
    pub stem_capacity_j_k: f64,
    pub stem_cells: usize,
    pub emissivity: f64,
}

impl Default for Construction {
    fn default() -> Construction {
        Construction {
            diameter_m: 0.01,
            sector_capacity_j_k: 0.118,
            chip_capacity_j_k: 4.7e-3,
            chip_contact_w_k: 2.0,
            sector_to_core_w_k: 6e-4,
            sector_to_sector_w_k: 1e-4,
            core_capacity_j_k: 0.075,
            core_to_core_w_k: 0.02,
            stem_w_k: 1.2e-3,
            stem_capacity_j_k: 0.2,
            stem_cells: 8,
            emissivity: 0.03,
        }
    }
}

impl Construction {
    fn check(&self) -> Result<(), SensorError> {
        for (name, value) in [
            ("diameter_m", self.diameter_m),
            ("sector_capacity_j_k", self.sector_capacity_j_k),
            ("chip_capacity_j_k", self.chip_capacity_j_k),
            ("chip_contact_w_k", self.chip_contact_w_k),
            ("sector_to_core_w_k", self.sector_to_core_w_k),
            ("sector_to_sector_w_k", self.sector_to_sector_w_k),
            ("core_capacity_j_k", self.core_capacity_j_k),
            ("core_to_core_w_k", self.core_to_core_w_k),
            ("stem_w_k", self.stem_w_k),
            ("stem_capacity_j_k", self.stem_capacity_j_k),
            ("stem_cells", self.stem_cells as f64),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(SensorError::out_of_range(name, value, "more than 0"));
            }
        }
        if !(0.0..=1.0).contains(&self.emissivity) {
            return Err(SensorError::out_of_range("emissivity", self.emissivity, "0 to 1"));
        }
        Ok(())
    }
}

/// Mean heat flows over an interval, W. Of a sector: what is given to the gas, radiated, and conducted to the inside.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Flows {
    pub power_w: [f64; ELEMENTS],
    pub convection_w: [f64; SECTORS],
    pub radiation_w: [f64; SECTORS],
    pub conduction_w: [f64; SECTORS],
    pub support_w: f64,
}

/// The sphere as a body that takes heat and loses it.
#[derive(Clone, Debug)]
pub struct Body {
    network: Network,
    sectors: [usize; SECTORS],
    /// Node of every element: the four chips, then the two cores.
    elements: [usize; ELEMENTS],
    gas_links: [BoundaryId; SECTORS],
    radiators: [RadiatorId; SECTORS],
    support: BoundaryId,
    /// Bound of the fastest rate without convection, 1/s.
    own_rate_per_s: f64,
    /// What convection may add to it, 1/s.
    convection_rate_per_s: f64,
    node_power_w: Vec<f64>,
}

impl Body {
    /// A sphere in equilibrium with the gas, its stem between gas and support.
    pub fn new(construction: &Construction, gas: &Gas, support_k: f64) -> Result<Body, SensorError> {
        construction.check()?;
        if !(support_k.is_finite() && support_k > 0.0) {
            let celsius = support_k - ZERO_CELSIUS_K;
            return Err(SensorError::out_of_range("support.temperature_c", celsius, "above -273.15"));
        }
        let mut network = Network::new();
        let gas_k = gas.temperature_k;
        let sectors: [usize; SECTORS] =
            std::array::from_fn(|_| network.add_node(construction.sector_capacity_j_k, gas_k));
        let chips: [usize; SECTORS] = std::array::from_fn(|_| network.add_node(construction.chip_capacity_j_k, gas_k));
        let cores: [usize; CORES] = std::array::from_fn(|_| network.add_node(construction.core_capacity_j_k, gas_k));

        for i in 0..SECTORS {
            network.link(chips[i], sectors[i], construction.chip_contact_w_k);
            network.link(sectors[i], cores[i / 2], construction.sector_to_core_w_k);
            for j in 0..i {
                network.link(sectors[i], sectors[j], construction.sector_to_sector_w_k);
            }
        }
        network.link(cores[0], cores[1], construction.core_to_core_w_k);
        let support = add_stem(&mut network, &cores, construction, gas_k, support_k);

        let own_rate_per_s = network.stiffest_rate_per_s();
        let gas_links = sectors.map(|sector| network.link_to_fixed(sector, 0.0, gas_k));
        let area_m2 = PI * construction.diameter_m * construction.diameter_m / SECTORS as f64;
        let coefficient = construction.emissivity * STEFAN_BOLTZMANN * area_m2;
        let radiators = sectors.map(|sector| network.radiate(sector, coefficient, gas_k));
        let mut elements = [0; ELEMENTS];
        elements[..SECTORS].copy_from_slice(&chips);
        elements[SECTORS..].copy_from_slice(&cores);
        let node_power_w = vec![0.0; network.len()];
        Ok(Body {
            network,
            sectors,
            elements,
            gas_links,
            radiators,
            support,
            own_rate_per_s,
            convection_rate_per_s: 0.0,
            node_power_w,
        })
    }

    /// Conductance of every sector to the gas from now on, W/K.
    pub fn set_convection(&mut self, conductance_w_k: &[f64; SECTORS]) {
        for (link, &conductance) in self.gas_links.iter().zip(conductance_w_k) {
            self.network.set_boundary_conductance(*link, conductance);
        }
        // It widens the circles of the sectors only, which are slow; the sum of both rates bounds all.
        let largest = conductance_w_k.iter().fold(0.0, |a: f64, &b| a.max(b));
        self.convection_rate_per_s = largest / self.network.capacity_j_k(self.sectors[0]);
    }

    /// Integrates over `interval_s`. `power_w` tells the heat of an element from its number and temperature in °C and is asked at
    /// the start of every substep.
    pub fn advance(&mut self, interval_s: f64, power_w: impl Fn(usize, f64) -> f64) -> Flows {
        let before = self.balance();
        let mut given_j = [0.0; ELEMENTS];
        let substeps = Network::substeps(interval_s, self.own_rate_per_s + self.convection_rate_per_s);
        let step_s = interval_s / substeps as f64;
        for _ in 0..substeps {
            for (i, given) in given_j.iter_mut().enumerate() {
                let power = power_w(i, self.element_temperature_c(i));
                self.node_power_w[self.elements[i]] = power;
                *given += power * step_s;
            }
            self.network.step(step_s, &self.node_power_w);
        }
        let after = self.balance();
        let convection_w = difference(&after.convection_j, &before.convection_j, interval_s);
        let radiation_w = difference(&after.radiation_j, &before.radiation_j, interval_s);
        let stored_w = difference(&after.stored_j, &before.stored_j, interval_s);
        let power_w = given_j.map(|given| given / interval_s);
        Flows {
            power_w,
            convection_w,
            radiation_w,
            conduction_w: std::array::from_fn(|i| power_w[i] - convection_w[i] - radiation_w[i] - stored_w[i]),
            support_w: (after.support_j - before.support_j) / interval_s,
        }
    }

    /// Sets the steady state of the present convection under the powers of `power_w`, which may depend on temperature a little.
    pub fn settle(&mut self, power_w: impl Fn(usize, f64) -> f64) {
        // A resistor's power changes by 0.3 % a kelvin: each round gains two digits at least.
        for _ in 0..10 {
            for (i, &node) in self.elements.iter().enumerate() {
                self.node_power_w[node] = power_w(i, self.element_temperature_c(i));
            }
            self.network.settle(&self.node_power_w);
        }
    }

    /// Heat flows of a steady state that [`Body::settle`] has found: the present rates, without letting time pass.
    pub fn steady_flows(&self, power_w: impl Fn(usize, f64) -> f64) -> Flows {
        self.clone().advance(1e-3, power_w)
    }

    pub fn element_temperature_c(&self, element: usize) -> f64 {
        self.network.temperature_k(self.elements[element]) - ZERO_CELSIUS_K
    }

    pub fn sector_temperature_c(&self, sector: usize) -> f64 {
        self.network.temperature_k(self.sectors[sector]) - ZERO_CELSIUS_K
    }

    /// Heat stored in the whole sphere and its stem, J, up to a constant.
    pub fn stored_heat_j(&self) -> f64 {
        self.network.stored_heat_j()
    }

    fn balance(&self) -> Balance {
        let network = &self.network;
        let heat = |node| network.capacity_j_k(node) * network.temperature_k(node);
        Balance {
            convection_j: self.gas_links.map(|link| network.boundary_heat_j(link)),
            radiation_j: self.radiators.map(|radiator| network.radiator_heat_j(radiator)),
            stored_j: std::array::from_fn(|i| heat(self.sectors[i]) + heat(self.elements[i])),
            support_j: network.boundary_heat_j(self.support),
        }
    }
}

/// Heat that has gone each way so far, and heat in each sector with its chip, J.
struct Balance {
    convection_j: [f64; SECTORS],
    radiation_j: [f64; SECTORS],
    stored_j: [f64; SECTORS],
    support_j: f64,
}

fn difference(after: &[f64; SECTORS], before: &[f64; SECTORS], interval_s: f64) -> [f64; SECTORS] {
    std::array::from_fn(|i| (after[i] - before[i]) / interval_s)
}

/// Cells of equal length: whole conductances between them, half a cell (so twice the conductance) at either end. Two cores share the
/// upper end, hence half of that each.
fn add_stem(
    network: &mut Network,
    cores: &[usize; CORES],
    construction: &Construction,
    gas_k: f64,
    support_k: f64,
) -> BoundaryId {
    let count = construction.stem_cells;
    let cell_w_k = construction.stem_w_k * count as f64;
    let cells: Vec<usize> = (0..count)
        .map(|k| {
            let position = (k as f64 + 0.5) / count as f64;
            network.add_node(construction.stem_capacity_j_k / count as f64, gas_k + position * (support_k - gas_k))
        })
        .collect();
    for &core in cores {
        network.link(core, cells[0], 2.0 * cell_w_k / CORES as f64);
    }
    for pair in cells.windows(2) {
        network.link(pair[0], pair[1], cell_w_k);
    }
    network.link_to_fixed(cells[count - 1], 2.0 * cell_w_k, support_k)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::convection::Convection;
    use crate::sensor::gas::Species;

    fn mars() -> Gas {
        Gas::new(Species::CarbonDioxide, 700.0, 220.0).unwrap()
    }

    fn body() -> Body {
        Body::new(&Construction::default(), &mars(), 230.0).unwrap()
    }

    #[test]
    fn heat_in_is_heat_out_and_heat_stored() {
        let convection = Convection::new(&mars(), 0.01).unwrap();
        let mut body = body();
        let start = body.stored_heat_j();
        let (mut given, mut left) = (0.0, 0.0);
        for tick in 0..100_000 {
            // A wind that turns and a square wave of heat, so that every path carries a changing flow.
            let phase = tick as f64 * 1e-3;
            let conductance = convection.sector_conductance_w_k([6.0 * phase.cos(), 3.0 * phase.sin(), 1.0]);
            let high = tick / 3 % 2 == 0;
            body.set_convection(&conductance);
            let flows = body.advance(0.01, |i, _| if high { 0.04 } else { 0.001 * i as f64 });
            given += 0.01 * flows.power_w.iter().sum::<f64>();
            left += 0.01 * (flows.convection_w.iter().chain(&flows.radiation_w).sum::<f64>() + flows.support_w);
        }
        let balance = given - left - (body.stored_heat_j() - start);
        assert!((balance / given).abs() < 1e-10, "{balance} J of {given} J");
    }

    #[test]
    fn steady_heat_of_a_sector_is_what_it_conducts_radiates_and_gives_to_the_gas() {
        let convection = Convection::new(&mars(), 0.01).unwrap();
        let conductance = convection.sector_conductance_w_k([2.0, 0.0, 0.0]);
        let mut body = body();
        body.set_convection(&conductance);
        body.settle(|_, _| 0.02);
        let flows = body.advance(0.01, |_, _| 0.02);
        for (i, conductance) in conductance.into_iter().enumerate() {
            let overheat = body.sector_temperature_c(i) + ZERO_CELSIUS_K - 220.0;
            assert!((flows.convection_w[i] - conductance * overheat).abs() < 1e-12);
            let left = flows.convection_w[i] + flows.radiation_w[i] + flows.conduction_w[i];
            assert!((left - 0.02).abs() < 1e-9, "{left}");
            // The chip stands above its sector by the heat through its contact.
            let contact = body.element_temperature_c(i) - body.sector_temperature_c(i);
            assert!((contact - 0.02 / 2.0).abs() < 1e-9);
        }
    }

    #[test]
    fn gold_radiates_about_a_fiftieth_of_a_milliwatt_a_kelvin() {
        let mut body = body();
        let conductance = [1e-12; SECTORS];
        // A warm sphere: 4 ε σ A T³ at the mean of 220 K and its own temperature.
        body.set_convection(&conductance);
        body.settle(|i, _| if i < SECTORS { 5e-3 } else { 0.0 });
        let flows = body.advance(1e-3, |i, _| if i < SECTORS { 5e-3 } else { 0.0 });
        let overheat = body.sector_temperature_c(0) + ZERO_CELSIUS_K - 220.0;
        let per_kelvin = flows.radiation_w.iter().sum::<f64>() / overheat;
        let mean_k: f64 = 220.0 + 0.5 * overheat;
        let expected = 4.0 * 0.03 * STEFAN_BOLTZMANN * PI * 1e-4 * mean_k.powi(3);
        assert!((per_kelvin / expected - 1.0).abs() < 0.02, "{per_kelvin} for {expected}");
        let at_gas = 4.0 * 0.03 * STEFAN_BOLTZMANN * PI * 1e-4 * 220.0_f64.powi(3);
        assert!((at_gas * 1e3 - 0.02).abs() < 0.005, "{at_gas}");
    }

    #[test]
    fn the_stem_conducts_what_it_should() {
        // Only core 1 is heated and nothing leaves through the gas: all heat goes down the stem.
        let mut body = Body::new(&Construction { emissivity: 0.0, ..Construction::default() }, &mars(), 230.0).unwrap();
        let conductance = [0.0; SECTORS];
        body.set_convection(&conductance);
        body.settle(|i, _| if i == SECTORS { 0.012 } else { 0.0 });
        let flows = body.advance(0.01, |i, _| if i == SECTORS { 0.012 } else { 0.0 });
        assert!((flows.support_w - 0.012).abs() < 1e-9);
        // The mean of the two cores drives it: 12 mW over 1.2 mW/K is 10 K, the symmetric half-links see exactly the mean.
        let mean_core = 0.5 * (body.element_temperature_c(4) + body.element_temperature_c(5)) + ZERO_CELSIUS_K;
        assert!((mean_core - 240.0).abs() < 1e-6, "{mean_core}");
    }

    #[test]
    fn a_free_sector_cools_with_the_published_time_constant() {
        // Silver sphere in still gas of 1 m/s or less: C/G = 4 · 0.118 / (1.2 to 1.4 mW/K), 340–400 s.
        let convection = Convection::new(&mars(), 0.01).unwrap();
        let total: f64 = convection.sector_conductance_w_k([1.0, 0.0, 0.0]).iter().sum();
        let time_constant_s = 4.0 * Construction::default().sector_capacity_j_k / total;
        assert!((340.0..=400.0).contains(&time_constant_s), "{time_constant_s}");
    }

    #[test]
    fn refuses_an_impossible_construction_by_name() {
        let bad = Construction { chip_contact_w_k: 0.0, ..Construction::default() };
        let error = Body::new(&bad, &mars(), 230.0).unwrap_err().to_string();
        assert!(error.contains("chip_contact_w_k"), "{error}");
        let error = Body::new(&Construction::default(), &mars(), f64::NAN).unwrap_err().to_string();
        assert!(error.contains("support.temperature_c"), "{error}");
    }
}
