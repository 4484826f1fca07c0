//! Names and words of what is refused.

extern crate std;

use super::*;
use std::collections::BTreeSet;
use std::format;
use std::string::{String, ToString};
use std::vec::Vec;

/// In the order of their declaration, which is the one on the wire.
const ALL: [Parameter; 85] = [
    Parameter::Resistance0cOhm,
    Parameter::CoefficientPerC,
    Parameter::VoltPerCode,
    Parameter::CurrentLowA,
    Parameter::CurrentHighA,
    Parameter::ResistanceMinOhm,
    Parameter::ResistanceMaxOhm,
    Parameter::TemperatureMaxC,
    Parameter::CodeMax,
    Parameter::RateRadS,
    Parameter::SamplePeriodS,
    Parameter::ResistanceKPerW,
    Parameter::ReferenceC,
    Parameter::PrbsOrder,
    Parameter::PrbsSeed,
    Parameter::TicksPerBit,
    Parameter::TargetC,
    Parameter::PowerW,
    Parameter::LowC,
    Parameter::HighC,
    Parameter::DwellTicks,
    Parameter::DecimatorRatio,
    Parameter::MissingLimitTicks,
    Parameter::UnreachableLimitTicks,
    Parameter::LeastReynolds,
    Parameter::MostReynolds,
    Parameter::NusseltMean,
    Parameter::NusseltFirst,
    Parameter::NusseltAmplitudes,
    Parameter::Axis,
    Parameter::Corner,
    Parameter::AreaM2,
    Parameter::SectorMeans,
    Parameter::SectorThreefold,
    Parameter::DiameterM,
    Parameter::DirectionErrorMaxRad,
    Parameter::DensityKgM3,
    Parameter::ViscosityPaS,
    Parameter::ConductivityWMK,
    Parameter::SurfaceShare,
    Parameter::CorrectionWPerK,
    Parameter::ConvectionWPerK,
    Parameter::ReadingWeight,
    Parameter::VarianceW2,
    Parameter::WindlessWK,
    Parameter::PartGain,
    Parameter::PartElement,
    Parameter::Parts,
    Parameter::OutputIntervalTicks,
    Parameter::ReferenceElement,
    Parameter::SmoothingS,
    Parameter::GasTemperatureC,
    Parameter::PressurePa,
    Parameter::GasConstantJKgK,
    Parameter::GasPolynomial,
    Parameter::NusseltPoint,
    Parameter::CrossHeating,
    Parameter::AlarmThresholdK,
    Parameter::UntilS,
    Parameter::GainSet,
    Parameter::CardMean,
    Parameter::CardDifference,
    Parameter::CardAnisotropy,
    Parameter::CardShare,
    Parameter::WindowS,
    Parameter::PulseS,
    Parameter::HostTimeoutS,
    Parameter::FingerprintOhm,
    Parameter::StuckLimitTicks,
    Parameter::SustainedPowerW,
    Parameter::EnergyJ,
    Parameter::CalibrationUncertainty,
    Parameter::FilmShare,
    Parameter::NusseltAtRest,
    Parameter::Buoyancy,
    Parameter::StemMap,
    Parameter::SurfaceCorrection,
    Parameter::FaradPerCode,
    Parameter::CurvatureFV2,
    Parameter::NegativeV,
    Parameter::PositiveV,
    Parameter::SecondShare,
    Parameter::CapacitanceMaxF,
    Parameter::ShiftMaxV,
    Parameter::GainPerTick,
];

/// The words of a variant, as they would be written in a file: `current_low_a` for `CurrentLowA`.
fn spelled(parameter: Parameter) -> String {
    let mut words = String::new();
    let mut length = 0;
    for letter in format!("{parameter:?}").chars() {
        // A power belongs to its unit: `m3`, `w2`.
        let begins = letter.is_ascii_uppercase() || (letter.is_ascii_digit() && length > 1);
        if begins && !words.is_empty() {
            words.push('_');
            length = 0;
        }
        words.push(letter.to_ascii_lowercase());
        length += 1;
    }
    words
}

/// Part of a name that says the unit.
fn unit(name: &str) -> Vec<&str> {
    const UNITS: [&str; 17] =
        ["a", "c", "j", "k", "kg", "m", "m2", "m3", "ohm", "pa", "per", "rad", "s", "ticks", "w", "w2", "code"];
    let mut unit: Vec<&str> = name.rsplit('_').take_while(|word| UNITS.contains(word)).collect();
    unit.reverse();
    unit
}

