//! Amplitudes between, below and above their points.

extern crate std;

use super::super::form::HeadForm;
use super::table::{amplitudes, published, sampled};
use crate::error::{Parameter, ParameterProblem};
use crate::wind::Nusselt;
use crate::wind::nusselt::ORDERS;

#[test]
fn interpolates_between_its_points() {
    let nusselt = Nusselt::new(HeadForm::Sphere, &published()).unwrap();
    for (from, to, tolerance) in [(1.0_f64, 165.0_f64, 1e-3), (165.0, 200.0, 3e-3)] {
        let (mut worst, mut worst_slope) = ([0.0_f64; ORDERS], 0.0_f64);
        for k in 1..5000 {
            let re = f64::from((from * libm::pow(to / from, f64::from(k) / 5000.0)) as f32);
            let (found, exact) = (nusselt.amplitudes(re as f32), amplitudes(re));
            for n in 0..ORDERS {
                worst[n] = worst[n].max((f64::from(found.value[n]) - exact[n]).abs());
            }
            let slope = (amplitudes(re * 1.0001)[0] - amplitudes(re / 1.0001)[0]) / (2.0 * libm::log(1.0001));
            worst_slope = worst_slope.max((f64::from(found.slope[0]) / slope - 1.0).abs());
        }
        std::println!(
            "Re {from} … {to}: largest errors of a_0 … a_5 {:?}, of d a_0/d ln Re {worst_slope:.1e}",
            worst.map(|w| w as f32)
        );
        // Points lie 17 % apart, rows of the table 10 to 100 %. In the table's last interval its
        // spline straightens out to an end without curvature, which is not physics and which no
        // cubic follows.
        assert!(worst.iter().all(|&w| w < tolerance), "{worst:?}");
        assert!(worst_slope < 0.03, "{worst_slope}");
    }
}

#[test]
fn the_slope_is_that_of_the_value_and_the_edges_join() {
    let nusselt = Nusselt::new(HeadForm::Sphere, &published()).unwrap();
    let h = 1e-3_f64;
    for re in [0.01, 0.3, 0.9, 1.7, 10.0, 63.0, 199.0, 230.0, 1000.0, 2e4] {
        let at = |re: f64| nusselt.amplitudes(re as f32);
        let (low, middle, high) = (at(re * libm::exp(-h)), at(re), at(re * libm::exp(h)));
        for n in 0..ORDERS {
            let difference = f64::from(high.value[n] - low.value[n]) / (2.0 * h);
            // Rounding of the values, over 2 h.
            let tolerance = 2e-4 * f64::from(middle.value[n].abs()).max(1.0) + 1e-4;
            assert!(
                (difference - f64::from(middle.slope[n])).abs() < tolerance,
                "a{n} at {re}: {difference} {middle:?}"
            );
        }
    }
    for edge in [1.0_f32, 200.0] {
        let (below, above) = (nusselt.amplitudes(edge * (1.0 - 1e-6)), nusselt.amplitudes(edge * (1.0 + 1e-6)));
        for n in 0..ORDERS {
            assert!((below.value[n] - above.value[n]).abs() < 1e-4, "a{n} at {edge}");
        }
        // a_0 and a_1 go on smoothly below, a_0 above.
        assert!((below.slope[0] / above.slope[0] - 1.0).abs() < 1e-3);
    }
}

#[test]
fn goes_to_conduction_below_the_grid_and_on_with_the_root_above() {
    // A calibration that begins at Re 10 and ends at 100 is compared with the table outside.
    let nusselt = Nusselt::new(HeadForm::Sphere, &sampled(10.0, 100.0)).unwrap();
    assert_eq!(nusselt.amplitudes(0.0).value, [2.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    for (re, tolerance) in [(1.0, 0.04), (2.0, 0.03), (5.0, 0.02), (150.0, 0.01), (200.0, 0.02)] {
        let ratio = f64::from(nusselt.amplitudes(re as f32).value[0]) / amplitudes(re)[0];
        std::println!("a_0 at Re {re} from a grid of 10 … 100: {ratio:.4} of the table's");
        assert!((ratio - 1.0).abs() < tolerance, "Re {re}: {ratio}");
    }
    assert!(nusselt.extrapolates(100.1) && !nusselt.extrapolates(99.9));
}

#[test]
fn refuses_amplitudes_that_determine_no_wind() {
    type SpoilAmplitudes = fn(&mut crate::wind::NusseltConfig);
    let cases: [(SpoilAmplitudes, Parameter, ParameterProblem); 9] = [
        (|c| c.least_reynolds = f32::NAN, Parameter::LeastReynolds, ParameterProblem::NotFinite),
        (|c| c.most_reynolds = 1.0, Parameter::MostReynolds, ParameterProblem::NotAscending),
        (|c| c.least_reynolds = 0.0, Parameter::LeastReynolds, ParameterProblem::OutOfRange { least: 1e-3, most: 1e6 }),
        (|c| c.amplitudes[3][4] = f32::NAN, Parameter::NusseltAmplitudes, ParameterProblem::NotFinite),
        (
            |c| c.amplitudes[3][4] = 2e4,
            Parameter::NusseltAmplitudes,
            ParameterProblem::OutOfRange { least: -1e4, most: 1e4 },
        ),
        (|c| c.amplitudes[0][0] = 1.9, Parameter::NusseltMean, ParameterProblem::NotAscending),
        (|c| c.amplitudes[9][0] = c.amplitudes[8][0], Parameter::NusseltMean, ParameterProblem::NotAscending),
        (
            |c| c.amplitudes[31][0] = c.amplitudes[30][0] * 1.0001,
            Parameter::NusseltMean,
            ParameterProblem::NotAscending,
        ),
        (|c| c.amplitudes[5][1] = 0.0, Parameter::NusseltFirst, ParameterProblem::NotPositive),
    ];
    for (spoil, parameter, problem) in cases {
        let mut config = published();
        spoil(&mut config);
        let error = Nusselt::new(HeadForm::Sphere, &config).unwrap_err();
        assert_eq!((error.parameter, error.problem), (parameter, problem));
    }
}
