//! Slow errors of a recording, as corrections over its time.

use dr_core::wind::slow_errors::SurfaceCorrection;
use dr_core::wind::sphere::SECTORS;
use serde::Serialize;

use super::equations::corrections;
use super::kind::SlowErrorKind;
use super::smoother::{OverheatEquation, SlowEquation, SlowErrorsAt, SlowJump, SlowPrior};

/// Mean square from which on something has to be explained.
pub(super) const CONTRADICTED: f64 = 2.0;
/// χ² of differences of overheat from which on they show heat.
const SEEN: f64 = 4.0;

/// How a recording alternates, and how heat explains it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OverheatFinding {
    /// The higher and the lower overheat, K.
    pub overheat_k: [f64; 2],
    /// How many halves.
    pub halves: usize,
    /// χ² of the differences over their degrees of freedom, without and with heat.
    pub chi_square: [f64; 2],
    #[serde(skip)]
    pub(super) equations: Vec<OverheatEquation>,
}

/// Slow errors over a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldCorrection {
    /// What was sought.
    pub kind: SlowErrorKind,
    /// Size and quickness that were found.
    pub prior: SlowPrior,
    /// Where errors jump.
    pub jumps: Vec<SlowJump>,
    /// Slots with an equation.
    pub count: usize,
    /// Mean square of what the equations leave, in their own variances, without and with errors.
    pub chi_square: [f64; 2],
    /// What halves of alternating overheat say, if they do.
    pub overheats: Option<OverheatFinding>,
    pub(super) begin_s: f64,
    pub(super) slot_s: f64,
    pub(super) equations: Vec<Option<SlowEquation>>,
    pub(super) found: Vec<SlowErrorsAt>,
}

impl FieldCorrection {
    /// Whether most of the contradictions are gone with these errors.
    pub fn explains(&self) -> bool {
        let is_less = |[before, after]: [f64; 2], least: f64| before > least && after < 0.5 * before;
        match &self.overheats {
            Some(of) if self.kind == SlowErrorKind::Offsets => is_less(of.chi_square, SEEN),
            _ => is_less(self.chi_square, CONTRADICTED),
        }
    }

    /// Errors at the slots that have an equation, with their times, s.
    pub fn known(&self) -> impl Iterator<Item = (f64, &SlowErrorsAt)> {
        let slots = self.equations.iter().zip(&self.found).enumerate().filter(|(_, (equation, _))| equation.is_some());
        slots.map(|(place, (_, at))| (self.begin_s + (place as f64 + 0.5) * self.slot_s, at))
    }

    /// Errors at a time.
    pub fn at(&self, time_s: f64) -> Option<&SlowErrorsAt> {
        let place = ((time_s - self.begin_s) / self.slot_s).max(0.0) as usize;
        self.found.get(place).or_else(|| self.found.last())
    }

    /// Corrections at a time, on top of those with which the recording was gone through; these
    /// alone where the errors do not explain what contradicts. The uncertainty of what was found
    /// is not in them: [`Self::widen`] adds it.
    pub fn corrections(
        &self,
        time_s: f64,
        former: Option<&[SurfaceCorrection; SECTORS]>,
    ) -> [SurfaceCorrection; SECTORS] {
        let former = former.copied().unwrap_or_default();
        let Some(at) = self.at(time_s).filter(|_| self.explains()) else { return former };
        let found = corrections(at);
        core::array::from_fn(|i| found[i].on_top_of(&self.kind.certain(former[i])))
    }
}
