//! The prediction of a whole experiment, tick by tick: the limit of infinitely fast sampling, and
//! the real one-bit rule beside it.
//!
//! In the limit a regulated element is at any moment on its surface, with the equivalent control as
//! its power (thesis 2.54–2.55: a product of matrix exponentials as the wind changes), or on its
//! way there under one level: heating up, cooling down, or because the wind needs more or less
//! power than a level gives. It leaves the surface when u_eq passes a level, and meets it again at
//! a moment found within its tick. The sampled loop is the same model under dr-core's own drives,
//! which decide once a tick.

use dr_core::control::Drive;
use dr_core::control::drive::{DriveInput, DriveState};
use dr_core::sensor::Level;
use nalgebra::DVector;

use super::scenario::{Heated, Heater, Scenario};
use super::system::{Motion, System};
use crate::model::{Model, ModelError};

/// Secant steps towards a meeting with the surface.
const STEPS: usize = 60;

/// State that the model begins with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoopStart {
    /// Nothing was ever heated.
    Rest,
    /// Every element has long been at its low level in the first wind, as an instrument that stands
    /// by.
    Standby,
    /// State at the end of the model's record.
    End,
}

/// One element over all ticks.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PredictedElement {
    /// Name of the element.
    pub name: String,
    /// It has a set-point.
    pub regulated: bool,
    /// Power at t_n in the limit, W.
    pub limit_w: Vec<f64>,
    /// The element was on its surface for the whole tick.
    pub held: Vec<bool>,
    /// Power over the tick under the one-bit rule, W.
    pub sampled_w: Vec<f64>,
    /// Temperature at t_n under the one-bit rule, °C.
    pub sampled_c: Vec<f64>,
    /// Set-point of every tick, °C; none where it is not regulated.
    pub target_c: Vec<f64>,
    /// Moment in s at which the surface was first met; `None` if never.
    pub first_met_s: Option<f64>,
}

impl PredictedElement {
    /// Stretches of ticks off the surface, after it was first met: first tick, one past the last.
    pub fn saturated(&self) -> Vec<(usize, usize)> {
        let Some(first) = self.held.iter().position(|held| *held) else { return Vec::new() };
        let mut found = Vec::new();
        let mut at = first;
        for stretch in self.held[first..].chunk_by(|a, b| a == b) {
            if !stretch[0] {
                found.push((at, at + stretch.len()));
            }
            at += stretch.len();
        }
        found
    }
}

/// A prediction.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// Length of a tick, s.
    pub sample_period_s: f64,
    /// Class of the wind at every tick.
    pub class: Vec<usize>,
    /// One an element, as in the scenario.
    pub elements: Vec<PredictedElement>,
}

/// Motions over one tick that were needed so far, by wind and mask of held elements.
struct Motions<'a> {
    system: &'a System,
    period_s: f64,
    known: Vec<((usize, usize), Motion)>,
}

impl Motions<'_> {
    fn of(&mut self, class: usize, mask: usize) -> Result<usize, ModelError> {
        if let Some(at) = self.known.iter().position(|(key, _)| *key == (class, mask)) {
            return Ok(at);
        }
        self.known.push(((class, mask), self.system.motion(class, mask, self.period_s)?));
        Ok(self.known.len() - 1)
    }
}

/// Predicts a scenario.
///
/// # Errors
/// What the model lacks.
pub fn predict(model: &Model, scenario: &Scenario, start: LoopStart) -> Result<Prediction, ModelError> {
    let mut system = System::new(model, scenario.gas_c)?;
    let (inputs, drives) = (system.elements(), scenario.elements.len());
    refuse_if!(inputs != drives, model_error!("the model has {inputs} inputs, and {drives} drives were given"));
    let z = match start {
        LoopStart::Rest => DVector::zeros(system.order()),
        LoopStart::Standby => standing_by(&system, scenario)?,
        LoopStart::End => system.end(model)?,
    };
    let mut motions = Motions { system: &system, period_s: scenario.sample_period_s, known: Vec::new() };
    let class = scenario.classes();
    let mut elements: Vec<PredictedElement> = (scenario.elements.iter())
        .map(|heated| PredictedElement {
            name: heated.name.clone(),
            regulated: heated.drive.target_range_c().is_some(),
            ..PredictedElement::default()
        })
        .collect();
    for (_, class) in &scenario.winds {
        for (i, of) in elements.iter().enumerate().filter(|(_, of)| of.regulated) {
            let label = &model.classes[*class];
            let named = |error| model_error!("the model of {}, class `{label}`, {error}", of.name);
            system.check_surface(*class, i).map_err(named)?;
        }
    }
    sampled(&mut motions, scenario, &class, z.clone(), &mut elements)?;
    limit(&mut motions, scenario, &class, z, &mut elements)?;
    if let Some(bad) = elements.iter().find(|of| of.limit_w.iter().chain(&of.sampled_w).any(|w| !w.is_finite())) {
        let name = &bad.name;
        return Err(model_error!("the power of {name} grows without bounds: the model is unstable under this loop"));
    }
    Ok(Prediction { sample_period_s: scenario.sample_period_s, class, elements })
}

