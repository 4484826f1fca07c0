//! A head with the same elements heated in every mode, and what a mode comes to.

use anemometry::head::Head;
use host_sim::head_check::{GivenConditions, HeadConditions, check};
use host_sim::sensor::{BodySurvey, construction_of};
use recording::toml_file::FileError;

/// The wind before and after the step, m/s along −x.
pub const WINDS_M_S: [f64; 2] = [3.0, 6.0];
/// Number of slowest time constants that a run lasts before and after its step.
const TIME_CONSTANTS: f64 = 6.0;
/// Longest that it lasts, s.
const LONGEST_S: f64 = 7200.0;

/// Mode in which the elements are operated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OperatingMode {
    /// Constant temperature, by the thermal sigma-delta loop.
    Cta,
    /// Constant current.
    Cca,
    /// Constant mean power.
    Cpa,
}

impl OperatingMode {
    /// All three.
    pub const ALL: [Self; 3] = [Self::Cta, Self::Cca, Self::Cpa];

    /// Name in anemometry.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cta => "CTA",
            Self::Cca => "CCA",
            Self::Cpa => "CPA",
        }
    }
}

/// Figures of one mode on one head.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeFigures {
    /// The mode.
    pub mode: OperatingMode,
    /// Until r has made nine tenths of its change, s.
    pub response_s: f64,
    /// Rest of the change ten times as long after that of CTA, %.
    pub creep_percent: f64,
    /// Error of the speed by a gas 10 K warmer than believed, %.
    pub gas_percent: f64,
    /// Error of the speed by a support 10 K warmer, %.
    pub support_percent: f64,
}

/// A head with the same elements held in every mode.
pub struct ComparedHead {
    /// The head.
    pub head: Head,
    /// Gas and overheat.
    pub conditions: HeadConditions,
    /// Places of the elements that are heated.
    pub held: Vec<usize>,
    /// Power of every element at the first wind and the set-point, W.
    pub power_w: Vec<f64>,
    /// At the second wind, W.
    pub power_after_w: Vec<f64>,
    /// Time that a run lasts before and after its step, s.
    pub settle_s: f64,
    survey: BodySurvey,
}

impl ComparedHead {
    /// # Errors
    /// If the head cannot be simulated.
    pub fn new(head: Head, overheat_k: f64) -> Result<Self, FileError> {
        let report = check(&head, GivenConditions::default(), |conditions| conditions.overheat_k = overheat_k)?;
        let held: Vec<usize> = (0..head.elements.len()).filter(|&i| report.range.held[i]).collect();
        let construction = construction_of(&head)?.ok_or_else(|| head.source.refuse("body", "is missing"))?;
        let survey = report.conditions.survey(&head, &construction)?;
        let mut compared = Self {
            conditions: report.conditions,
            power_w: Vec::new(),
            power_after_w: Vec::new(),
            settle_s: (TIME_CONSTANTS * report.time_constants_s[0]).clamp(60.0, LONGEST_S).ceil(),
            held,
            survey,
            head,
        };
        compared.power_w = compared.needed_w(WINDS_M_S[0]);
        compared.power_after_w = compared.needed_w(WINDS_M_S[1]);
        Ok(compared)
    }

    /// Power of every element that holds the set-points in a wind, W.
    fn needed_w(&mut self, speed_m_s: f64) -> Vec<f64> {
        let set_point_c = self.conditions.set_point_c();
        let held = |i| self.held.contains(&i).then_some(set_point_c);
        let held_c: Vec<Option<f64>> = (0..self.head.elements.len()).map(held).collect();
        self.survey.operating_point([-speed_m_s, 0.0, 0.0], &held_c).power_w
    }
}
