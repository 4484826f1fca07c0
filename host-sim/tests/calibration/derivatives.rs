//! The equations of the fit: their derivatives, and how winds are left out.

use anemometry::calibrate::surfaces::cross_validation::folds;
use anemometry::calibrate::surfaces::equations::{LAST, SurfaceProblem};
use anemometry::calibrate::surfaces::family::AmplitudeFamily;
use anemometry::calibrate::surfaces::readings::{ready, winds};
use anemometry::calibrate::{DrawnSurfaces, Gravity, Scheme, SoughtConvection};
use dr_core::wind::HeadForm;
use dr_core::wind::nusselt::ORDERS;
use nalgebra::DVector;

use crate::tunnel::{Tunnel, speeds as progression};

#[test]
fn derivatives_agree_with_differences() {
    agree(&SoughtConvection::default());
    let gravity = Gravity { m_s2: 3.71, up: [0.0, 0.6, 0.8] };
    agree(&SoughtConvection {
        film_share: 0.5,
        is_rest_sought: true,
        rise: Some(gravity),
        stem: Some([0.0, 0.0, -1.0]),
        is_without_quiescent: false,
    });
}

fn agree(convection: &SoughtConvection) {
    let tunnel = Tunnel::sectors();
    let drawn = DrawnSurfaces { convection: convection.clone(), ..tunnel.head() };
    let head = ready(&drawn).unwrap();
    let winds = winds(&head, &tunnel.readings(&[0.7, 2.0, 5.0, 9.0], 7, 1e-3, 1)).unwrap();
    let reynolds = [0.5, 15.0, 44.0, 110.0, 199.0];
    let mut family = AmplitudeFamily::new(HeadForm::Sphere, &reynolds, (0..ORDERS).collect(), 200);
    family.is_rest_sought = convection.is_rest_sought;
    let problem = SurfaceProblem::new(&head, &winds, family);
    let mut place = problem.drawn();
    // Between the least and the most of the rise, and a stem map that is none of nothing.
    for (k, of) in place.stream.iter_mut().enumerate().skip(2) {
        *of += 0.1 * libm::sin(1.0 + k as f64);
    }
    for (k, c) in place.coefficients.iter_mut().enumerate() {
        *c = libm::sin(1.0 + k as f64);
    }
    place.gains = vec![1.1, 0.9, 1.05, 0.95];
    let place = problem.moved(&place, &DVector::zeros(problem.unknowns(&place)));
    let here = problem.equations(&place, LAST);
    for k in 0..problem.unknowns(&place) {
        // Means are f32: a step large beside their rounding.
        let step = 3e-3;
        let cost = |sign: f64| {
            let mut by = DVector::zeros(problem.unknowns(&place));
            by[k] = sign * step;
            problem.equations(&problem.moved(&place, &by), LAST).cost
        };
        let difference = (cost(-1.0) - cost(1.0)) / (4.0 * step);
        // The cost is no parabola in gains and turns: second order of the step.
        let scale = (here.h[(k, k)] * here.cost).sqrt();
        // So it is in the stream, by steps that are large beside f32's rounding.
        let most = if k < problem.first_of_stream(&place) { 2e-4 } else { 2e-2 };
        assert!((difference - here.b[k]).abs() < most * scale, "{k}: {difference} {}", here.b[k]);
    }
}

#[test]
fn neighbours_go_together_and_every_wind_is_left_out_once() {
    let tunnel = Tunnel::sectors();
    let drawn = tunnel.head();
    let head = ready(&drawn).unwrap();
    let winds = winds(&head, &tunnel.readings(&progression(0.5, 14.0, 12), 10, 1e-3, 1)).unwrap();
    for (scheme, expected) in [(Scheme::Directions, 120), (Scheme::Speeds, 100)] {
        let folds = folds(&winds, scheme, 5);
        let mut all = folds.concat();
        all.sort_unstable();
        all.dedup();
        assert_eq!((folds.len(), all.len(), folds.concat().len()), (5, expected, expected));
        for fold in &folds {
            for wind in winds.iter().filter(|wind| !wind.is_quiescent() && !fold.contains(&wind.given)) {
                for &out in fold {
                    let same_direction = (0..3).all(|k| (winds[out].towards[k] - wind.towards[k]).abs() < 1e-9);
                    let same_speed = (winds[out].reynolds / wind.reynolds - 1.0).abs() < 1e-9;
                    assert!(!(if scheme == Scheme::Speeds { same_speed } else { same_direction }));
                }
            }
        }
    }
    // Bands of two neighbouring speeds of the ten inner ones.
    let bands = folds(&winds, Scheme::Speeds, 5);
    let reynolds = |fold: &[usize]| fold.iter().map(|&out| winds[out].reynolds).collect::<Vec<_>>();
    assert!(bands.windows(2).all(|pair| {
        let [below, above] = [reynolds(&pair[0]), reynolds(&pair[1])];
        below.iter().all(|b| above.iter().all(|a| b < a))
    }));
}
