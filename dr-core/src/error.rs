//! Why a configuration was refused: which parameter, and what would have been right.
//!
//! The error is plain data, so that the board can send it as it stands and the host can word it.

/// A parameter of a configuration, by the name that users see.
#[derive(Debug, Clone, Copy, PartialEq, Eq, strum::IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[allow(missing_docs)] // the names are the documentation
pub enum Parameter {
    #[strum(to_string = "resistance_0c_ohm")]
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
    #[strum(to_string = "r_k_per_w")]
    ResistanceKPerW,
    ReferenceC,
    #[strum(to_string = "order")]
    PrbsOrder,
    #[strum(to_string = "seed")]
    PrbsSeed,
    TicksPerBit,
    #[strum(to_string = "temperature_c")]
    TargetC,
    PowerW,
    LowC,
    HighC,
    DwellTicks,
    #[strum(to_string = "ratio")]
    DecimatorRatio,
    MissingLimitTicks,
    UnreachableLimitTicks,
    LeastReynolds,
    MostReynolds,
    #[strum(to_string = "nusselt_a0")]
    NusseltMean,
    #[strum(to_string = "nusselt_a1")]
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
    #[strum(to_string = "conductivity_w_m_k")]
    ConductivityWMK,
    SurfaceShare,
    CorrectionWPerK,
    ConvectionWPerK,
    ReadingWeight,
    VarianceW2,
    #[strum(to_string = "windless_w_k")]
    WindlessWK,
    #[strum(to_string = "gain")]
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
    #[strum(to_string = "threshold_k")]
    AlarmThresholdK,
    UntilS,
    #[strum(to_string = "set")]
    GainSet,
    CardMean,
    CardDifference,
    CardAnisotropy,
    CardShare,
    WindowS,
    PulseS,
    HostTimeoutS,
    FingerprintOhm,
    StuckLimitTicks,
    SustainedPowerW,
    EnergyJ,
    CalibrationUncertainty,
    FilmShare,
    NusseltAtRest,
    Buoyancy,
    StemMap,
    SurfaceCorrection,
    FaradPerCode,
    #[strum(to_string = "curvature_f_v2")]
    CurvatureFV2,
    NegativeV,
    PositiveV,
    SecondShare,
    CapacitanceMaxF,
    ShiftMaxV,
    GainPerTick,
}

impl Parameter {
    /// The name in the files and on the wire, unit included.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// Fault of a value, said as what would be right.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ParameterProblem {
    /// NaN or infinite.
    #[error("must be a finite number")]
    NotFinite,
    /// Zero or negative where only positive values make sense.
    #[error("must be greater than zero")]
    NotPositive,
    /// Outside a closed interval.
    #[error("must lie between {least} and {most}")]
    OutOfRange {
        /// Least value that is accepted.
        least: f32,
        /// Greatest value that is accepted.
        most: f32,
    },
    /// Not greater than the value before it (mesh rates, low and high of a pair).
    #[error("must be greater than the value before it")]
    NotAscending,
    /// The all-ones word is the state from which a register with XNOR feedback never moves.
    #[error("must not be all ones: the register would stand still")]
    LockUp,
    /// The hardware counts in steps of `of`.
    #[error("must be a whole multiple of {of}")]
    NotAMultiple {
        /// The step.
        of: f32,
    },
    /// It has to be given before.
    #[error("has to be given before")]
    Missing,
}

/// A refused configuration.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[error("`{}` {problem}", parameter.name())]
pub struct ConfigError {
    /// Parameter.
    pub parameter: Parameter,
    /// Fault.
    pub problem: ParameterProblem,
}

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
        Err(out_of_range(parameter, least, most))
    }
}

/// A value that does not lie between the bounds.
pub(crate) const fn out_of_range(parameter: Parameter, least: f32, most: f32) -> ConfigError {
    ConfigError { parameter, problem: ParameterProblem::OutOfRange { least, most } }
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
