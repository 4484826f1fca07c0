//! Heads of two hemispheres and of four dice answer as their inverses do, and a head that is not
//! whole is refused.

use super::balance::{ELEMENTS, GAS_C, PERIOD_S, WIND_M_S, config, follow, gas, gas_there, power_of, told_of};
use super::*;
use crate::error::{Parameter, ParameterProblem};
use crate::wind::card_inverse::{CONDUCTION, KNOTS, TERMS};
use crate::wind::nusselt::POINTS;
use crate::wind::tests::cards::{MOST_REYNOLDS, SIDE_M, dice};
use crate::wind::{Card, CardConfig};

/// A layer that goes as √Re, of which the dice upstream have a tenth more.
fn card() -> CardConfig {
    let root = |k: usize| k as f32 * MOST_REYNOLDS.sqrt() / (KNOTS - 1) as f32;
    let (mut along, mut around, mut seen) = ([0.0; TERMS], [0.0; TERMS], [0.0; TERMS]);
    (along[1], around[0], seen[0], seen[1]) = (0.8, 0.9, 0.8, -0.1);
    CardConfig {
        mean: core::array::from_fn(|k| CONDUCTION + root(k)),
        difference: core::array::from_fn(|k| 0.1 * root(k)),
        along,
        around,
        seen,
        mean_share: 0.01,
        difference_share: 0.005,
    }
}

/// The answer of a head that stands in balance with these conductances.
fn told(mut anemometer: Anemometer<ELEMENTS>, config: &WindOutputConfig, conductance_w_k: &[f32]) -> WindTick {
    anemometer.handle(&WindCommand::Output(*config), PERIOD_S).unwrap();
    anemometer.handle(&gas(Some(GAS_C)), PERIOD_S).unwrap();
    let power_w = power_of(conductance_w_k);
    let tick = Tick { power_w, ..balance::tick(0) };
    anemometer.step(&tick, |element, _| power_w[element]).unwrap()
}

#[test]
fn two_hemispheres_determine_the_wind_along_their_axis() {
    let surfaces = sphere::hemispheres(DIAMETER_M);
    let head = WindVector::new(HeadForm::Sphere, &nusselt(), &surfaces, DIAMETER_M, 0.5).unwrap();
    let given = head.conductances(&gas_there(), WIND_M_S).map(|of| of.conductance_w_k);
    let told = told(told_of(&surfaces), &WindOutputConfig { surfaces: 2, ..config() }, &given);
    assert_eq!(told.surfaces, 2);
    assert!((0..2).all(|part| (told.conductance_w_k[part] / given[part] - 1.0).abs() < 1e-4), "{told:?}");
    assert_eq!(told.conductance_w_k[2..], [0.0; MOST_SURFACES - 2]);
    assert!(
        told.quality_flags.has(QualityFlags::UNDETERMINED) && !told.quality_flags.has(QualityFlags::FAILED),
        "{}",
        told.quality_flags
    );
    assert!((told.wind.wind_m_s[0] - WIND_M_S[0]).abs() < 5e-3, "{:?}", told.wind);
    let speed_m_s = WIND_M_S.iter().map(|v| v * v).sum::<f32>().sqrt();
    assert!((told.wind.speed_m_s - speed_m_s).abs() < 5e-3, "{:?}", told.wind);
}

#[test]
fn four_dice_determine_the_wind_in_their_plane() {
    let head = Card::new(&card(), &dice(), SIDE_M, MOST_REYNOLDS, 0.5).unwrap();
    // The part of it that lies in the plane is all that counts. A millimetre of die in thin gas: a
    // small Re, so a strong wind.
    let wind_m_s = [30.0, -40.0, 0.0];
    let given = head.conductances_w_k(&gas_there(), wind_m_s);
    let mut anemometer = told_of(&dice());
    anemometer.handle(&WindCommand::Card(card()), PERIOD_S).unwrap();
    let config = WindOutputConfig { diameter_m: SIDE_M, reynolds: Some([1.0, MOST_REYNOLDS]), ..config() };
    let told = told(anemometer, &config, &given);
    // See above: a rounding of 0.4 µW, here of some 0.1 mW/K.
    let of = told.conductance_w_k.iter().zip(given);
    assert!(of.clone().all(|(found, given)| (found - given).abs() < 5e-8), "{told:?} {given:?}");
    assert!(
        !told.quality_flags.has(QualityFlags::FAILED) && told.quality_flags.has(QualityFlags::UNDETERMINED),
        "{}",
        told.quality_flags
    );
    // The differences of the dice are a tenth of what they lose, and the rounding weighs the more.
    assert!(off(told.wind.wind_m_s, wind_m_s) < 0.1, "{:?}", told.wind);
}

