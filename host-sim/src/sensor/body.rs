//! A body that takes heat and loses it: a thermal network with the elements that heat it and the
//! surfaces that the wind cools.
//!
//! [`assembly`](super::assembly) makes one of a head file's `[body]`. Everything after that is the
//! same for all of them and is here: wind into conductances, powers into temperatures, and the
//! account of where the heat went.

use std::ops::Range;

use super::convection::BodyConvection;
use super::field::{CooledStem, LocalWind};
use super::network::{BoundaryId, RadiatorId, ThermalNetwork};
use anemometry::gas::{IdealGas, TEMPERATURE_RANGE_K, ZERO_CELSIUS_K};
use anemometry::vector::length;

mod effects;

/// Stefan–Boltzmann constant, W/(m²·K⁴).
pub const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8;

/// Properties of the gas are made anew when its temperature has moved by more than this, K: some
/// 5e-5 of a conductance.
const SAME_PROPERTIES_K: f64 = 0.01;

/// A surface as a body describes it.
#[derive(Clone, Debug)]
pub struct Surface {
    pub name: String,
    pub node: usize,
    pub emissivity: f64,
    pub area_m2: f64,
    /// Its area over that of its shape: it loses that much more than the law has it.
    pub factor: f64,
    /// Nodes that hang on it: those whose heat counts as the surface's own, beside its node.
    pub carries: Vec<usize>,
    /// The element that heats it, by its number.
    pub element: Option<usize>,
}

/// A gap between two nodes that is filled with the gas.
#[derive(Clone, Copy, Debug)]
pub struct GasGap {
    pub link: usize,
    pub ends: [usize; 2],
    /// Area over width, m.
    pub area_over_width_m: f64,
}

/// Parts that a network is joined to: everything that makes a body of it.
#[derive(Clone, Debug, Default)]
pub struct BodyParts {
    /// Node of every element.
    pub elements: Vec<usize>,
    pub surfaces: Vec<Surface>,
    pub supports: Vec<BoundaryId>,
    /// First cells of the rods that lead there.
    pub stem_ends: Vec<usize>,
    pub gaps: Vec<GasGap>,
    /// A law, and which surfaces lose heat by it.
    pub convection: Vec<(BodyConvection, Range<usize>)>,
}

/// Mean heat flows over an interval, W.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Flows {
    /// Electrical heat of every element.
    pub power_w: Vec<f64>,
    /// Heat of every surface, from the sun and what else is put onto it.
    pub absorbed_w: Vec<f64>,
    /// Heat of every surface, to the gas.
    pub convection_w: Vec<f64>,
    /// Heat of every surface, to the surroundings.
    pub radiation_w: Vec<f64>,
    /// Heat of every surface, to the inside and to other surfaces.
    pub conduction_w: Vec<f64>,
    /// From stem or boom to the support.
    pub support_w: f64,
    /// From the stem to the gas.
    pub stem_w: f64,
}

/// Heat of a surface so far, J: given to the gas, radiated, and stored.
#[derive(Clone, Copy, Debug, Default)]
struct Balance {
    convection_j: f64,
    radiation_j: f64,
    stored_j: f64,
}

#[derive(Clone, Debug)]
pub struct ThermalBody {
    network: ThermalNetwork,
    parts: BodyParts,
    /// Gas as the convection has it: the temperature of the links may be a little ahead.
    gas: IdealGas,
    wind_m_s: [f64; 3],
    gas_links: Vec<BoundaryId>,
    radiators: Vec<RadiatorId>,
    /// Bound of the fastest rate without convection, 1/s.
    own_rate_per_s: f64,
    /// Rate that convection may add, 1/s.
    convection_rate_per_s: f64,
    flows: Flows,
    /// Between the wind and what spheres meet.
    local_wind: LocalWind,
    /// Conductance of every surface to the gas over that of its law.
    gain: Vec<f64>,
    cooled_stem: Option<CooledStem>,
    /// Temperature of what surfaces radiate to, K.
    sky_k: f64,
    /// Heat of every node, beside the elements' heat.
    absorbed_w: Vec<f64>,
    // Work space, kept so that a tick allocates nothing.
    node_power_w: Vec<f64>,
    surface_k: Vec<f64>,
    conductance_w_k: Vec<f64>,
    before: Vec<Balance>,
}

