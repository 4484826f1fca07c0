//! A body in the field: sunlight on it, drifts of its surfaces, another sky, a stem in the wind.

use super::{STEFAN_BOLTZMANN, ThermalBody};
use crate::sensor::field::{CooledStem, LocalWind, Stem};

impl ThermalBody {
    /// Tells whether a sphere is among its shapes.
    pub fn has_sphere(&self) -> bool {
        self.parts.convection.iter().any(|(law, _)| law.sphere().is_some())
    }

    /// The surface that an element heats.
    pub fn surface_of(&self, element: usize) -> Option<usize> {
        self.parts.surfaces.iter().position(|surface| surface.element == Some(element))
    }

    /// The link between an element and a surface, and its conductance, W/K.
    pub fn contact(&self, element: usize, surface: usize) -> Option<(usize, f64)> {
        self.network.link_between(self.parts.elements[element], self.parts.surfaces[surface].node)
    }

    pub fn emissivity(&self, surface: usize) -> f64 {
        self.parts.surfaces[surface].emissivity
    }

    /// Area of every surface that the sun at this unit vector sees, m²; none of what is no sphere.
    pub fn lit_m2(&self, towards_sun: [f64; 3], lit_m2: &mut [f64]) {
        for (law, surfaces) in &self.parts.convection {
            let Some(sphere) = law.sphere() else { continue };
            let mut of_surfaces = self.parts.surfaces[surfaces.clone()].iter().zip(&mut lit_m2[surfaces.clone()]);
            sphere.lit_shares(towards_sun, |share| {
                if let Some((surface, lit_m2)) = of_surfaces.next() {
                    *lit_m2 = share * surface.area_m2;
                }
            });
        }
    }

    /// Heat put onto every surface from now on, W.
    pub fn set_absorbed_w(&mut self, absorbed_w: &[f64]) {
        self.absorbed_w.fill(0.0);
        for (surface, heat_w) in self.parts.surfaces.iter().zip(absorbed_w) {
            self.absorbed_w[surface.node] += heat_w;
        }
        self.flows.absorbed_w.copy_from_slice(absorbed_w);
        self.node_power_w.copy_from_slice(&self.absorbed_w);
    }

    /// Sets what surfaces radiate to from now on, and their emissivity, where they are given.
    pub fn set_sky(&mut self, temperature_k: Option<f64>, emissivity: Option<f64>) {
        self.sky_k = temperature_k.unwrap_or(self.sky_k);
        for surface in 0..self.parts.surfaces.len() {
            let of = &mut self.parts.surfaces[surface];
            of.emissivity = emissivity.unwrap_or(of.emissivity);
            self.set_emissivity_factor(surface, 1.0);
        }
    }

    /// The emissivity of a surface over its own from now on.
    pub fn set_emissivity_factor(&mut self, surface: usize, factor: f64) {
        let of = &self.parts.surfaces[surface];
        let coefficient_w_k4 = factor * of.emissivity * STEFAN_BOLTZMANN * of.area_m2;
        self.network.set_radiator(self.radiators[surface], coefficient_w_k4, self.sky_k);
    }

    /// The conductance of a surface to the gas over that of its law, from the next wind on.
    pub fn set_gain(&mut self, surface: usize, factor: f64) {
        self.gain[surface] = factor;
    }

    /// The conductance of a contact from now on.
    pub fn set_contact(&mut self, link: usize, conductance_w_k: f64) {
        self.network.set_link(link, conductance_w_k);
    }

    /// All rates of the inside may become so many times as fast.
    pub fn quicken(&mut self, factor: f64) {
        self.own_rate_per_s *= factor;
    }

    /// Spheres take the properties of the gas at film temperature.
    pub fn take_film_properties(&mut self) {
        self.parts.convection.iter_mut().filter_map(|(law, _)| law.sphere_mut()).for_each(|of| of.take_film());
    }

    pub fn set_local_wind(&mut self, local_wind: LocalWind) {
        self.local_wind = local_wind;
    }

    /// Lets the wind cool the rods that lead to the support; whether there are any.
    pub fn cool_stem(&mut self, of: Stem) -> bool {
        self.cooled_stem = CooledStem::new(of, &mut self.network, &self.parts.stem_ends, self.gas.temperature_k);
        self.cooled_stem.is_some()
    }
}