/// Parameter of a set-up that is refused, and why.
fn refused(anemometer: &mut Anemometer<ELEMENTS>, command: WindCommand) -> (Parameter, ParameterProblem) {
    let before = anemometer.clone();
    let error = anemometer.handle(&command, PERIOD_S).unwrap_err();
    assert_eq!(*anemometer, before, "what is refused changes nothing");
    (error.parameter, error.problem)
}

#[test]
fn an_answer_wants_a_whole_head() {
    let surfaces = sphere::tetrahedral_sectors(DIAMETER_M);
    let answer = |config| WindCommand::Output(config);
    let missing = |parameter| (parameter, ParameterProblem::Missing);
    assert_eq!(refused(&mut told_of(&surfaces[..3]), answer(config())), missing(Parameter::Parts));
    assert_eq!(refused(&mut Anemometer::default(), answer(config())), missing(Parameter::Parts));

    // Every point but the last, and no gas.
    let mut anemometer = Anemometer::<ELEMENTS>::default();
    for element in 0..4_u8 {
        anemometer.handle(&WindCommand::SelfHeating { element, config: balance::own(0) }, PERIOD_S).unwrap();
        let config = HeadSurface { element, surface: surfaces[usize::from(element)], gain: 1.0, windless_w_k: 0.0 };
        anemometer.handle(&WindCommand::Surface { surface: element, config }, PERIOD_S).unwrap();
    }
    assert_eq!(refused(&mut anemometer, answer(config())), missing(Parameter::GasPolynomial));
    anemometer.handle(&WindCommand::GasLaw(law()), PERIOD_S).unwrap();
    for (point, amplitudes) in (0_u8..).zip(nusselt().amplitudes) {
        assert_eq!(refused(&mut anemometer, answer(config())), missing(Parameter::NusseltPoint), "point {point}");
        anemometer.handle(&WindCommand::NusseltPoint { point, amplitudes }, PERIOD_S).unwrap();
    }
    anemometer.handle(&answer(config()), PERIOD_S).unwrap();
    assert!(anemometer.output.is_some());
    // A point given again is not one taken away.
    let again = WindCommand::NusseltPoint { point: 5, amplitudes: nusselt().amplitudes[5] };
    anemometer.handle(&again, PERIOD_S).unwrap();
    anemometer.handle(&answer(config()), PERIOD_S).unwrap();
}

#[test]
fn a_sphere_has_two_parts_at_least_and_a_card_has_four() {
    let sphere = || told_of(&sphere::tetrahedral_sectors(DIAMETER_M));
    let surfaces = |surfaces| WindCommand::Output(WindOutputConfig { surfaces, ..config() });
    let wrong = |least, most| (Parameter::Parts, ParameterProblem::OutOfRange { least, most });
    for number in [0, 1] {
        assert_eq!(refused(&mut sphere(), surfaces(number)), wrong(2.0, MOST_SURFACES as f32), "{number}");
    }
    let mut card_of = told_of(&dice());
    card_of.handle(&WindCommand::Card(card()), PERIOD_S).unwrap();
    for number in [0, 2, 3] {
        assert_eq!(refused(&mut card_of, surfaces(number)), wrong(4.0, 4.0), "{number}");
    }
    // Without calibration any number will do.
    let config = WindOutputConfig { surfaces: 3, reynolds: None, ..config() };
    let mut anemometer = sphere();
    anemometer.handle(&WindCommand::Output(config), PERIOD_S).unwrap();
    assert_eq!(follow(&mut anemometer, &balance::tick(0)).unwrap().surfaces, 3);
}