#[test]
fn the_list_is_whole() {
    for (place, parameter) in ALL.iter().enumerate() {
        assert_eq!(*parameter as usize, place, "{parameter:?}");
    }
    let declared = include_str!("../error.rs").split_once("pub enum Parameter {").unwrap().1;
    let (declared, _) = declared.split_once('}').unwrap();
    assert_eq!(declared.lines().filter(|line| line.trim_end().ends_with(',')).count(), ALL.len());
}

#[test]
fn every_name_is_its_own_and_says_the_unit_that_the_code_says() {
    let mut names = BTreeSet::new();
    for parameter in ALL {
        let name = parameter.name();
        assert!(name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_'), "{name}");
        assert!(!name.is_empty() && names.insert(name), "{parameter:?}: {name} is there twice");
        let spelled = spelled(parameter);
        assert_eq!(unit(name), unit(&spelled), "{parameter:?}: {name}");
    }
    assert_eq!(unit(Parameter::ResistanceKPerW.name()), ["k", "per", "w"]);
    assert_eq!(unit(Parameter::DensityKgM3.name()), ["kg", "m3"]);
    assert_eq!(unit(Parameter::PrbsOrder.name()), [""; 0]);
}

#[test]
fn a_refusal_names_what_is_wrong_and_what_would_be_right() {
    let said = |problem| ConfigError { parameter: Parameter::LowC, problem }.to_string();
    let between = said(ParameterProblem::OutOfRange { least: -1.5, most: 32.25 });
    assert_eq!(between, "`low_c` must lie between -1.5 and 32.25");
    assert!(said(ParameterProblem::NotAMultiple { of: 0.125 }).ends_with("multiple of 0.125"));
    let all = [
        between,
        said(ParameterProblem::NotAMultiple { of: 0.125 }),
        said(ParameterProblem::NotFinite),
        said(ParameterProblem::NotPositive),
        said(ParameterProblem::NotAscending),
        said(ParameterProblem::LockUp),
        said(ParameterProblem::Missing),
    ];
    for sentence in &all {
        assert!(sentence.starts_with("`low_c` ") && !sentence.ends_with('.'), "{sentence}");
    }
    assert_eq!(all.iter().collect::<BTreeSet<_>>().len(), all.len(), "each problem has words of its own");
}

#[test]
fn bounds_are_where_they_say() {
    let parameter = Parameter::PowerW;
    let problem = |outcome: Result<f32, ConfigError>| outcome.map_err(|error| error.problem);
    let next = |value: f32| f32::from_bits(value.to_bits() + 1);
    let (least, most) = (0.25, 4.0);
    let outside = Err(ParameterProblem::OutOfRange { least, most });
    assert_eq!(problem(within(parameter, least, least, most)), Ok(least));
    assert_eq!(problem(within(parameter, most, least, most)), Ok(most));
    assert_eq!(problem(within(parameter, f32::from_bits(least.to_bits() - 1), least, most)), outside);
    assert_eq!(problem(within(parameter, next(most), least, most)), outside);
    assert_eq!(problem(positive(parameter, 0.0)), Err(ParameterProblem::NotPositive));
    assert_eq!(problem(positive(parameter, next(0.0))), Ok(next(0.0)));
    for none in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let not_finite = Err(ParameterProblem::NotFinite);
        assert_eq!(problem(finite(parameter, none)), not_finite);
        assert_eq!(problem(positive(parameter, none)), not_finite);
        assert_eq!(problem(within(parameter, none, least, most)), not_finite);
        let pair = |low, high| ascending((Parameter::LowC, low), (Parameter::HighC, high));
        assert_eq!(
            pair(none, 1.0),
            Err(ConfigError { parameter: Parameter::LowC, problem: ParameterProblem::NotFinite })
        );
        assert_eq!(
            pair(1.0, none),
            Err(ConfigError { parameter: Parameter::HighC, problem: ParameterProblem::NotFinite })
        );
    }
    let pair = |low, high| ascending((Parameter::LowC, low), (Parameter::HighC, high));
    assert_eq!(pair(1.0, next(1.0)), Ok((1.0, next(1.0))));
    let same = ConfigError { parameter: Parameter::HighC, problem: ParameterProblem::NotAscending };
    assert_eq!(pair(1.0, 1.0), Err(same));
}
