//! The windless network of a head: own and cross-heating from a merged model, and the board's configurations of it.
//!
//! | of the model | of the network |
//! |---|---|
//! | pair `power_w:a` → `temperature_c:a` | own heating of `a`: at most 8 rates, none negative if the head says that there are layers |
//! | pair `power_w:a` → `temperature_c:b` | cross-heating: at most 4 rates of any sign |
//! | offset of `temperature_c:a` | its temperature with no heating at all, °C |
//!
//! Elements with an outward normal have a surface and so a convection; the others are only held on their temperatures. An element that the
//! model does not have is not part of the network.

use dr_core::model::network::CROSS_ORDER;
use dr_core::model::{CrossConfig, FasterConfig, GainsConfig, ORDER, OwnConfig};

use super::kalman::{Filter, Plant, ReadingNoise, design};
use super::ladder::{Section, contact_time_s, cross_share, sections, share};
use super::quickness::quickness;
use super::trial::on_trial;
use crate::head::{Element, Head};
use crate::model::{Model, Pair, Structure};
use crate::recording::{POWER, TEMPERATURE};

/// How an element heats itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Own {
    /// Its place in the head.
    pub element: usize,
    pub name: String,
    pub rest_c: f64,
    pub mesh_rad_s: Vec<f64>,
    pub r_k_per_w: Vec<f64>,
    /// What lies between it and its surface.
    pub layers: Vec<Section>,
    /// m_k; `None` for an element that no wind cools.
    pub surface: Option<Vec<f64>>,
}

/// How an element heats another one, by their places in the head.
#[derive(Debug, Clone, PartialEq)]
pub struct Cross {
    pub from: usize,
    pub to: usize,
    pub mesh_rad_s: Vec<f64>,
    pub r_k_per_w: Vec<f64>,
    /// m_k of the surface of `from`.
    pub surface: Vec<f64>,
}

/// All of a head, in the head's order.
#[derive(Debug, Clone, PartialEq)]
pub struct Windless {
    pub own: Vec<Own>,
    pub cross: Vec<Cross>,
}

/// What the board is given, and how good it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Observer {
    /// Place in the head, and configuration.
    pub own: Vec<(usize, OwnConfig)>,
    pub cross: Vec<CrossConfig>,
    /// Quicker gains for the time after an alarm; none where the bandwidth is fixed.
    pub faster: Vec<FasterConfig>,
    /// Elements that were to have them and have none, and why: a sentence for each reason.
    pub not_quick: Vec<String>,
    /// By element as in `own`: the filter, with its bandwidth and its figures of noise.
    pub filters: Vec<Filter>,
    /// By element as in `own`: standard deviation of the convective power by the noise of readings, W; 0 without a surface.
    pub sd_w: Vec<f64>,
}

impl Windless {
    /// # Errors
    /// A sentence: which pair or element cannot be part of a windless network, and why.
    pub fn of(model: &Model, head: &Head) -> Result<Self, String> {
        if model.structure != Structure::Symbol {
            return Err("structure `conductance` has its wind inside; a windless network is made of structure `symbol`, from records in still gas".to_owned());
        }
        let [label] = &model.classes[..] else {
            return Err(format!(
                "the model has the classes {}: a windless network has one, still gas",
                model.classes.join(", ")
            ));
        };
        let mut own = Vec::new();
        for (element, of) in head.elements.iter().enumerate() {
            let (input, output) = (format!("{POWER}{}", of.name), format!("{TEMPERATURE}{}", of.name));
            let Some(pair) = model.pair(&input, &output) else { continue };
            let Some(offset) = model.outputs.iter().find(|known| known.name == output) else { continue };
            own.push(Own::of(pair, label, of, element, offset.offset_c)?);
        }
        if own.is_empty() {
            return Err(format!(
                "the model heats none of head `{}` and sees it become warm: its pairs must be named after {}",
                head.name,
                head.names().join(", ")
            ));
        }
        let mut cross = Vec::new();
        for from in &own {
            for to in own.iter().filter(|to| to.element != from.element) {
                let (input, output) = (format!("{POWER}{}", from.name), format!("{TEMPERATURE}{}", to.name));
                let pair = model.pair(&input, &output).ok_or_else(|| {
                    format!("the model does not say how `{}` heats `{}`: identify `{input}` with all temperatures as outputs", from.name, to.name)
                })?;
                let r_k_per_w = resistances(pair, label, CROSS_ORDER)?;
                let mesh_rad_s = pair.mesh_rad_s.clone();
                let surface = mesh_rad_s.iter().map(|&rate| cross_share(&from.layers, rate)).collect();
                cross.push(Cross { from: from.element, to: to.element, mesh_rad_s, r_k_per_w, surface });
            }
        }
        Ok(Self { own, cross })
    }

