//! From records of still gas to the wind of sphere B: a chain as short as still reaches the bars of
//! the whole one.
//!
//! Records of an element last 45 min instead of 90, and the tunnel blows 60 winds instead of 120.
//! What is asked for is not less.

use anemo_tests::{changed, file};
use anemometry::calibrate::SteadyWind;
use anemometry::calibrate::calibrator::{Calibrator, NetworkSource};
use anemometry::calibrate::drawn::DrawnOptions;
use anemometry::network::identify::PolesPerPair;
use studies::benchmark::wind::{SPHERE_B, WindMode, chain, directions, swing};
use studies::thesis::StudyLab;

const RECORD_S: f64 = 2700.0;
const SETTLE_S: f64 = 10.0;

#[test]
fn sphere_b_tells_winds_that_it_has_never_seen() {
    let lab = StudyLab::new(file("experiments/wind/sphere-b"), &|_| ());
    let model = chain::network(&lab, SPHERE_B.elements, PolesPerPair::default(), Some(RECORD_S)).unwrap();

    let fewer = [("winds = 120", "winds = 60"), ("hold_s = 30.0", "hold_s = 20.0"), ("3900.0", "1500.0")];
    let tunnel = changed("wind/sphere-b/tunnel.toml", &fewer);
    let calibrator =
        Calibrator::new(&tunnel.head, NetworkSource::Identified(&model), &DrawnOptions::default(), None).unwrap();
    let steady = chain::steady(&calibrator, &tunnel, SETTLE_S).unwrap();
    assert_eq!(steady.len(), 61);
    let calibrated = |steady: &[SteadyWind]| calibrator.calibrated(steady, "1 recording", 20.0);

    let speed = |of: &SteadyWind| of.wind_m_s.iter().map(|v| v * v).sum::<f64>().sqrt();
    // Sector 1, which looks to (1, 1, 1), has never been in front of the wind: within 60° would be
    // less than −0.5.
    let along = |of: &SteadyWind| of.wind_m_s.iter().sum::<f64>() / 3_f64.sqrt();
    let behind: Vec<SteadyWind> = steady.iter().filter(|of| along(of) >= -0.4 * speed(of)).cloned().collect();
    let refusal = calibrated(&behind).err().expect("a front is missing").to_string();
    println!("{refusal}");
    assert!(refusal.contains("sector1 was never within 60° of the wind's front"), "{refusal}");
    assert!(refusal.contains("winds that come from about (0.58, 0.58, 0.58) are missing"), "{refusal}");
    // Only slow ones and fast ones.
    let gap: Vec<SteadyWind> = steady.iter().filter(|of| !(2.0..8.0).contains(&speed(of))).cloned().collect();
    let refusal = calibrated(&gap).err().expect("speeds are missing").to_string();
    println!("{refusal}");
    assert!(refusal.contains("no wind between") && refusal.contains("are missing"), "{refusal}");

    let head = calibrated(&steady).unwrap().head;
    let winds = [("winds = 500", "winds = 120"), ("3060.0", "780.0")];
    let unseen = changed("wind/sphere-b/winds.toml", &winds);
    let errors = &directions::of(&unseen, &head, &[WindMode { bandwidth_hz: 1.0, fixed: false }]).unwrap()[0];
    let (direction_deg, speed) = (errors.direction_deg.rms().unwrap(), errors.speed.rms().unwrap());
    println!(
        "{} winds: direction {direction_deg:.3}° rms, linear inverse {:.2}°, speed {:.3} % rms, {:.2} % worst",
        unseen.wind.len() - 1,
        errors.linear_deg.rms().unwrap(),
        100.0 * speed,
        100.0 * errors.speed.worst().unwrap()
    );
    assert_eq!((errors.failed, errors.no_direction), (0, 0));
    assert!(errors.count > 120 * 200, "{}", errors.count);
    assert!(direction_deg <= 1.5 && speed <= 0.015);
    // The model of the surface exists for this.
    assert!(errors.linear_deg.rms().unwrap() > 2.0 * direction_deg);

    // A support that is 20 K colder or warmer than in the identification and in the tunnel; the
    // warmer one is as warm as the cores, which then lose their fight.
    for support_c in ["-63.15", "-23.15"] {
        let moved = [winds[0], winds[1], ("-43.15", support_c)];
        let unseen = changed("wind/sphere-b/winds.toml", &moved);
        let errors = &directions::of(&unseen, &head, &[WindMode { bandwidth_hz: 1.0, fixed: false }]).unwrap()[0];
        let (direction_deg, speed) = (errors.direction_deg.rms().unwrap(), errors.speed.rms().unwrap());
        println!("support at {support_c} °C: direction {direction_deg:.3}° rms, speed {:.3} % rms", 100.0 * speed);
        assert_eq!((errors.failed, errors.no_direction), (0, 0));
        assert!(direction_deg <= 0.7 && speed <= 0.015);
    }

    let swing = swing::measure(&lab, &head).unwrap();
    println!("gas swinging by {} K: {:.2} % at worst", swing.kelvin, 100.0 * swing.speed_worst);
    assert!(swing.speed_worst <= 0.03 && swing.kelvin >= 10.0);
    // The swing is there to be seen.
    assert!(swing.raw_span > 0.01, "{swing:?}");
}
