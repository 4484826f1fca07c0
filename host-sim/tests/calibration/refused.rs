//! Refusals, by name; and that what is refused would have made a bad calibration, where its
//! neighbour that is taken makes a good one.

use crate::tunnel::{Tunnel, directions, speeds};
use anemometry::calibrate::{
    CalibrateError, ComparisonSummary, DrawnSurfaces, SteadyWind, SurfaceCalibration, calibrate, compare, solve,
};

fn lacking(head: &DrawnSurfaces, readings: &[SteadyWind]) -> Vec<String> {
    match calibrate(head, readings) {
        Err(CalibrateError::Spread(sentences)) => sentences,
        Err(other) => panic!("{other}"),
        Ok(_) => Vec::new(),
    }
}

fn errors_at(found: &SurfaceCalibration, tunnel: &Tunnel, speeds: &[f64]) -> ComparisonSummary {
    let unseen = tunnel.readings(speeds, 31, 1e-6, 77);
    let errors: Vec<_> = unseen[1..].iter().filter_map(|r| compare(found, r).unwrap()).collect();
    ComparisonSummary::of(errors.iter())
}

fn good() -> Vec<SteadyWind> {
    Tunnel::sectors().readings(&speeds(0.5, 14.0, 8), 8, 1e-3, 1)
}

#[test]
fn a_gap_between_speeds_is_named_with_what_would_fill_it() {
    let tunnel = Tunnel::sectors();
    let head = tunnel.head();
    let with = |speeds: &[f64]| tunnel.readings(speeds, 8, 1e-3, 1);
    let (gap, filled) = (with(&[0.5, 1.0, 2.1, 8.0, 14.0]), with(&[0.5, 1.0, 2.1, 4.0, 8.0, 14.0]));
    let sentences = lacking(&head, &gap);
    println!("{sentences:#?}");
    assert_eq!(sentences, ["no wind between 2.1 and 8.0 m/s (Re 46 to 174): winds at about 4.1 m/s are missing"]);
    assert!(lacking(&head, &filled).is_empty());
    let narrower = lacking(&head, &with(&[0.5, 1.0, 2.1, 5.0, 9.0, 14.0]));
    assert_eq!(narrower, ["no wind between 2.1 and 5.0 m/s (Re 46 to 109): winds at about 3.2 m/s are missing"]);
    let [without, with] =
        [&gap, &filled].map(|readings| errors_at(&solve(&head, readings).unwrap(), &tunnel, &[3.0, 4.0, 5.0]));
    println!("with the gap {without:?}\nwithout it {with:?}");
    assert!(without.speed_rms > 2.0 * with.speed_rms);
}

#[test]
fn one_speed_is_no_calibration() {
    let tunnel = Tunnel::sectors();
    let sentences = lacking(&tunnel.head(), &tunnel.readings(&[3.0, 3.1], 12, 1e-3, 1));
    assert!(sentences[0].contains("all winds have about one speed, 3.0 to 3.1 m/s (Re 65 to 67)"), "{sentences:?}");
    assert!(lacking(&tunnel.head(), &tunnel.readings(&[3.0, 6.0], 12, 1e-3, 1)).is_empty());
}

#[test]
fn a_surface_that_never_faced_the_wind_is_named() {
    let tunnel = Tunnel::sectors();
    let head = tunnel.head();
    // Away from the third sector, whose axis is (−1, 1, −1)/√3.
    let all: Vec<[f64; 3]> = directions(30).collect();
    let facing = |d: &[f64; 3]| (d[0] - d[1] + d[2]) / 3.0_f64.sqrt() >= libm::cos(60.0_f64.to_radians());
    let never: Vec<[f64; 3]> = all.iter().filter(|d| !facing(d)).copied().collect();
    let at = speeds(0.5, 14.0, 8);
    let (blind, seeing) = (tunnel.in_winds(&at, &never, 1e-3, 1), tunnel.in_winds(&at, &all, 1e-3, 1));
    let sentences = lacking(&head, &blind);
    println!("{sentences:#?}");
    assert_eq!(
        sentences,
        [
            "sector3 was never within 60° of the wind's front at 0.50 to 14.0 m/s (Re 11 to 305): winds that come from about \
         (-0.58, 0.58, -0.58) are missing"
        ]
    );
    assert!(lacking(&head, &seeing).is_empty());
    let errors = [&blind, &seeing].map(|readings| solve(&head, readings).unwrap().surfaces[2].gain_error);
    println!("standard error of its gain {:.5}, seen {:.5}", errors[0], errors[1]);
    assert!(errors[0] > 1.3 * errors[1]);
}

#[test]
fn an_octave_without_fronts_is_named() {
    // Along the edges between sectors: 55° and 125° to all axes.
    let tunnel = Tunnel::sectors();
    let head = tunnel.head();
    let axes: Vec<[f64; 3]> =
        (0..6).map(|j| std::array::from_fn(|k| if k == j / 2 { [1.0, -1.0][j % 2] } else { 0.0 })).collect();
    let corners: Vec<[f64; 3]> = (0..8).map(|j| [0, 1, 2].map(|k| if j >> k & 1 == 0 { 1.0 } else { -1.0 })).collect();
    let both: Vec<[f64; 3]> = axes.iter().chain(&corners).copied().collect();
    let sentences = lacking(&head, &tunnel.in_winds(&speeds(0.5, 14.0, 8), &axes, 1e-3, 1));
    println!("{sentences:#?}");
    assert_eq!(sentences.len(), 3);
    assert!(
        sentences[0].contains("at 0.50 to 14.0 m/s (Re 11 to 305) no surface was nearer to the wind's front than 55°")
    );
    assert!(sentences[2].contains("no surface was between 55° and 125° from the wind's front: winds at 90°"));
    assert!(lacking(&head, &tunnel.in_winds(&speeds(0.5, 14.0, 8), &both, 1e-3, 1)).is_empty());
    let rms = [&axes, &both].map(|directions| {
        let found = solve(&head, &tunnel.in_winds(&speeds(0.5, 14.0, 8), directions, 1e-3, 1));
        found.map(|found| errors_at(&found, &tunnel, &[1.0, 3.0, 8.0]).direction_rms_deg)
    });
    println!("direction {rms:?}");
    assert!(rms[0].as_ref().map_or(true, |bad| *bad > 3.0 * rms[1].as_ref().unwrap()));
}

