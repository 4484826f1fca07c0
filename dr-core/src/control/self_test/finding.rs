//! Findings of a self-test for one element, and the bounds of a pass.

use crate::control::guard::Cause;
use core::fmt;
use strum::VariantArray;

/// Largest offset of a converter, as a part of what the low current gives on the element at 0 °C:
/// 0.1 K.
pub const OFFSET_MOST: f32 = 4e-4;
/// Largest error of the scale of the converter, from a known voltage of the front end.
pub const REFERENCE_ERROR_MOST: f32 = 0.03;
/// Largest noise of a reading at the low level, K rms: some twenty times that of the sensor board
/// at its fastest rate.
pub const NOISE_MOST_K: f32 = 0.1;
/// The measured response to a pulse over the expected one. Wind changes a short pulse by little; a
/// half-open lead or another element by much.
pub const RESPONSE: [f32; 2] = [0.7, 1.4];
/// Largest difference of the temperatures by the two levels, K: three times that of resistors of
/// 0.1 %, as bought.
pub const GAP_MOST_K: f32 = 1.0;
/// A rise is none if it is under so many standard errors.
pub const SIGNIFICANT: f32 = 5.0;

/// Finding for one element.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SelfTestFinding {
    /// Number of the element, from 0.
    pub element: u8,
    /// Number of elements tested.
    pub of: u8,
    /// Faults found.
    pub faults: SelfTestFaults,
    /// Voltage that is read with the inputs shorted, V, beyond what is taken off already; none if
    /// nothing was read.
    pub offset_v: Option<f32>,
    /// The front end's reference voltage, as read over what it should be; none if nothing was read.
    pub reference: Option<f32>,
    /// Why the element cannot be read.
    pub cause: Option<Cause>,
    /// Mean temperature at the low level, °C; none if it cannot be read.
    pub temperature_c: Option<f32>,
    /// Noise of a reading at the low level, K rms.
    pub noise_k: Option<f32>,
    /// Response to the pulse; none without a pulse.
    pub response: Option<PulseResponse>,
}

/// Response of an element to a pulse of heat.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PulseResponse {
    /// Rise between the first and the last reading at the high level, K.
    pub rise_k: f32,
    /// The same by the element's model, if it has one.
    pub expected_k: Option<f32>,
    /// Measured response over expected one, by least squares over the whole pulse; none without a
    /// model.
    pub ratio: Option<f32>,
    /// Excess of the high level's reading over the low one's, less what the model expects of the
    /// first tick, K; none without a model.
    pub gap_k: Option<f32>,
}

/// A set of faults.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SelfTestFaults(pub u16);

/// A fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, strum::IntoStaticStr, strum::VariantArray)]
#[strum(serialize_all = "kebab-case")]
#[repr(u8)]
pub enum SelfTestFault {
    /// The converter does not respond with its inputs shorted, or its offset is too large.
    Offset,
    /// It does not respond with its reference voltage, or the voltage is wrong.
    Reference,
    /// The element cannot be read: `cause` says why.
    Continuity,
    /// Its readings are too noisy.
    Noise,
    /// They do not change at all.
    Frozen,
    /// A pulse did not warm it, though its model says that it would.
    NoResponse,
    /// It warmed it by another amount than expected.
    Response,
    /// The two levels read different temperatures.
    Levels,
    /// The pulse warmed another element.
    Crossed,
    /// The test ended before it was through with this element.
    Interrupted,
}

impl SelfTestFault {
    /// Its name.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

impl SelfTestFaults {
    /// Adds one where something is so.
    pub(crate) const fn add_if(&mut self, is_so: bool, fault: SelfTestFault) {
        if is_so {
            self.0 |= 1 << fault as u8;
        }
    }

    /// Tells whether one is among them.
    pub const fn has(self, fault: SelfTestFault) -> bool {
        self.0 >> fault as u8 & 1 == 1
    }

    /// Tells whether there are none.
    pub const fn is_none(self) -> bool {
        self.0 == 0
    }

    /// Iterates over the faults.
    pub fn iter(self) -> impl Iterator<Item = SelfTestFault> {
        SelfTestFault::VARIANTS.iter().copied().filter(move |&fault| self.has(fault))
    }
}

impl fmt::Display for SelfTestFaults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_none() {
            return f.write_str("none");
        }
        for (i, fault) in self.iter().enumerate() {
            f.write_str(if i > 0 { ", " } else { "" })?;
            f.write_str(fault.name())?;
        }
        Ok(())
    }
}