impl ThermalBody {
    /// Gives a network its surfaces, in a gas and among surroundings of its temperature.
    pub fn new(mut network: ThermalNetwork, parts: BodyParts, gas: &IdealGas) -> ThermalBody {
        let gas_k = gas.temperature_k;
        // Gaps conduct most in the hottest gas.
        let hottest_w_m_k = gas.at(*TEMPERATURE_RANGE_K.end()).conductivity_w_m_k;
        parts.gaps.iter().for_each(|gap| network.set_link(gap.link, gap.area_over_width_m * hottest_w_m_k));
        let own_rate_per_s = network.stiffest_rate_per_s();
        let surfaces = &parts.surfaces;
        let gas_links = surfaces.iter().map(|surface| network.link_to_fixed(surface.node, 0.0, gas_k)).collect();
        let radiate = |surface: &Surface| {
            let coefficient_w_k4 = surface.emissivity * STEFAN_BOLTZMANN * surface.area_m2;
            network.radiate(surface.node, coefficient_w_k4, gas_k)
        };
        let radiators = surfaces.iter().map(radiate).collect();
        let each = vec![0.0; surfaces.len()];
        let mut body = ThermalBody {
            gas: *gas,
            wind_m_s: [0.0; 3],
            gas_links,
            radiators,
            own_rate_per_s,
            convection_rate_per_s: 0.0,
            flows: Flows {
                power_w: vec![0.0; parts.elements.len()],
                absorbed_w: each.clone(),
                convection_w: each.clone(),
                radiation_w: each.clone(),
                conduction_w: each.clone(),
                support_w: 0.0,
                stem_w: 0.0,
            },
            local_wind: LocalWind::default(),
            gain: vec![1.0; surfaces.len()],
            cooled_stem: None,
            sky_k: gas_k,
            absorbed_w: vec![0.0; network.len()],
            node_power_w: vec![0.0; network.len()],
            surface_k: each.clone(),
            conductance_w_k: each,
            before: vec![Balance::default(); surfaces.len()],
            network,
            parts,
        };
        body.fill_gaps();
        body
    }

    /// The gas's temperature from now on, at the same pressure; the next [`ThermalBody::set_wind`]
    /// makes conductances of it. The surroundings to which surfaces radiate stay as they were.
    pub fn set_gas_temperature_k(&mut self, temperature_k: f64) {
        for link in &self.gas_links {
            self.network.boundary_mut(*link).temperature_k = temperature_k;
        }
        if let Some(stem) = &self.cooled_stem {
            stem.set_gas_k(&mut self.network, temperature_k);
        }
        if (temperature_k - self.gas.temperature_k).abs() > SAME_PROPERTIES_K {
            self.gas = self.gas.at(temperature_k);
            self.parts.convection.iter_mut().for_each(|(law, _)| law.follow(&self.gas));
        }
    }

    /// The support's temperature from now on.
    pub fn set_support_temperature_k(&mut self, temperature_k: f64) {
        for link in &self.parts.supports {
            self.network.boundary_mut(*link).temperature_k = temperature_k;
        }
    }

    /// The wind from now on, m/s.
    pub fn set_wind(&mut self, wind_m_s: [f64; 3]) {
        self.wind_m_s = wind_m_s;
        for (surface, surface_k) in self.parts.surfaces.iter().zip(&mut self.surface_k) {
            *surface_k = self.network.temperature_k(surface.node);
        }
        for (law, surfaces) in &self.parts.convection {
            let surface_k = &self.surface_k[surfaces.clone()];
            let local_m_s = law.sphere().map_or(wind_m_s, |sphere| {
                self.local_wind.around(wind_m_s, &self.gas, sphere.stream().diameter_m(), surface_k)
            });
            law.conductance_w_k(local_m_s, surface_k, &mut self.conductance_w_k[surfaces.clone()]);
        }
        self.apply_conductance();
    }

    fn apply_conductance(&mut self) {
        // It widens the circles of the surfaces only, which are slow; the sum of both rates bounds
        // all.
        self.convection_rate_per_s = 0.0;
        let surfaces = self.parts.surfaces.iter().zip(&self.gain).zip(&self.gas_links);
        for (((surface, gain), link), conductance) in surfaces.zip(&mut self.conductance_w_k) {
            *conductance *= surface.factor * gain;
            self.network.boundary_mut(*link).conductance_w_k = *conductance;
            let rate_per_s = *conductance / self.network.capacity_j_k(surface.node);
            self.convection_rate_per_s = self.convection_rate_per_s.max(rate_per_s);
        }
        if let Some(stem) = &self.cooled_stem {
            let rate_per_s = stem.set_speed(&mut self.network, length(self.wind_m_s));
            self.convection_rate_per_s = self.convection_rate_per_s.max(rate_per_s);
        }
    }

