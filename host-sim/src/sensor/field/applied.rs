//! Effects of the field on one body: checked, joined to its surfaces and elements, applied at the
//! start of every sample period.

use super::{DriftQuantity, ElementDrift, FieldEffects, GasProperties, LocalWind, Sun, SurfaceHeat};
use crate::sensor::body::ThermalBody;
use crate::sensor::construction::Construction;
use crate::sensor::error::{SensorError, require};
use crate::sensor::front_end::SimulatedFrontEnd;
use anemometry::gas::ZERO_CELSIUS_K;
use recording::text::suggest;

/// Effects of the field that change with time, joined to a body.
#[derive(Clone, Debug)]
pub struct AppliedField {
    heat: Vec<(usize, SurfaceHeat)>,
    sun: Option<Sun>,
    drifts: Vec<(ElementDrift, DriftTarget)>,
    absorbed_w: Vec<f64>,
}

/// Numbers of what drifts.
#[derive(Clone, Copy, Debug, PartialEq)]
enum DriftTarget {
    Resistance { element: usize },
    Gain { surface: usize },
    Emissivity { surface: usize },
    Contact { link: usize, conductance_w_k: f64 },
}

impl AppliedField {
    /// Sets what stays, and keeps what changes.
    ///
    /// # Errors
    /// Numbers that cannot be, names that the sensor has not, effects that its body cannot have.
    pub fn new(
        effects: &FieldEffects,
        construction: &Construction,
        body: &mut ThermalBody,
    ) -> Result<Self, SensorError> {
        let sphere = |key: &str| match body.has_sphere() {
            true => Ok(()),
            false => Err(refused(key, "is simulated for spheres only, and this head has none: leave it out")),
        };
        if let Some(sun) = &effects.sun {
            sphere("sun")?;
            sun.check()?;
        }
        if let Some(buoyancy) = &effects.buoyancy {
            sphere("buoyancy")?;
            buoyancy.check()?;
        }
        if effects.gas_properties == GasProperties::Film {
            sphere("gas.properties")?;
        }
        if let Some(stem) = &effects.stem {
            stem.check()?;
            if stem.wake.is_some() {
                sphere("stem.wake")?;
            }
        }
        let mut heat = Vec::with_capacity(effects.surface_heat.len());
        for (i, of) in effects.surface_heat.iter().enumerate() {
            let key = format!("surface_heat[{i}]");
            of.check(&key)?;
            heat.push((
                named(&body.surface_names().collect::<Vec<_>>(), &of.surface, &format!("{key}.surface"), "surface")?,
                of.clone(),
            ));
        }
        if let Some(sky) = &effects.sky {
            sky.check()?;
            body.set_sky(sky.temperature_c.map(|temperature_c| temperature_c + ZERO_CELSIUS_K), sky.emissivity);
        }
        let mut drifts = Vec::with_capacity(effects.drifts.len());
        for (i, drift) in effects.drifts.iter().enumerate() {
            let key = format!("drifts[{i}]");
            drift.check(&key)?;
            drifts.push((drift.clone(), target(drift, &key, construction, body)?));
        }
        // The product of all that rises bounds how fast contacts become.
        let upwards = drifts.iter().filter(|(drift, _)| drift.quantity == DriftQuantity::Contact);
        body.quicken(upwards.map(|(drift, _)| (1.0 + drift.change).max(1.0)).product());
        if effects.gas_properties == GasProperties::Film {
            body.take_film_properties();
        }
        body.set_local_wind(LocalWind { buoyancy: effects.buoyancy, stem: effects.stem });
        if let Some(stem) = effects.stem.filter(|stem| stem.is_cooled())
            && !body.cool_stem(stem)
        {
            return Err(refused("stem", "cools the rod to the support, and this head has none: leave it out"));
        }
        Ok(Self { heat, sun: effects.sun, drifts, absorbed_w: vec![0.0; body.surface_names().count()] })
    }

    /// The effects of a sample period that begins at this time.
    pub fn apply(&mut self, time_s: f64, body: &mut ThermalBody, front_end: &mut SimulatedFrontEnd) {
        if self.sun.is_some() || !self.heat.is_empty() {
            self.absorbed_w.fill(0.0);
            if let Some(sun) = &self.sun {
                body.lit_m2(sun.direction(time_s), &mut self.absorbed_w);
                let absorbed_w_m2 = sun.absorbed_w_m2();
                self.absorbed_w.iter_mut().for_each(|of| *of *= absorbed_w_m2);
            }
            for (surface, heat) in &self.heat {
                self.absorbed_w[*surface] += heat.at_w(time_s);
            }
            body.set_absorbed_w(&self.absorbed_w);
        }
        for (_, target) in &self.drifts {
            // Several drifts of one quantity multiply.
            let same = self.drifts.iter().filter(|(_, other)| other == target);
            let factor = same.map(|(drift, _)| drift.factor(time_s)).product();
            match *target {
                DriftTarget::Resistance { element } => front_end.set_resistance_factor(element, factor),
                DriftTarget::Gain { surface } => body.set_gain(surface, factor),
                DriftTarget::Emissivity { surface } => body.set_emissivity_factor(surface, factor),
                DriftTarget::Contact { link, conductance_w_k } => body.set_contact(link, factor * conductance_w_k),
            }
        }
    }
}

/// Target of a drift; an element's surface is the one that it heats.
fn target(
    drift: &ElementDrift,
    key: &str,
    construction: &Construction,
    body: &ThermalBody,
) -> Result<DriftTarget, SensorError> {
    let names: Vec<&str> = construction.elements().iter().map(|of| of.name.as_str()).collect();
    let element = named(&names, &drift.element, &format!("{key}.element"), "element")?;
    let refuse = |what: &str| {
        let sentence = format!("is `{}`, which {what}", drift.element);
        refused(&format!("{key}.element"), &sentence)
    };
    let surface =
        || body.surface_of(element).ok_or_else(|| refuse("heats no surface: only its `resistance` can drift"));
    Ok(match drift.quantity {
        DriftQuantity::Resistance => DriftTarget::Resistance { element },
        DriftQuantity::Gain => DriftTarget::Gain { surface: surface()? },
        DriftQuantity::Emissivity => {
            let surface = surface()?;
            let drifted = body.emissivity(surface) * (1.0 + drift.change);
            let expected = format!("so small that the emissivity, {drifted} with it, is 1 at most");
            require(drifted <= 1.0, &format!("{key}.change"), drift.change, &expected)?;
            DriftTarget::Emissivity { surface }
        }
        DriftQuantity::Contact => {
            let joined = body.contact(element, surface()?);
            let (link, conductance_w_k) =
                joined.ok_or_else(|| refuse("sits on its surface by no link of its own: its contact cannot drift"))?;
            DriftTarget::Contact { link, conductance_w_k }
        }
    })
}

/// Place of a name among others.
fn named(names: &[&str], name: &str, key: &str, what: &str) -> Result<usize, SensorError> {
    names.iter().position(|known| *known == name).ok_or_else(|| {
        let hint = suggest(name, names.iter().copied());
        refused(key, &format!("is `{name}`, which is no {what} of the head; {hint}"))
    })
}

fn refused(key: &str, sentence: &str) -> SensorError {
    SensorError::Number { key: key.to_owned(), sentence: sentence.to_owned() }
}
