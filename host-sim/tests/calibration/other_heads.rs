//! Single elements, wires, cylinders and spheres of more sectors, in winds that the calibration has
//! not seen.

use anemometry::calibrate::drawn::surfaces_of;
use anemometry::calibrate::{
    CalibrateError, ComparisonSummary, ConvectionOptions, DrawnSurface, DrawnSurfaces, Gravity, LossLaw,
    SoughtConvection, SteadyWind, SurfaceCalibration, SurfaceReading, calibrate, chosen, compare,
};
use anemometry::gas::{IdealGas, Species};
use anemometry::head::body::{CylinderShape, WireLaw, WireShape};
use anemometry::vector::unit;
use diffusive::random::StandardNormal;
use dr_core::wind::HeadForm;
use host_sim::sensor::convection::cylinder::Cylinder;
use host_sim::sensor::convection::sphere_surfaces::SphereSurfaces;
use host_sim::sensor::convection::wire::Wire;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::Distribution as _;
use std::f64::consts::{PI, TAU};

const OVERHEAT_K: f64 = 20.0;
const KING: LossLaw = LossLaw::King { exponent: None };

/// Conductances of the surfaces in a wind, W/K.
type Losses<'a> = dyn Fn([f64; 3]) -> Vec<f64> + 'a;

/// A head and what it loses, in a tunnel.
struct Bench<'a> {
    drawn: DrawnSurfaces,
    gas: IdealGas,
    losses: Box<Losses<'a>>,
    /// Noise of every conductance.
    noise: f64,
}

fn air() -> IdealGas {
    IdealGas::new(Species::Air, 101_325.0, 293.15).unwrap()
}

fn drawn(form: HeadForm, law: LossLaw, normals: &[[f64; 3]], diameter_m: f64) -> DrawnSurfaces {
    let surfaces = surfaces_of(form, normals, diameter_m, 0.01).unwrap().into_iter().enumerate();
    let surfaces = surfaces.map(|(i, config)| DrawnSurface { name: format!("surface{}", i + 1), config }).collect();
    DrawnSurfaces { form, law, diameter_m, surfaces, convection: SoughtConvection::default() }
}

impl Bench<'_> {
    /// A reading; the wind is stated as off by a share of `stated_error` with the spread of a
    /// standard normal.
    fn reading(&self, n: usize, wind_m_s: [f64; 3], stated_error: f64, random: &mut ChaCha8Rng) -> SteadyWind {
        let mut normal = || -> f64 { StandardNormal.sample(&mut *random) };
        let still = (self.losses)([0.0; 3]);
        let surfaces = (self.losses)(wind_m_s).into_iter().zip(still).map(|(w_k, still_w_k)| {
            let error_w = self.noise * w_k * OVERHEAT_K;
            SurfaceReading {
                power_w: (w_k - still_w_k) * OVERHEAT_K + error_w * normal(),
                overheat_k: OVERHEAT_K,
                above_reference_k: OVERHEAT_K,
                variance_w2: error_w * error_w,
            }
        });
        let surfaces = surfaces.collect();
        let scale = 1.0 + stated_error * normal();
        SteadyWind { label: format!("wind {n}"), wind_m_s: wind_m_s.map(|v| v * scale), gas: self.gas, surfaces }
    }

    fn readings(&self, winds: &[[f64; 3]], stated_error: f64, seed: u64) -> Vec<SteadyWind> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        winds.iter().enumerate().map(|(n, wind)| self.reading(n, *wind, stated_error, &mut random)).collect()
    }

    /// Errors of a calibration in winds that it has not seen; all of them must have an estimate.
    fn unseen(&self, calibration: &SurfaceCalibration, winds: &[[f64; 3]]) -> ComparisonSummary {
        let all = self.readings(winds, 0.0, 99);
        let compared: Vec<_> = all.iter().map(|wind| compare(calibration, wind).unwrap().unwrap()).collect();
        ComparisonSummary::of(compared.iter())
    }
}

/// Speeds evenly in their logarithm, directions by a step as good as chance, within a range about
/// −x.
fn winds(count: usize, [least, most]: [f64; 2], within_rad: f64, seed: f64) -> Vec<[f64; 3]> {
    (0..count)
        .map(|n| {
            let share = |by: f64| ((n + 1) as f64 * by + seed).fract();
            let speed = least * libm::pow(most / least, share(0.618_033_989));
            let angle = PI + within_rad * (2.0 * share(0.754_877_666) - 1.0);
            [speed * libm::cos(angle), speed * libm::sin(angle), 0.0]
        })
        .collect()
}