    /// Conductances of the gaps, at the temperatures between their ends.
    fn fill_gaps(&mut self) {
        for gap in &self.parts.gaps {
            let middle_k = 0.5 * gap.ends.iter().map(|&node| self.network.temperature_k(node)).sum::<f64>();
            let known_k = middle_k.clamp(*TEMPERATURE_RANGE_K.start(), *TEMPERATURE_RANGE_K.end());
            let conductivity_w_m_k = self.gas.at(known_k).conductivity_w_m_k;
            self.network.set_link(gap.link, gap.area_over_width_m * conductivity_w_m_k);
        }
    }

    /// Tells whether convection in this wind is an extrapolation.
    pub fn extrapolated(&self, wind_m_s: [f64; 3]) -> bool {
        let mut laws = self.parts.convection.iter();
        laws.any(|(law, surfaces)| law.extrapolated(wind_m_s, &self.surface_k[surfaces.clone()]))
    }

    /// Integrates over `interval_s`. `power_w` gives the heat of an element from its number and
    /// temperature in °C and is asked at the start of every substep.
    pub fn advance(&mut self, interval_s: f64, power_w: impl Fn(usize, f64) -> f64) {
        self.fill_gaps();
        for i in 0..self.parts.surfaces.len() {
            self.before[i] = self.balance(i);
        }
        let (support_before_j, stem_before_j) = (self.support_j(), self.stem_j());
        self.flows.power_w.fill(0.0);
        let substeps = self.substeps(interval_s);
        let step_s = interval_s / substeps as f64;
        for _ in 0..substeps {
            for (i, &node) in self.parts.elements.iter().enumerate() {
                let power = power_w(i, self.network.temperature_k(node) - ZERO_CELSIUS_K);
                self.node_power_w[node] = self.absorbed_w[node] + power;
                self.flows.power_w[i] += power * step_s / interval_s;
            }
            self.network.step(step_s, &self.node_power_w);
        }
        for i in 0..self.parts.surfaces.len() {
            let (before, after) = (self.before[i], self.balance(i));
            let convection_w = (after.convection_j - before.convection_j) / interval_s;
            let radiation_w = (after.radiation_j - before.radiation_j) / interval_s;
            let stored_w = (after.stored_j - before.stored_j) / interval_s;
            let heated_w = self.parts.surfaces[i].element.map_or(0.0, |element| self.flows.power_w[element]);
            let given_w = heated_w + self.flows.absorbed_w[i];
            self.flows.convection_w[i] = convection_w;
            self.flows.radiation_w[i] = radiation_w;
            self.flows.conduction_w[i] = given_w - convection_w - radiation_w - stored_w;
        }
        self.flows.support_w = (self.support_j() - support_before_j) / interval_s;
        self.flows.stem_w = (self.stem_j() - stem_before_j) / interval_s;
    }

    /// Steps of the integration in an interval, at the present wind.
    pub fn substeps(&self, interval_s: f64) -> usize {
        ThermalNetwork::substeps(interval_s, self.own_rate_per_s + self.convection_rate_per_s)
    }

    /// Heat that has left to the support, J.
    fn support_j(&self) -> f64 {
        self.parts.supports.iter().map(|&support| self.network.boundary_heat_j(support)).sum()
    }

    /// Heat that has left from stems to the gas, J.
    fn stem_j(&self) -> f64 {
        self.cooled_stem.as_ref().map_or(0.0, |stem| stem.heat_j(&self.network))
    }

    /// Sets the steady state of the present wind under the powers of `power_w`, which may depend on
    /// temperature a little, and its heat flows.
    pub fn settle(&mut self, power_w: impl Fn(usize, f64) -> f64) {
        self.find_steady_state(&power_w, &[]);
        // The present rates, without letting time pass.
        let mut ahead = self.clone();
        ahead.advance(1e-3, power_w);
        self.flows = ahead.flows;
    }

    /// Sets the steady state of the present wind with some elements held at temperatures, °C, and
    /// the others under `power_w`; returns the power of every element, W.
    pub fn hold(&mut self, held_c: &[Option<f64>], power_w: impl Fn(usize, f64) -> f64) -> Vec<f64> {
        let held: Vec<(usize, f64)> = held_c
            .iter()
            .zip(&self.parts.elements)
            .filter_map(|(held_c, &node)| held_c.map(|held_c| (node, held_c + ZERO_CELSIUS_K)))
            .collect();
        let mut needed_w = self.find_steady_state(&power_w, &held).into_iter();
        let power = |(i, held_c): (usize, &Option<f64>)| match held_c {
            Some(_) => needed_w.next().unwrap_or(f64::NAN),
            None => power_w(i, self.element_temperature_c(i)),
        };
        held_c.iter().enumerate().map(power).collect()
    }