fn standing_by(system: &System, scenario: &Scenario) -> Result<DVector<f64>, ModelError> {
    let first = scenario.winds.first().map_or(0, |(_, class)| *class);
    let mut z = DVector::zeros(system.order());
    let mut taken = vec![0.0; system.elements()];
    // A resistor's power depends on its temperature, a little, and so do losses.
    for _ in 0..20 {
        system.taken_w(&z, &mut taken);
        let low = |(i, heated): (usize, &Heated)| heated.heater.levels_w(system.temperature_c(&z, i)).0 - taken[i];
        let power: Vec<f64> = scenario.elements.iter().enumerate().map(low).collect();
        z = system.steady_state(first, &power)?;
    }
    Ok(z)
}

/// Each drive's state at its start; the resistor's range is the instrument's to judge.
fn drive_states(scenario: &Scenario) -> Result<Vec<DriveState>, ModelError> {
    let range = |heated: &Heated| match &heated.heater {
        Heater::Resistor(channel) => channel.platinum().range_c(),
        Heater::Fixed { .. } => (f32::MIN, f32::MAX),
    };
    let state = |heated: &Heated| {
        let state = heated.drive.start(range(heated));
        state.map_err(|error| model_error!("{}: {error}", heated.name))
    };
    scenario.elements.iter().map(state).collect()
}

fn sampled(
    motions: &mut Motions<'_>,
    scenario: &Scenario,
    class: &[usize],
    mut z: DVector<f64>,
    elements: &mut [PredictedElement],
) -> Result<(), ModelError> {
    let mut drives = drive_states(scenario)?;
    let mut scratch = z.clone();
    let (mut power, mut taken) = (vec![0.0; elements.len()], vec![0.0; elements.len()]);
    for &class in class {
        motions.system.taken_w(&z, &mut taken);
        for (i, of) in elements.iter_mut().enumerate() {
            let temperature_c = motions.system.temperature_c(&z, i);
            let heated = &scenario.elements[i];
            let levels = heated.heater.levels_w(temperature_c);
            let given_w = of_level(decide(&heated.drive, &mut drives[i], temperature_c, levels), levels);
            power[i] = given_w - taken[i];
            of.sampled_w.push(given_w);
            of.sampled_c.push(temperature_c);
        }
        let at = motions.of(class, 0)?;
        motions.known[at].1.advance(&mut z, &power, &mut scratch);
    }
    Ok(())
}

fn decide(drive: &Drive, state: &mut DriveState, temperature_c: f64, levels_w: (f64, f64)) -> Level {
    let input = DriveInput { measured: temperature_c as f32, low: levels_w.0 as f32, high: levels_w.1 as f32 };
    drive.step(state, &input)
}

/// Mode of a regulated element in the limit.
#[derive(Debug, Clone, Copy, PartialEq)]
enum ElementMode {
    /// Heated as its drive says; not regulated.
    Given,
    Held,
    Under(Level),
}

fn limit(
    motions: &mut Motions<'_>,
    scenario: &Scenario,
    classes: &[usize],
    mut z: DVector<f64>,
    elements: &mut [PredictedElement],
) -> Result<(), ModelError> {
    let system = motions.system;
    let count = elements.len();
    let mut drives = drive_states(scenario)?;
    let mut modes = vec![ElementMode::Given; count];
    let mut targets = vec![f64::NAN; count];
    // Powers and levels are what is left of them once growing losses have taken theirs.
    let (mut power, mut levels, mut taken) = (vec![0.0; count], vec![(0.0, 0.0); count], vec![0.0; count]);
    let (mut scratch, mut before) = (z.clone(), z.clone());
    let mut off = vec![false; count];
    for (tick, &class) in classes.iter().enumerate() {
        system.taken_w(&z, &mut taken);
        for i in 0..count {
            let temperature_c = system.temperature_c(&z, i);
            let heated = &scenario.elements[i];
            let (low_w, high_w) = heated.heater.levels_w(temperature_c);
            let level = decide(&heated.drive, &mut drives[i], temperature_c, (low_w, high_w));
            levels[i] = (low_w - taken[i], high_w - taken[i]);
            match heated.drive {
                Drive::Temperature { .. }
                | Drive::SecondOrder { .. }
                | Drive::Setpoints { .. }
                | Drive::Alternation { .. } => {
                    let target_c = f64::from(drives[i].target_c);
                    if target_c != targets[i] {
                        targets[i] = target_c;
                        modes[i] = ElementMode::Under(if temperature_c < target_c { Level::High } else { Level::Low });
                    }
                    elements[i].target_c.push(target_c);
                }
                Drive::Power { power_w } => power[i] = f64::from(power_w) - taken[i],
                Drive::Passive | Drive::Level(_) | Drive::Prbs { .. } => power[i] = of_level(level, levels[i]),
            }
        }
        let mut left_s = scenario.sample_period_s;
        off.fill(false);
        // Each pass ends the tick or meets a surface; elements that meet one and leave it again at
        // once are let go with the tick.
        for pass in 0..=2 * count {
            let at = settle_modes(motions, class, &z, &mut modes, &mut power, &levels)?;
            for i in 0..count {
                off[i] |= modes[i] != ElementMode::Held;
                if pass == 0 {
                    elements[i].limit_w.push(power[i] + taken[i]);
                }
            }
            let own;
            let motion = if pass == 0 {
                &motions.known[at].1
            } else {
                own = system.motion(class, mask(&modes), left_s)?;
                &own
            };
            before.copy_from(&z);
            motion.advance(&mut z, &power, &mut scratch);
            let met = (0..count).find(|&i| passed(modes[i], || system.temperature_c(&z, i), targets[i]));
            let (Some(i), true) = (met, pass < 2 * count) else { break };
            let meeting_s = meeting(system, (class, mask(&modes)), (&before, i, targets[i]), left_s, &power)?;
            z.copy_from(&before);
            system.motion(class, mask(&modes), meeting_s)?.advance(&mut z, &power, &mut scratch);
            let now_s = (tick + 1) as f64 * scenario.sample_period_s - left_s + meeting_s;
            elements[i].first_met_s.get_or_insert(now_s);
            modes[i] = ElementMode::Held;
            left_s -= meeting_s;
            if left_s <= 0.0 {
                break;
            }
        }
        for (of, off) in elements.iter_mut().zip(&off) {
            of.held.push(!off);
        }
    }
    Ok(())
}