    /// Configurations for a sample period, with filters of one bandwidth. Noise is by element of the head.
    ///
    /// # Errors
    /// A sentence that names the element and what cannot be had.
    pub fn observer(
        &self,
        bandwidth_hz: f64,
        sample_period_s: f64,
        noise: &[ReadingNoise],
    ) -> Result<Observer, String> {
        let mut observer = Observer {
            own: Vec::new(),
            cross: Vec::new(),
            faster: Vec::new(),
            not_quick: Vec::new(),
            filters: Vec::new(),
            sd_w: Vec::new(),
        };
        for own in &self.own {
            let named = |sentence: String| format!("element `{}`: {sentence}", own.name);
            let noise = noise.get(own.element).ok_or_else(|| named("its readings' noise is not given".to_owned()))?;
            let filter = design(&own.plant(sample_period_s, *noise), bandwidth_hz).map_err(named)?;
            observer.own.push((own.element, own.config(&filter)));
            observer.sd_w.push(filter.noise_w);
            observer.filters.push(filter);
        }
        observer.cross = self.cross.iter().map(Cross::config).collect();
        Ok(observer)
    }

    /// The same, but quicker for a while after the wind has jumped; not so an element whose quick gains do not hold beside the network itself
    /// ([`trial`](super::trial)).
    ///
    /// # Errors
    /// As [`observer`](Self::observer).
    pub fn adaptive_observer(
        &self,
        bandwidth_hz: f64,
        sample_period_s: f64,
        noise: &[ReadingNoise],
    ) -> Result<Observer, String> {
        let mut observer = self.observer(bandwidth_hz, sample_period_s, noise)?;
        let mut too_noisy = Vec::new();
        for own in self.own.iter().filter(|own| own.surface.is_some()) {
            let Some((_, config)) = observer.own.iter_mut().find(|(element, _)| *element == own.element) else {
                continue;
            };
            let plant = own.plant(sample_period_s, noise[own.element]);
            let steady = design(&plant, bandwidth_hz)?;
            let Some(quickness) = quickness(&plant, &steady) else {
                too_noisy.push(own.name.as_str());
                continue;
            };
            config.alarm = Some(quickness.alarm);
            for (set, of) in (0_u8..).zip(&quickness.sets) {
                let gains = GainsConfig {
                    correction_w_per_k: padded(&of.correction_w_per_k, 0.0),
                    convection_w_per_k: of.convection_w_per_k as f32,
                    weights: config.gains.weights,
                    variance_w2: of.variance_w2 as f32,
                };
                let (element, until_s) = (own.element as u8, of.until_s as f32);
                observer.faster.push(FasterConfig { element, set, until_s, gains });
            }
        }
        let lost = on_trial(self, &mut observer, bandwidth_hz, sample_period_s);
        for (element, config) in &mut observer.own {
            if lost.contains(element) {
                config.alarm = None;
            }
        }
        let lost = self.own.iter().filter(|own| lost.contains(&own.element)).map(|own| own.name.as_str()).collect();
        for (names, why) in [
            (too_noisy, "nothing quicker is quiet enough"),
            (lost, "beside their own network quick gains do worse after a jump"),
        ] {
            if !names.is_empty() {
                observer.not_quick.push(format!("{}: {why}", names.join(", ")));
            }
        }
        Ok(observer)
    }
}