    fn find_steady_state(&mut self, power_w: &impl Fn(usize, f64) -> f64, held_k: &[(usize, f64)]) -> Vec<f64> {
        let mut needed_w = Vec::new();
        // A resistor's power changes by 0.4 % a kelvin: each round gains two digits at least.
        for _ in 0..10 {
            for (i, &node) in self.parts.elements.iter().enumerate() {
                self.node_power_w[node] = self.absorbed_w[node] + power_w(i, self.element_temperature_c(i));
            }
            needed_w = self.network.hold(&self.node_power_w, held_k);
            // A conductance that depends on temperatures follows them.
            if self.follows_temperature() {
                self.fill_gaps();
                self.set_wind(self.wind_m_s);
            }
        }
        needed_w
    }

    /// Heat flows of the last interval, or of the steady state.
    pub fn flows(&self) -> &Flows {
        &self.flows
    }

    pub fn element_temperature_c(&self, element: usize) -> f64 {
        self.network.temperature_k(self.parts.elements[element]) - ZERO_CELSIUS_K
    }

    pub fn surface_temperature_c(&self, surface: usize) -> f64 {
        self.network.temperature_k(self.parts.surfaces[surface].node) - ZERO_CELSIUS_K
    }

    /// Names of the surfaces, in the order of their temperatures and flows.
    pub fn surface_names(&self) -> impl Iterator<Item = &str> {
        self.parts.surfaces.iter().map(|surface| surface.name.as_str())
    }

    /// Heat stored in the whole body and its rod, J, up to a constant.
    #[cfg(test)]
    pub fn stored_heat_j(&self) -> f64 {
        self.network.stored_heat_j()
    }

    fn balance(&self, surface: usize) -> Balance {
        let network = &self.network;
        let Surface { node, carries, .. } = &self.parts.surfaces[surface];
        Balance {
            convection_j: network.boundary_heat_j(self.gas_links[surface]),
            radiation_j: network.radiator_heat_j(self.radiators[surface]),
            stored_j: network.heat_j(*node) + carries.iter().map(|&node| network.heat_j(node)).sum::<f64>(),
        }
    }

    /// Tells whether a conductance depends on temperatures, so that a steady state takes some
    /// rounds.
    fn follows_temperature(&self) -> bool {
        self.local_wind.buoyancy.is_some()
            || !self.parts.gaps.is_empty()
            || self.parts.convection.iter().any(|(law, _)| law.follows_surface())
    }

    /// Time constants at the present wind and temperatures, s, from the slowest.
    pub fn time_constants_s(&self) -> Vec<f64> {
        self.network.time_constants_s()
    }

    /// Capacity of the node of an element at 0 °C, J/K.
    pub fn element_capacity_j_k(&self, element: usize) -> f64 {
        self.network.capacity_j_k(self.parts.elements[element])
    }

    /// Number of elements.
    #[cfg(test)]
    pub fn elements(&self) -> usize {
        self.parts.elements.len()
    }

    /// Conductance of every surface to the gas, W/K.
    #[cfg(test)]
    pub fn conductance_w_k(&self) -> &[f64] {
        &self.conductance_w_k
    }

    /// Conductances that no wind gives.
    #[cfg(test)]
    pub fn set_conductance_w_k(&mut self, conductance_w_k: &[f64]) {
        self.conductance_w_k.copy_from_slice(conductance_w_k);
        self.apply_conductance();
    }
}

#[cfg(test)]
pub(super) mod testing {
    use super::ThermalBody;

    /// Heat given less heat that left and heat that stayed, of the heat given, after ticks of some
    /// seconds.
    ///
    /// `weather` sets wind and gas by a phase, and `power_w` has an element's heat while all are
    /// high or low by turns of three ticks: every path carries a changing flow.
    pub fn imbalance(
        body: &mut ThermalBody,
        (ticks, tick_s): (u32, f64),
        weather: impl Fn(&mut ThermalBody, f64),
        power_w: impl Fn(usize, bool) -> f64,
    ) -> f64 {
        let start = body.stored_heat_j();
        let (mut given, mut left) = (0.0, 0.0);
        for tick in 0..ticks {
            weather(body, f64::from(tick) * 1e-3);
            let high = tick / 3 % 2 == 0;
            body.advance(tick_s, |i, _| power_w(i, high));
            let flows = body.flows();
            given += tick_s * flows.power_w.iter().chain(&flows.absorbed_w).sum::<f64>();
            left += tick_s
                * (flows.convection_w.iter().chain(&flows.radiation_w).sum::<f64>() + flows.support_w + flows.stem_w);
        }
        (given - left - (body.stored_heat_j() - start)) / given
    }
}