#[test]
fn a_hot_wire_that_obeys_kings_law_gives_its_exponent_and_the_speed() {
    // Twenty speeds, each known to 0.2 %.
    let known: Vec<[f64; 3]> = (0..20).map(|n| [-0.5 * libm::pow(24.0, f64::from(n) / 19.0), 0.0, 0.0]).collect();
    for (seed, exponent) in [(1, 0.45), (2, 0.45), (3, 0.5), (4, 0.4), (5, 0.48)] {
        let bench = Bench {
            drawn: drawn(HeadForm::Single, KING, &[[1.0, 0.0, 0.0]], 5e-6),
            gas: air(),
            losses: Box::new(move |wind| vec![1.1e-4 + 1.3e-4 * libm::pow(wind[0].abs(), exponent)]),
            noise: 1e-4,
        };
        let found = calibrate(&bench.drawn, &bench.readings(&known, 2e-3, seed)).unwrap();
        let king = found.king.unwrap();
        assert!((king.exponent / exponent - 1.0).abs() < 0.01, "{king:?} for {exponent}");
        assert!((king.exponent - exponent).abs() < 4.0 * king.se_exponent, "{king:?} for {exponent}");
        let errors = bench.unseen(&found, &winds(100, [0.5, 12.0], 0.0, 0.3));
        assert!(errors.speed_rms < 5e-3 && errors.direction_rms_deg.is_nan(), "{errors:?}");
        // Nothing says what of the loss at rest is conduction into the gas.
        assert!(found.to_string().contains(" taken ") && found.warnings().is_empty(), "{found}");
        // The spline knows the law as well, a little less surely.
        let spline = DrawnSurfaces { law: LossLaw::Spline, ..bench.drawn.clone() };
        let found = calibrate(&spline, &bench.readings(&known, 2e-3, seed)).unwrap();
        assert!(bench.unseen(&found, &winds(100, [0.5, 12.0], 0.0, 0.3)).speed_rms < 5e-3);
    }
}

/// A wire of King's law with the properties of its film, calibrated with 60 K of overheat, at which
/// the network was made, too.
#[test]
fn film_properties_hold_for_a_wire_at_another_overheat() {
    let options = |film_share| ConvectionOptions {
        film_share,
        gravity: Gravity { m_s2: 0.0, up: [0.0, 0.0, 1.0] },
        stem: [0.0, 0.0, -1.0],
    };
    let readings = |overheat_k: f64| -> Vec<SteadyWind> {
        let conductance_w_k = |speed: f64, overheat_k: f64| {
            let film = IdealGas::new(Species::Air, 101_325.0, 293.15 + 0.5 * overheat_k).unwrap();
            let reynolds = film.density_kg_m3 * speed * 5e-6 / film.viscosity_pa_s;
            PI * 0.01 * film.conductivity_w_m_k * (0.3 + 0.55 * libm::pow(reynolds, 0.45))
        };
        let wind = |n: i32| {
            let speed = 0.5 * libm::pow(24.0, f64::from(n) / 19.0);
            let power_w = conductance_w_k(speed, overheat_k) * overheat_k - conductance_w_k(0.0, 60.0) * overheat_k;
            let surface = SurfaceReading {
                power_w,
                overheat_k,
                above_reference_k: overheat_k,
                variance_w2: (1e-4 * power_w).powi(2),
            };
            SteadyWind { label: format!("wind {n}"), wind_m_s: [-speed, 0.0, 0.0], gas: air(), surfaces: vec![surface] }
        };
        (0..20).map(wind).collect()
    };
    let plain = drawn(HeadForm::Single, LossLaw::Spline, &[[1.0, 0.0, 0.0]], 5e-6);
    let error = |film_share: Option<f64>, overheat_k: f64| {
        let convection = chosen(&plain, &readings(60.0), &options(film_share)).unwrap();
        let found = calibrate(&DrawnSurfaces { convection, ..plain.clone() }, &readings(60.0)).unwrap();
        assert_eq!(found.convection.is_some(), film_share.is_some());
        let errors: Vec<_> = readings(overheat_k).iter().map(|of| compare(&found, of).unwrap().unwrap()).collect();
        ComparisonSummary::of(errors.iter()).speed_rms
    };
    let [gas, film] = [None, Some(0.5)].map(|share| error(share, 200.0));
    println!("200 K: {gas} by the gas, {film} by the film");
    assert!(error(Some(0.5), 60.0) < 5e-3 && error(None, 60.0) < 5e-3);
    assert!(film < 0.5 * gas, "{film} {gas}");
}

