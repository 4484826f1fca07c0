//! Who judges: from the readings that were given and the levels that came back, and from nothing
//! else.
//!
//! **The invariant.** A heater is at its high level only if a valid reading of its element younger
//! than two ticks was judged. Here: levels that stand after tick n may be high only for elements
//! whose reading of tick n, or of the tick before it if n was silent, is one that a resistor of
//! this head can have within its limits, at the level at which it was read. And never while the
//! instrument says that it does not run.

use dr_core::control::{Heaters, RunState};
use dr_core::sensor::Reading;
use host_sim::experiment::Experiment;
use host_sim::instrument::TickReport;

/// Element as the head's file states it.
#[derive(Debug, Clone, Copy)]
struct Element {
    resistance_0c_ohm: f64,
    /// Coefficient of a linear resistor; none for one by IEC 60751.
    coefficient_per_c: Option<f64>,
    current_low_a: f64,
    current_high_a: f64,
    least_ohm: f64,
    most_ohm: f64,
    most_c: f64,
}

/// The judge of one run.
pub struct Judge {
    elements: Vec<Element>,
    volt_per_code: f64,
    /// Levels since the last tick, which are those at which the next readings are taken.
    levels: Heaters,
    /// Ticks since a valid reading, by element.
    age_ticks: Vec<u32>,
}

/// Accuracy with which a temperature has to be told, K: f32 at the resistances and codes of these
/// heads.
const TOLD_WITHIN_K: f64 = 1e-3;

impl Element {
    /// The temperature at which it has a resistance, °C.
    fn temperature_c(&self, ohm: f64) -> f64 {
        let ratio = ohm / self.resistance_0c_ohm;
        if let Some(coefficient_per_c) = self.coefficient_per_c {
            return (ratio - 1.0) / coefficient_per_c;
        }
        // IEC 60751: R(t)/R(0) = 1 + A t + B t² + C (t − 100) t³, the last term below 0 °C only.
        // Rises over the whole range, hence by halves.
        let (mut low_c, mut high_c) = (-300.0, 1000.0);
        for _ in 0..60 {
            let c: f64 = 0.5 * (low_c + high_c);
            let cold = if c < 0.0 { -4.183e-12 * (c - 100.0) * c.powi(3) } else { 0.0 };
            let bound = if 1.0 + 3.9083e-3 * c - 5.775e-7 * c * c + cold < ratio { &mut low_c } else { &mut high_c };
            *bound = c;
        }
        low_c
    }
}

impl Judge {
    /// For the head of an experiment whose resistors are linear, or by IEC 60751.
    ///
    /// # Panics
    /// If the file says less than all.
    pub fn new(experiment: &Experiment) -> Self {
        let head: toml::Table = experiment.head.source.text.parse().expect("a head is TOML");
        let adc = head["adc"].as_table().expect("a head has an ADC");
        let number = |table: &toml::Table, key: &str| -> f64 {
            let value = &table[key];
            value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64)).expect("a number")
        };
        let elements = head["elements"].as_array().expect("a head has elements").iter().map(|element| {
            let kind = head["kinds"][element["kind"].as_str().expect("a name")].as_table().expect("a kind");
            let platinum = kind["platinum"].as_table().expect("a resistor");
            Element {
                resistance_0c_ohm: number(platinum, "resistance_0c_ohm"),
                coefficient_per_c: platinum.get("coefficient_per_c").map(|_| number(platinum, "coefficient_per_c")),
                current_low_a: number(kind, "current_low_a"),
                current_high_a: number(kind, "current_high_a"),
                least_ohm: number(kind, "resistance_min_ohm"),
                most_ohm: number(kind, "resistance_max_ohm"),
                most_c: number(kind, "temperature_max_c"),
            }
        });
        let elements: Vec<Element> = elements.collect();
        let bits = i32::from(number(adc, "bits") as u8);
        Self {
            age_ticks: vec![u32::MAX; elements.len()],
            elements,
            volt_per_code: number(adc, "full_scale_v") / 2_f64.powi(bits - 1),
            levels: Heaters(0),
        }
    }

    /// The temperature that a reading means, °C, if it is valid.
    fn valid_c(&self, i: usize, reading: Reading) -> Option<f64> {
        let Reading::Code(code) = reading else { return None };
        let of = &self.elements[i];
        let current_a = if self.levels.is_high(i) { of.current_high_a } else { of.current_low_a };
        let ohm = f64::from(code) * self.volt_per_code / current_a;
        let c = of.temperature_c(ohm);
        // On the very limit f32 may decide otherwise.
        let (some_ohm, some_k) = (1e-4 * ohm.abs(), 0.05);
        let is_valid = ohm > of.least_ohm - some_ohm && ohm < of.most_ohm + some_ohm && c < of.most_c + some_k;
        is_valid.then_some(c)
    }

    /// A tick with readings. Gives whether all of them were told as they are.
    ///
    /// # Panics
    /// If the invariant is broken.
    pub fn tick(&mut self, readings: &[Reading], told: &TickReport, what: &str) -> bool {
        let sample = &told.sample;
        let mut all_told = true;
        for i in 0..self.elements.len() {
            let valid_c = readings.get(i).and_then(|&reading| self.valid_c(i, reading));
            self.age_ticks[i] = if valid_c.is_some() { 0 } else { self.age_ticks[i].saturating_add(1) };
            let told_c = sample.temperature_c.get(i).copied().map(f64::from);
            all_told &= valid_c.zip(told_c).is_some_and(|(c, told_c)| (c - told_c).abs() < TOLD_WITHIN_K);
        }
        if sample.state != RunState::Running {
            assert_eq!(sample.heaters, Heaters(0), "{what}: {:?} with heaters on", sample.state);
        }
        self.levels_are(sample.heaters, what);
        all_told
    }

    /// A tick with readings of which only the levels are told.
    ///
    /// # Panics
    /// If the invariant is broken.
    pub fn levels_told(&mut self, readings: &[Reading], levels: Heaters, what: &str) {
        for i in 0..self.elements.len() {
            let is_valid = readings.get(i).is_some_and(|&reading| self.valid_c(i, reading).is_some());
            self.age_ticks[i] = if is_valid { 0 } else { self.age_ticks[i].saturating_add(1) };
        }
        self.levels_are(levels, what);
    }

    /// A tick without any.
    ///
    /// # Panics
    /// If the invariant is broken.
    pub fn silence(&mut self, levels: Heaters, what: &str) {
        self.age_ticks.iter_mut().for_each(|age| *age = age.saturating_add(1));
        self.levels_are(levels, what);
    }

    /// Heaters were lowered by a new start.
    pub const fn started_anew(&mut self) {
        self.levels = Heaters(0);
    }

    /// Levels at which the next readings are taken.
    pub const fn levels(&self) -> Heaters {
        self.levels
    }

    fn levels_are(&mut self, levels: Heaters, what: &str) {
        for (i, &age) in self.age_ticks.iter().enumerate() {
            assert!(!levels.is_high(i) || age < 2, "{what}: element {i} is heated by a reading {age} ticks old");
        }
        assert_eq!(levels.0 >> self.elements.len(), 0, "{what}: a heater is on that there is not");
        self.levels = levels;
    }
}
