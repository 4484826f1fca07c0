//! Why a configuration was refused: which parameter, and what would have been right.
//!
//! The error is plain data, so that the board can send it as it stands and the host can word it.

use core::fmt;

/// A parameter of a configuration, by the name that users see.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[allow(missing_docs)] // the names are the documentation
pub enum Parameter {
    Resistance0cOhm,
    CoefficientPerC,
    VoltPerCode,
    CurrentLowA,
    CurrentHighA,
    ResistanceMinOhm,
    ResistanceMaxOhm,
    TemperatureMaxC,
    CodeMax,
    RateRadS,
    SamplePeriodS,
    ResistanceKPerW,
    ReferenceC,
    PrbsOrder,
    PrbsSeed,
    TicksPerBit,
    TargetC,
    PowerW,
    LowC,
    HighC,
    DwellTicks,
    DecimatorRatio,
    MissingLimitTicks,
    UnreachableLimitTicks,
    LeastReynolds,
    MostReynolds,
    NusseltMean,
    NusseltFirst,
    NusseltAmplitudes,
    Axis,
    Corner,
    AreaM2,
    SectorMeans,
    SectorThreefold,
    DiameterM,
    DirectionErrorMaxRad,
    DensityKgM3,
    ViscosityPaS,
    ConductivityWMK,
    SurfaceShare,
    CorrectionWPerK,
    ConvectionWPerK,
    ReadingWeight,
    VarianceW2,
    WindlessWK,
    PartGain,
    PartElement,
    Parts,
    OutputIntervalTicks,
    ReferenceElement,
    SmoothingS,
    GasTemperatureC,
    PressurePa,
    GasConstantJKgK,
    GasPolynomial,
    NusseltPoint,
    CrossHeating,
    AlarmThresholdK,
    UntilS,
    GainSet,
    CardMean,
    CardDifference,
    CardAnisotropy,
    CardShare,
    WindowS,
    PulseS,
}

impl Parameter {
    /// The name in the files and on the wire, unit included.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Resistance0cOhm => "resistance_0c_ohm",
            Self::CoefficientPerC => "coefficient_per_c",
            Self::VoltPerCode => "volt_per_code",
            Self::CurrentLowA => "current_low_a",
            Self::CurrentHighA => "current_high_a",
            Self::ResistanceMinOhm => "resistance_min_ohm",
            Self::ResistanceMaxOhm => "resistance_max_ohm",
            Self::TemperatureMaxC => "temperature_max_c",
            Self::CodeMax => "code_max",
            Self::RateRadS => "rate_rad_s",
            Self::SamplePeriodS => "sample_period_s",
            Self::ResistanceKPerW => "r_k_per_w",
            Self::ReferenceC => "reference_c",
            Self::PrbsOrder => "order",
            Self::PrbsSeed => "seed",
            Self::TicksPerBit => "ticks_per_bit",
            Self::TargetC => "temperature_c",
            Self::PowerW => "power_w",
            Self::LowC => "low_c",
            Self::HighC => "high_c",
            Self::DwellTicks => "dwell_ticks",
            Self::DecimatorRatio => "ratio",
            Self::MissingLimitTicks => "missing_limit_ticks",
            Self::UnreachableLimitTicks => "unreachable_limit_ticks",
            Self::LeastReynolds => "least_reynolds",
            Self::MostReynolds => "most_reynolds",
            Self::NusseltMean => "nusselt_a0",
            Self::NusseltFirst => "nusselt_a1",
            Self::NusseltAmplitudes => "nusselt_amplitudes",
            Self::Axis => "axis",
            Self::Corner => "corner",
            Self::AreaM2 => "area_m2",
            Self::SectorMeans => "sector_means",
            Self::SectorThreefold => "sector_threefold",
            Self::DiameterM => "diameter_m",
            Self::DirectionErrorMaxRad => "direction_error_max_rad",
            Self::DensityKgM3 => "density_kg_m3",
            Self::ViscosityPaS => "viscosity_pa_s",
            Self::ConductivityWMK => "conductivity_w_m_k",
            Self::SurfaceShare => "surface_share",
            Self::CorrectionWPerK => "correction_w_per_k",
            Self::ConvectionWPerK => "convection_w_per_k",
            Self::ReadingWeight => "reading_weight",
            Self::VarianceW2 => "variance_w2",
            Self::WindlessWK => "windless_w_k",
            Self::PartGain => "gain",
            Self::PartElement => "part_element",
            Self::Parts => "parts",
            Self::OutputIntervalTicks => "output_interval_ticks",
            Self::ReferenceElement => "reference_element",
            Self::SmoothingS => "smoothing_s",
            Self::GasTemperatureC => "gas_temperature_c",
            Self::PressurePa => "pressure_pa",
            Self::GasConstantJKgK => "gas_constant_j_kg_k",
            Self::GasPolynomial => "gas_polynomial",
            Self::NusseltPoint => "nusselt_point",
            Self::CrossHeating => "cross_heating",
            Self::AlarmThresholdK => "threshold_k",
            Self::UntilS => "until_s",
            Self::GainSet => "set",
            Self::CardMean => "card_mean",
            Self::CardDifference => "card_difference",
            Self::CardAnisotropy => "card_anisotropy",
            Self::CardShare => "card_share",
            Self::WindowS => "window_s",
            Self::PulseS => "pulse_s",
        }
    }
}