#[test]
fn winds_in_a_plane_do_for_sectors_but_not_for_hemispheres() {
    let ring = |tilt: f64| -> Vec<[f64; 3]> {
        let place =
            |j: usize| (j as f64 * std::f64::consts::TAU / 16.0, if j.is_multiple_of(2) { tilt } else { -tilt });
        (0..16).map(place).map(|(angle, up)| [libm::cos(angle), libm::sin(angle), up]).collect()
    };
    for tunnel in [Tunnel::sectors(), Tunnel::hemispheres()] {
        let head = tunnel.head();
        let [flat, tilted] = [0.0, 0.6].map(|tilt| tunnel.in_winds(&speeds(0.5, 14.0, 8), &ring(tilt), 1e-3, 1));
        let of_both = [&flat, &tilted].map(|readings| (lacking(&head, readings), solve(&head, readings)));
        let [(in_plane, flat), (out_of_it, tilted)] = of_both;
        println!("in a plane {in_plane:?}, out of it {out_of_it:?}");
        assert!(out_of_it.is_empty());
        let tilted = errors_at(&tilted.unwrap(), &tunnel, &[0.7, 2.0, 5.0, 10.0]);
        if head.surfaces.len() == 2 {
            assert_eq!(
                in_plane,
                [
                    "all winds lie in one plane, within 0°: winds along its normal (0.00, 0.00, 1.00), or at least 20° out of it, are missing"
                ]
            );
            assert!(flat.is_err());
        } else {
            assert!(in_plane.is_empty());
            let flat = errors_at(&flat.unwrap(), &tunnel, &[0.7, 2.0, 5.0, 10.0]);
            println!("in a plane {flat:?}\nout of it {tilted:?}");
            assert!(flat.direction_rms_deg < 1.2 * tilted.direction_rms_deg);
        }
    }
}

#[test]
fn fewer_winds_than_unknowns_are_counted() {
    let tunnel = Tunnel::sectors();
    let sentences = lacking(&tunnel.head(), &good()[..8]);
    println!("{sentences:#?}");
    // 6 × 4 coefficients, 3 gains, 4 G0, 3 turns.
    assert_eq!(
        sentences[0],
        "8 winds of 4 surfaces: 32 readings, fewer than the 34 unknowns; it takes at least 1 wind more"
    );
    assert_eq!(
        lacking(&tunnel.head(), &good()[..1])[0],
        "1 wind of 4 surfaces: 4 readings, fewer than the 34 unknowns; it takes at least 8 winds more"
    );
    assert!(lacking(&tunnel.head(), &good()).is_empty());
}

#[test]
fn readings_that_cannot_be_meant_are_refused_by_label() {
    let tunnel = Tunnel::sectors();
    let refused = |spoil: fn(&mut SteadyWind)| {
        let mut readings = good();
        spoil(&mut readings[5]);
        let label = readings[5].label.clone();
        let message = calibrate(&tunnel.head(), &readings).unwrap_err().to_string();
        assert!(message.starts_with(&format!("wind `{label}`: ")), "{message}");
        println!("{message}");
        message
    };
    assert!(refused(|s| s.surfaces[2].power_w = f64::NAN).contains("sector3: `power_w` is NaN"));
    assert!(refused(|s| s.surfaces[1].above_reference_k = f64::INFINITY).contains("`above_reference_k`"));
    assert!(refused(|s| s.surfaces[0].overheat_k = -1.0).contains("sector1 is 1 K colder than the gas"));
    assert!(refused(|s| s.surfaces[0].variance_w2 = 0.0).contains("`variance_w2` is 0"));
    assert!(refused(|s| s.wind_m_s[1] = f64::NAN).contains("a component of the wind is NaN"));
    assert!(refused(|s| s.wind_m_s = [1e9, 0.0, 0.0]).contains("Reynolds number"));
    assert!(refused(|s| s.gas.density_kg_m3 = -1.0).contains("gas: "));
    assert!(refused(|s| s.surfaces.truncate(3)).contains("3 surfaces read, but the head has 4"));
}

#[test]
fn winds_with_the_wrong_sign_do_not_pass_for_a_calibration() {
    let tunnel = Tunnel::sectors();
    let mut readings = good();
    for reading in &mut readings {
        reading.wind_m_s = reading.wind_m_s.map(|v| -v);
    }
    let error = calibrate(&tunnel.head(), &readings).unwrap_err();
    println!("{error}");
    assert!(matches!(error, CalibrateError::Amplitudes(_) | CalibrateError::Unexplained { .. }), "{error}");
}

#[test]
fn surfaces_in_another_order_than_the_heads_do_not_pass_for_a_calibration() {
    let tunnel = Tunnel::sectors();
    let mut readings = good();
    for reading in &mut readings {
        reading.surfaces.swap(0, 1);
    }
    let error = calibrate(&tunnel.head(), &readings).unwrap_err();
    println!("{error}");
    assert!(matches!(error, CalibrateError::Unexplained { residual_rms, .. } if residual_rms > 0.2), "{error}");
}