#[test]
fn a_poor_calibration_warns_of_its_worst_wind() {
    let bench = Bench {
        drawn: drawn(HeadForm::Single, KING, &[[1.0, 0.0, 0.0]], 5e-6),
        gas: air(),
        losses: Box::new(|wind| vec![1e-4 + 1e-4 * wind[0].abs().sqrt()]),
        noise: 1e-4,
    };
    let known: Vec<[f64; 3]> = (0..20).map(|n| [-0.5 * libm::pow(24.0, f64::from(n) / 19.0), 0.0, 0.0]).collect();
    // Speeds that are known to a tenth only: 3 to 5 % of the loss.
    let found = calibrate(&bench.drawn, &bench.readings(&known, 0.1, 1)).unwrap();
    let warning = found.warnings().concat();
    let worst = format!("most in {} at surface1", found.worst.label);
    assert!(warning.starts_with("the calibration is poor: ") && warning.contains(&worst), "{warning}");
}

#[test]
fn an_exponent_that_is_given_is_used_and_one_speed_is_refused() {
    let bench = Bench {
        drawn: drawn(HeadForm::Single, LossLaw::King { exponent: Some(0.5) }, &[[1.0, 0.0, 0.0]], 5e-6),
        gas: air(),
        losses: Box::new(|wind| vec![1e-4 + 1e-4 * wind[0].abs().sqrt()]),
        noise: 1e-4,
    };
    let known: Vec<[f64; 3]> = (0..12).map(|n| [-0.5 * 1.3_f64.powi(n), 0.0, 0.0]).collect();
    let found = calibrate(&bench.drawn, &bench.readings(&known, 0.0, 1)).unwrap();
    assert_eq!(found.king.map(|king| (king.exponent, king.se_exponent)), Some((0.5, 0.0)));
    let refused = calibrate(&bench.drawn, &bench.readings(&[[-3.0, 0.0, 0.0]; 8], 0.0, 1)).unwrap_err();
    let CalibrateError::Spread(sentences) = refused else { panic!("{refused}") };
    assert!(sentences.iter().any(|sentence| sentence.contains("about one speed")), "{sentences:?}");
}

/// Two wires in the plane, across each other.
fn crossed_wires(noise: f64) -> Bench<'static> {
    let gas = air();
    let wire = |axis| {
        let shape = WireShape { diameter_m: 5e-4, length_m: 5e-3, axis, yaw_factor: 0.25, law: WireLaw::Kramers };
        Wire::new(&gas, &shape).unwrap()
    };
    let both = [wire([-1.0, 1.0, 0.0]), wire([1.0, 1.0, 0.0])];
    let normals = [unit([1.0, 1.0, 0.0]), unit([1.0, -1.0, 0.0])];
    Bench {
        drawn: drawn(HeadForm::Wires, KING, &normals, 5e-4),
        gas,
        losses: Box::new(move |wind| both.iter().map(|wire| wire.conductance_w_k(wind, 293.15 + OVERHEAT_K)).collect()),
        noise,
    }
}

#[test]
fn crossed_wires_give_speed_angle_and_yaw_factor() {
    let bench = crossed_wires(3e-4);
    let found = calibrate(&bench.drawn, &bench.readings(&winds(60, [0.5, 10.0], 0.7, 0.1), 0.0, 1)).unwrap();
    let king = found.king.unwrap();
    assert!((king.yaw_factor.unwrap() - 0.25).abs() < 0.02, "{king:?}");
    let errors = bench.unseen(&found, &winds(200, [0.6, 9.0], 0.65, 0.77));
    assert!(errors.direction_rms_deg < 0.6 && errors.speed_rms < 0.01, "{errors:?}");
}