/// What is wrong with a value, said as what would be right.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ParameterProblem {
    /// NaN or infinite.
    NotFinite,
    /// Zero or negative where only positive values make sense.
    NotPositive,
    /// Outside a closed interval.
    OutOfRange {
        /// Least value that is accepted.
        least: f32,
        /// Greatest value that is accepted.
        most: f32,
    },
    /// Not greater than the value before it (mesh rates, low and high of a pair).
    NotAscending,
    /// The all-ones word is the state from which a register with XNOR feedback never moves.
    LockUp,
    /// The hardware counts in steps of `of`.
    NotAMultiple {
        /// The step.
        of: f32,
    },
    /// It has to be given before.
    Missing,
}

/// A refused configuration.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ConfigError {
    /// Which parameter.
    pub parameter: Parameter,
    /// What is wrong with it.
    pub problem: ParameterProblem,
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.parameter.name();
        match self.problem {
            ParameterProblem::NotFinite => write!(f, "`{name}` must be a finite number"),
            ParameterProblem::NotPositive => write!(f, "`{name}` must be greater than zero"),
            ParameterProblem::OutOfRange { least, most } => write!(f, "`{name}` must lie between {least} and {most}"),
            ParameterProblem::NotAscending => write!(f, "`{name}` must be greater than the value before it"),
            ParameterProblem::LockUp => write!(f, "`{name}` must not be all ones: the register would stand still"),
            ParameterProblem::Missing => write!(f, "`{name}` has to be given before"),
            ParameterProblem::NotAMultiple { of } => write!(f, "`{name}` must be a whole multiple of {of}"),
        }
    }
}

impl core::error::Error for ConfigError {}

/// The value, if it is finite.
pub(crate) fn finite(parameter: Parameter, value: f32) -> Result<f32, ConfigError> {
    if value.is_finite() { Ok(value) } else { Err(ConfigError { parameter, problem: ParameterProblem::NotFinite }) }
}

/// The value, if it is finite and greater than zero.
pub(crate) fn positive(parameter: Parameter, value: f32) -> Result<f32, ConfigError> {
    if finite(parameter, value)? > 0.0 {
        Ok(value)
    } else {
        Err(ConfigError { parameter, problem: ParameterProblem::NotPositive })
    }
}

/// The value, if it is finite and between the bounds, which are included.
pub(crate) fn within(parameter: Parameter, value: f32, least: f32, most: f32) -> Result<f32, ConfigError> {
    if (least..=most).contains(&finite(parameter, value)?) {
        Ok(value)
    } else {
        Err(ConfigError { parameter, problem: ParameterProblem::OutOfRange { least, most } })
    }
}

/// The pair, if both are finite and the second is the greater.
pub(crate) fn ascending(first: (Parameter, f32), second: (Parameter, f32)) -> Result<(f32, f32), ConfigError> {
    let (low, high) = (finite(first.0, first.1)?, finite(second.0, second.1)?);
    if low < high {
        Ok((low, high))
    } else {
        Err(ConfigError { parameter: second.0, problem: ParameterProblem::NotAscending })
    }
}

#[cfg(test)]
mod tests;