#[test]
fn what_is_out_of_its_bounds_is_refused_by_name() {
    let mut head = told_of(&sphere::tetrahedral_sectors(DIAMETER_M));
    let surface = sphere::tetrahedral_sectors(DIAMETER_M)[0];
    let part = |change: &dyn Fn(&mut HeadSurface)| {
        let mut config = HeadSurface { element: 0, surface, gain: 1.0, windless_w_k: 0.0 };
        change(&mut config);
        WindCommand::Surface { surface: 0, config }
    };
    let answer = |change: &dyn Fn(&mut WindOutputConfig)| {
        let mut config = config();
        change(&mut config);
        WindCommand::Output(config)
    };
    let at = |pressure_pa, temperature_c| WindCommand::Gas { pressure_pa, temperature_c };
    let range = |least, most| ParameterProblem::OutOfRange { least, most };
    let most_point = (POINTS - 1) as f32;
    for (command, parameter, problem) in [
        (part(&|p| p.gain = 0.09), Parameter::PartGain, range(0.1, 10.0)),
        (part(&|p| p.gain = 10.1), Parameter::PartGain, range(0.1, 10.0)),
        (part(&|p| p.windless_w_k = -1e-9), Parameter::WindlessWK, range(0.0, 1e3)),
        (part(&|p| p.element = 4), Parameter::PartElement, ParameterProblem::Missing),
        (part(&|p| p.element = 5), Parameter::PartElement, ParameterProblem::Missing),
        (answer(&|a| a.reference = Some(5)), Parameter::ReferenceElement, range(0.0, 4.0)),
        (answer(&|a| a.smoothing_s[0] = -1.0), Parameter::SmoothingS, range(0.0, 1e4)),
        (answer(&|a| a.smoothing_s[1] = 1.1e4), Parameter::SmoothingS, range(0.0, 1e4)),
        (answer(&|a| a.output_interval_ticks = 0), Parameter::OutputIntervalTicks, range(1.0, 65535.0)),
        (answer(&|a| a.reference_gas_c = -274.0), Parameter::GasTemperatureC, range(-273.15, 1e4)),
        (
            WindCommand::NusseltPoint { point: POINTS as u8, amplitudes: [0.0; 6] },
            Parameter::NusseltPoint,
            range(0.0, most_point),
        ),
        (at(0.0, None), Parameter::PressurePa, ParameterProblem::NotPositive),
        (at(700.0, Some(-300.0)), Parameter::GasTemperatureC, range(-273.15, 1e4)),
    ] {
        assert_eq!(refused(&mut head, command), (parameter, problem), "{command:?}");
    }
    let config = HeadSurface { element: 0, surface, gain: 1.0, windless_w_k: 0.0 };
    let beyond = WindCommand::Surface { surface: MOST_SURFACES as u8, config };
    assert_eq!(refused(&mut head, beyond), (Parameter::Parts, range(0.0, MOST_SURFACES as f32 - 1.0)));
    // The bounds themselves will do.
    head.handle(&answer(&|a| a.reference = Some(4)), PERIOD_S).unwrap();
    head.handle(&part(&|p| p.gain = 0.1), PERIOD_S).unwrap();
}

#[test]
fn a_network_is_set_up_with_faster_gains_and_cross_heating() {
    let mut head = balance::sectors(&config());
    let faster = |element, until_s| {
        WindCommand::FasterGains(crate::model::FasterGainsConfig {
            element,
            set: 0,
            until_s,
            gains: balance::own(0).gains,
        })
    };
    assert_eq!(refused(&mut head, faster(4, 1.0)), (Parameter::PartElement, ParameterProblem::Missing));
    assert_eq!(refused(&mut head, faster(0, 0.0)), (Parameter::UntilS, ParameterProblem::NotPositive));
    let before = head.clone();
    head.handle(&faster(0, 1.0), PERIOD_S).unwrap();
    assert_ne!(head, before);
}