#[test]
fn winds_along_one_direction_do_not_calibrate_crossed_wires() {
    let bench = crossed_wires(3e-4);
    let refused = calibrate(&bench.drawn, &bench.readings(&winds(30, [0.5, 10.0], 0.0, 0.1), 0.0, 1)).unwrap_err();
    let CalibrateError::Spread(sentences) = refused else { panic!("{refused}") };
    assert!(sentences.iter().any(|sentence| sentence.contains("tells no direction")), "{sentences:?}");
    let mut winds = bench.readings(&winds(30, [0.5, 10.0], 0.7, 0.1), 0.0, 1);
    winds[3].wind_m_s[2] = 0.2 * winds[3].wind_m_s[0];
    let refused = calibrate(&bench.drawn, &winds).unwrap_err().to_string();
    assert!(refused.contains("`wind 3`") && refused.contains("across the plane"), "{refused}");
}

#[test]
fn sectors_round_a_cylinder_give_the_wind_in_its_plane() {
    for count in [3, 6] {
        let normals: Vec<[f64; 3]> = (0..count)
            .map(|i| {
                let angle = TAU * f64::from(i) / f64::from(count);
                [libm::cos(angle), libm::sin(angle), 0.0]
            })
            .collect();
        let shape = CylinderShape {
            diameter_m: 6e-3,
            length_m: 0.01,
            axis: [0.0, 0.0, 1.0],
            yaw_factor: 0.0,
            gravity_m_s2: Some(9.81),
        };
        let truth = Cylinder::new(&air(), &shape, &normals).unwrap();
        let bench = Bench {
            drawn: drawn(HeadForm::Cylinder, LossLaw::Spline, &normals, 6e-3),
            gas: air(),
            losses: Box::new(move |wind| {
                let mut conductances = vec![0.0; count as usize];
                let surface_k = vec![293.15 + OVERHEAT_K; count as usize];
                truth.conductance_w_k(wind, &surface_k, &mut conductances);
                conductances
            }),
            noise: 5e-4,
        };
        let tunnel = [vec![[0.0; 3]], winds(60, [0.5, 10.0], PI, 0.1)].concat();
        let found = calibrate(&bench.drawn, &bench.readings(&tunnel, 0.0, 1)).unwrap();
        let errors = bench.unseen(&found, &winds(200, [0.6, 9.0], PI, 0.77));
        assert!(errors.direction_rms_deg < 1.0 && errors.speed_rms < 0.01, "{count}: {errors:?}");
    }
}

#[test]
fn six_sectors_of_a_sphere_tell_directions_better_than_four() {
    let gas = IdealGas::new(Species::CarbonDioxide, 1000.0, 220.0).unwrap();
    let tetrahedron = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]].map(unit);
    let cube: [[f64; 3]; 6] =
        std::array::from_fn(|i| std::array::from_fn(|k| if k == i / 2 { 1.0 - 2.0 * (i % 2) as f64 } else { 0.0 }));
    let errors = |form, normals: &[[f64; 3]]| {
        let truth = SphereSurfaces::new(&gas, 0.01, normals).unwrap();
        let count = normals.len();
        let bench = Bench {
            drawn: drawn(form, LossLaw::Spline, normals, 0.01),
            gas,
            losses: Box::new(move |wind| {
                let mut conductances = vec![0.0; count];
                truth.conductance_w_k(wind, &mut conductances);
                conductances
            }),
            noise: 2e-3,
        };
        // All directions: a spiral, by steps as good as chance.
        let winds = |count: usize, seed: f64| -> Vec<[f64; 3]> {
            let wind = |n: usize| {
                let share = |by: f64| ((n + 1) as f64 * by + seed).fract();
                let speed = 0.8 * libm::pow(12.0, share(0.618_033_989));
                let z = 2.0 * share(0.754_877_666) - 1.0;
                let angle = TAU * share(0.569_840_291);
                [(1.0 - z * z).sqrt() * libm::cos(angle), (1.0 - z * z).sqrt() * libm::sin(angle), z].map(|x| speed * x)
            };
            (0..count).map(wind).collect()
        };
        let tunnel = [vec![[0.0; 3]], winds(80, 0.1)].concat();
        let found = calibrate(&bench.drawn, &bench.readings(&tunnel, 0.0, 1)).unwrap();
        assert!(found.misfit_rms < 1.5e-3, "{form:?}: {found}");
        bench.unseen(&found, &winds(300, 0.77))
    };
    let (four, six) = (errors(HeadForm::Sphere, &tetrahedron), errors(HeadForm::Cube, &cube));
    // With as much noise on every sector.
    assert!(six.direction_rms_deg < 0.9 * four.direction_rms_deg, "{four:?} {six:?}");
    assert!(six.direction_rms_deg < 0.3 && six.speed_rms < 0.01, "{six:?}");
}