impl Observer {
    /// Whether an element of the head becomes quicker after a jump.
    pub fn is_quick(&self, place: usize) -> bool {
        self.faster.iter().any(|of| usize::from(of.element) == place)
    }
}

impl Own {
    fn of(pair: &Pair, label: &str, of: &Element, element: usize, rest_c: f64) -> Result<Self, String> {
        let r_k_per_w = resistances(pair, label, ORDER)?;
        let layers = sections(&pair.mesh_rad_s, &r_k_per_w, of.layers)
            .map_err(|sentence| format!("element `{}`: {sentence}", of.name))?;
        let shares = || pair.mesh_rad_s.iter().map(|&rate| share(&layers, rate)).collect();
        Ok(Self {
            element,
            name: of.name.clone(),
            rest_c,
            surface: of.normal.map(|_| shares()),
            mesh_rad_s: pair.mesh_rad_s.clone(),
            r_k_per_w,
            layers,
        })
    }

    /// By how much the surface lags behind the element, s.
    pub fn contact_time_s(&self) -> f64 {
        contact_time_s(&self.layers)
    }

    fn plant(&self, sample_period_s: f64, noise: ReadingNoise) -> Plant<'_> {
        Plant {
            mesh_rad_s: &self.mesh_rad_s,
            r_k_per_w: &self.r_k_per_w,
            surface: self.surface.as_deref(),
            sample_period_s,
            noise,
        }
    }

    fn config(&self, filter: &Filter) -> OwnConfig {
        let surface = self.surface.clone().unwrap_or_else(|| vec![1.0; self.mesh_rad_s.len()]);
        OwnConfig {
            mesh_rad_s: ascending(&self.mesh_rad_s),
            r_k_per_w: padded(&self.r_k_per_w, 0.0),
            surface: padded(&surface, 1.0),
            rest_c: self.rest_c as f32,
            gains: gains(filter),
            alarm: None,
        }
    }
}

fn gains(filter: &Filter) -> GainsConfig {
    GainsConfig {
        correction_w_per_k: padded(&filter.correction_w_per_k, 0.0),
        convection_w_per_k: filter.convection_w_per_k as f32,
        weights: filter.weights.map(|weight| weight as f32),
        variance_w2: (filter.noise_w * filter.noise_w) as f32,
    }
}

impl Cross {
    fn config(&self) -> CrossConfig {
        CrossConfig {
            // A head has 16 elements at most.
            from: self.from as u8,
            to: self.to as u8,
            mesh_rad_s: ascending(&self.mesh_rad_s),
            r_k_per_w: padded(&self.r_k_per_w, 0.0),
            surface: padded(&self.surface, 1.0),
        }
    }
}

/// R_k of a pair that the board can run.
fn resistances(pair: &Pair, label: &str, most: usize) -> Result<Vec<f64>, String> {
    let refuse = |sentence: String| Err(format!("pair {} → {} {sentence}", pair.input, pair.output));
    let Some(class) = pair.classes.get(label) else {
        return refuse(format!("has no class `{label}`"));
    };
    let rates = pair.mesh_rad_s.len();
    if rates > most {
        return refuse(format!("has {rates} rates, and the board carries {most} of it: identify it with --free-poles"));
    }
    if class.feed_through_k_per_w != 0.0 || pair.dead_time_samples != 0 {
        return refuse(
            "answers at once or late, which the board's network does not: identify it with --feed-through no --dead-time 0".to_owned(),
        );
    }
    Ok(class.r_k_per_w.clone())
}

fn padded<const K: usize>(values: &[f64], with: f32) -> [f32; K] {
    std::array::from_fn(|k| values.get(k).map_or(with, |&value| value as f32))
}

/// Rates without a resistance stand above the others, each twice the one before.
fn ascending<const K: usize>(rates: &[f64]) -> [f32; K] {
    let last = rates.last().copied().unwrap_or(1.0);
    std::array::from_fn(|k| match rates.get(k) {
        Some(&rate) => rate as f32,
        None => (last * 2f64.powi((k + 1 - rates.len()) as i32)) as f32,
    })
}

#[cfg(test)]
pub(crate) mod tests;