fn of_level(level: Level, (low_w, high_w): (f64, f64)) -> f64 {
    match level {
        Level::Low => low_w,
        Level::High => high_w,
    }
}

fn mask(modes: &[ElementMode]) -> usize {
    modes.iter().enumerate().filter(|(_, mode)| **mode == ElementMode::Held).map(|(i, _)| 1 << i).sum()
}

/// Lets go of held elements whose equivalent control is beyond a level (thesis 2.47), and works out
/// all powers.
fn settle_modes(
    motions: &mut Motions<'_>,
    class: usize,
    z: &DVector<f64>,
    modes: &mut [ElementMode],
    power: &mut [f64],
    levels: &[(f64, f64)],
) -> Result<usize, ModelError> {
    loop {
        for (i, mode) in modes.iter().enumerate() {
            if let ElementMode::Under(level) = mode {
                power[i] = of_level(*level, levels[i]);
            }
        }
        let at = motions.of(class, mask(modes))?;
        motions.known[at].1.equivalent_w(z, power);
        let beyond = (0..modes.len()).find(|&i| {
            let (low_w, high_w) = levels[i];
            modes[i] == ElementMode::Held && !(low_w..=high_w).contains(&power[i])
        });
        let Some(i) = beyond else { return Ok(at) };
        modes[i] = ElementMode::Under(if power[i] > levels[i].1 { Level::High } else { Level::Low });
    }
}

/// Tells whether an element under a level has come to its set-point from the side from which that
/// level leads there.
fn passed(mode: ElementMode, temperature_c: impl Fn() -> f64, target_c: f64) -> bool {
    match mode {
        ElementMode::Under(Level::High) => temperature_c() >= target_c,
        ElementMode::Under(Level::Low) => temperature_c() <= target_c,
        ElementMode::Given | ElementMode::Held => false,
    }
}

/// When, within `within_s`, element `i` comes to its target: by secants that keep their bracket, to
/// 1e-12 of it.
fn meeting(
    system: &System,
    (class, mask): (usize, usize),
    (before, i, target_c): (&DVector<f64>, usize, f64),
    within_s: f64,
    power: &[f64],
) -> Result<f64, ModelError> {
    let mut scratch = before.clone();
    let mut distance_at = |time_s: f64| -> Result<f64, ModelError> {
        let mut z = before.clone();
        system.motion(class, mask, time_s)?.advance(&mut z, power, &mut scratch);
        Ok(system.temperature_c(&z, i) - target_c)
    };
    let (mut from, mut to) = ((0.0, system.temperature_c(before, i) - target_c), (within_s, distance_at(within_s)?));
    if from.1 * to.1 >= 0.0 {
        // It begins on its target to rounding.
        return Ok(0.0);
    }
    for _ in 0..STEPS {
        let time_s: f64 = from.0 - from.1 * (to.0 - from.0) / (to.1 - from.1);
        let distance = distance_at(time_s)?;
        if distance == 0.0 || (time_s - from.0).abs().min((to.0 - time_s).abs()) < 1e-12 * within_s {
            return Ok(time_s);
        }
        // The Illinois rule: an end that stays counts half.
        if distance * to.1 < 0.0 {
            from = to;
        } else {
            from.1 *= 0.5;
        }
        to = (time_s, distance);
    }
    Ok(to.0)
}

#[cfg(test)]
mod tests;
