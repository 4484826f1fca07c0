//! Kinds of slow errors.

use dr_core::wind::slow_errors::SurfaceCorrection;
use serde::Serialize;

/// What may be wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SlowErrorKind {
    /// Heat: sun, sky, leaks, drifts of R₀.
    Offsets,
    /// Gains: dust, coatings, contacts.
    Gains,
    /// Both.
    Both,
}

impl SlowErrorKind {
    /// As an option has it.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Offsets => "offsets",
            Self::Gains => "gains",
            Self::Both => "both",
        }
    }

    /// The kind that may be wrong in its place.
    pub const fn other(self) -> Option<Self> {
        match self {
            Self::Offsets => Some(Self::Gains),
            Self::Gains => Some(Self::Offsets),
            Self::Both => None,
        }
    }

    /// A correction without the uncertainty of what is sought anew.
    pub(super) const fn certain(self, of: SurfaceCorrection) -> SurfaceCorrection {
        SurfaceCorrection {
            offset_u_w: if matches!(self, Self::Gains) { of.offset_u_w } else { 0.0 },
            gain_u: if matches!(self, Self::Offsets) { of.gain_u } else { 0.0 },
            ..of
        }
    }
}
