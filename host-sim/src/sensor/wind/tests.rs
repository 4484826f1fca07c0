mod spectra;

use super::*;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

fn entry(start_s: f64, label: &str, speed_m_s: f64) -> WindEntry {
    WindEntry { start_s, label: label.into(), speed_m_s, ..WindEntry::default() }
}

fn relaxed(intensity: f64, correlation_time_s: f64) -> Turbulence {
    Turbulence { intensity, spectrum: Spectrum::Relaxation { correlation_time_s } }
}

fn wind(entries: &[WindEntry], sample_period_s: f64) -> SimulatedWind {
    SimulatedWind::new(entries, sample_period_s, ChaCha8Rng::seed_from_u64(5)).unwrap()
}

#[test]
fn holds_each_entry_until_the_next_one_starts() {
    // 0.3 / 0.1 is not 3 in binary: the entry must still begin at tick 3.
    let mut wind = wind(&[entry(0.0, "calm", 0.0), entry(0.3, "breeze", 2.0), entry(0.55, "gust", 8.0)], 0.1);
    let speeds: Vec<f64> = (0..8).map(|_| wind.advance()[0]).collect();
    assert_eq!(speeds, [0.0, 0.0, 0.0, 2.0, 2.0, 2.0, 8.0, 8.0]);
    assert_eq!(wind.mean_m_s(), [8.0, 0.0, 0.0]);
}

#[test]
fn azimuth_and_elevation_say_where_the_air_goes() {
    let mut entry = entry(0.0, "", 2.0);
    (entry.azimuth_deg, entry.elevation_deg) = (90.0, 30.0);
    let [x, y, z] = entry.mean_m_s();
    assert!(x.abs() < 1e-15 && (y - 3.0_f64.sqrt()).abs() < 1e-15 && (z - 1.0).abs() < 1e-15);
}

#[test]
fn turbulence_has_the_variance_and_the_correlation_time_asked_for() {
    let mut gusty = entry(0.0, "gusty", 4.0);
    gusty.turbulence = Some(relaxed(0.15, 1.5));
    let (period, count) = (0.05, 2_000_000);
    let mut wind = wind(&[gusty], period);
    let samples: Vec<[f64; 3]> = (0..count).map(|_| wind.advance()).collect();
    // Independent samples: the duration over twice the correlation time.
    let independent = count as f64 * period / (2.0 * 1.5);
    let sigma = 0.15 * 4.0;
    for axis in 0..3 {
        let mean = samples.iter().map(|v| v[axis]).sum::<f64>() / count as f64;
        let expected = [4.0, 0.0, 0.0][axis];
        assert!((mean - expected).abs() < 4.0 * sigma / independent.sqrt(), "mean {mean}");
        let covariance = |lag: usize| {
            let pairs = samples.iter().zip(&samples[lag..]);
            pairs.map(|(a, b)| (a[axis] - mean) * (b[axis] - mean)).sum::<f64>() / (count - lag) as f64
        };
        // Four standard errors: σ²√(2/N) of a variance; the same, at most, of a covariance.
        let tolerance = 4.0 * (2.0 / independent).sqrt();
        assert!((covariance(0) / (sigma * sigma) - 1.0).abs() < tolerance, "variance {}", covariance(0));
        let after_tau = covariance(30) / (sigma * sigma);
        assert!((after_tau - libm::exp(-1.0)).abs() < tolerance, "correlation after τ {after_tau}");
    }
    let cross: f64 = samples.iter().map(|v| (v[0] - 4.0) * v[1]).sum::<f64>() / count as f64;
    assert!((cross / (sigma * sigma)).abs() < 4.0 / independent.sqrt(), "components are independent: {cross}");
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    let mut gusty = entry(0.0, "gusty", 4.0);
    gusty.turbulence = Some(relaxed(0.3, 0.5));
    let run = |seed| {
        let mut wind = SimulatedWind::new(&[gusty.clone()], 0.01, ChaCha8Rng::seed_from_u64(seed)).unwrap();
        (0..1000).map(|_| wind.advance().map(f64::to_bits)).collect::<Vec<_>>()
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
}

#[test]
fn what_is_asked_for_adds_up_in_the_middle_of_each_period() {
    let blown = WindEntry {
        azimuth_deg: 90.0,
        sine: Some(Sine { amplitude_m_s: 1.0, frequency_hz: 0.25 }),
        gust: Some(Gust {
            start_s: 1.0,
            duration_s: 2.0,
            rise_m_s: 3.0,
            azimuth_deg: Some(0.0),
            elevation_deg: Some(90.0),
        }),
        ..entry(2.0, "blown", 5.0)
    };
    let mut wind = wind(&[entry(0.0, "held", 5.0), blown], 0.1);
    for tick in 0..60 {
        let [x, y, z] = wind.advance();
        let time_s = 0.1 * (f64::from(tick) + 0.5) - 2.0;
        if time_s < 0.0 {
            assert_eq!([x, y, z], [5.0, 0.0, 0.0]);
            continue;
        }
        let sine = 5.0 + libm::sin(std::f64::consts::FRAC_PI_2 * time_s);
        let gust =
            if (1.0..3.0).contains(&time_s) { 1.5 * (1.0 + libm::cos(std::f64::consts::PI * time_s)) } else { 0.0 };
        assert!(x.abs() < 1e-12 && (y - sine).abs() < 1e-12 && (z - gust).abs() < 1e-12, "{time_s} s: {x} {y} {z}");
    }
    // The mean is the entry's, whatever blows on top.
    assert!(wind.mean_m_s()[0].abs() < 1e-12 && wind.mean_m_s()[1] == 5.0);
}

#[test]
fn a_swing_turns_the_mean_and_leaves_the_speed() {
    let swing = Some(DirectionSwing { amplitude_deg: 40.0, frequency_hz: 1.0 });
    let mut wind = wind(&[WindEntry { swing, azimuth_deg: 10.0, elevation_deg: 20.0, ..entry(0.0, "", 3.0) }], 0.01);
    let seen: Vec<[f64; 3]> = (0..100).map(|_| wind.advance()).collect();
    let azimuth = |v: &[f64; 3]| libm::atan2(v[1], v[0]).to_degrees();
    assert!(seen.iter().all(|v| (v.iter().map(|x| x * x).sum::<f64>() - 9.0).abs() < 1e-12 && v[2] > 1.0));
    // The sine's peak lies between two middles: within 1 − cos(π/100) of it.
    assert!((azimuth(&seen[24]) - 50.0).abs() < 0.02 && (azimuth(&seen[74]) + 30.0).abs() < 0.02);
}

#[test]
fn a_dust_devil_counts_from_its_entry_and_adds_to_the_mean() {
    let dust_devil = Some(DustDevil {
        time_s: 3.05,
        miss_m: 8.0,
        core_radius_m: 8.0,
        swirl_m_s: 12.0,
        inflow_m_s: 0.0,
        travel_m_s: None,
        travel_azimuth_deg: None,
    });
    let passing = WindEntry { dust_devil, ..entry(1.0, "passing", 4.0) };
    let mut wind = wind(&[entry(0.0, "before", 4.0), passing], 0.1);
    let seen: Vec<[f64; 3]> = (0..80).map(|_| wind.advance()).collect();
    assert_eq!(seen[9], [4.0, 0.0, 0.0]);
    // Nearest in the middle of tick 40, at the core's edge: 4 + 12 m/s along the travel.
    let highest = (0..80).max_by(|&a, &b| seen[a][0].total_cmp(&seen[b][0])).unwrap();
    assert_eq!(highest, 40);
    assert!((seen[40][0] - 16.0).abs() < 1e-9 && seen[40][1].abs() < 1e-9, "{:?}", seen[40]);
}

#[test]
fn refuses_impossible_entries_by_name() {
    let mut cases = vec![(vec![entry(1.0, "", 1.0)], "wind[0].start_s")];
    cases.push((vec![entry(0.0, "", 1.0), entry(0.0, "", 2.0)], "wind[1].start_s"));
    cases.push((vec![entry(0.0, "", -1.0)], "wind[0].speed_m_s"));
    cases.push((vec![entry(0.0, "", f64::NAN)], "wind[0].speed_m_s"));
    cases.push((vec![WindEntry { elevation_deg: 91.0, ..entry(0.0, "", 1.0) }], "wind[0].elevation_deg"));
    let turbulence = Some(relaxed(0.1, 0.0));
    cases.push((vec![WindEntry { turbulence, ..entry(0.0, "", 1.0) }], "wind[0].turbulence.correlation_time_s"));
    let good = || entry(0.0, "", 3.0);
    let turbulent = |spectrum| {
        let turbulence = Some(Turbulence { intensity: 0.2, spectrum });
        vec![WindEntry { turbulence, ..good() }]
    };
    cases.push((turbulent(Spectrum::VonKarman { length_m: 0.0 }), "wind[0].turbulence.length_m"));
    cases.push((turbulent(Spectrum::VonKarman { length_m: 0.14 }), "goes in five sample periods"));
    cases.push((turbulent(Spectrum::Kaimal { height_m: f64::NAN }), "wind[0].turbulence.height_m"));
    cases.push((turbulent(Spectrum::Kaimal { height_m: 61.0 }), "above which eddies do not grow"));
    let sine =
        |amplitude_m_s, frequency_hz| vec![WindEntry { sine: Some(Sine { amplitude_m_s, frequency_hz }), ..good() }];
    cases.push((sine(3.1, 1.0), "wind[0].sine.amplitude_m_s"));
    cases.push((sine(1.0, 51.0), "wind[0].sine.frequency_hz"));
    cases.push((sine(1.0, 0.0), "wind[0].sine.frequency_hz"));
    let swing = |amplitude_deg, frequency_hz| {
        vec![WindEntry { swing: Some(DirectionSwing { amplitude_deg, frequency_hz }), ..good() }]
    };
    cases.push((swing(181.0, 1.0), "wind[0].swing.amplitude_deg"));
    cases.push((swing(10.0, f64::NAN), "wind[0].swing.frequency_hz"));
    let plain = Gust { start_s: 0.0, duration_s: 1.0, rise_m_s: 2.0, azimuth_deg: None, elevation_deg: None };
    let gust = |gust| vec![WindEntry { gust: Some(gust), ..good() }];
    cases.push((gust(Gust { start_s: -1.0, ..plain }), "wind[0].gust.start_s"));
    cases.push((gust(Gust { duration_s: 0.015, ..plain }), "wind[0].gust.duration_s"));
    cases.push((gust(Gust { rise_m_s: -3.1, ..plain }), "wind[0].gust.rise_m_s"));
    cases.push((gust(Gust { azimuth_deg: Some(f64::INFINITY), ..plain }), "wind[0].gust.azimuth_deg"));
    cases.push((gust(Gust { elevation_deg: Some(91.0), ..plain }), "wind[0].gust.elevation_deg"));
    let plain = DustDevil {
        time_s: 1.0,
        miss_m: 2.0,
        core_radius_m: 5.0,
        swirl_m_s: 10.0,
        inflow_m_s: 0.0,
        travel_m_s: None,
        travel_azimuth_deg: None,
    };
    let devil = |devil| vec![WindEntry { dust_devil: Some(devil), ..good() }];
    cases.push((devil(DustDevil { time_s: f64::NAN, ..plain }), "wind[0].dust_devil.time_s"));
    cases.push((devil(DustDevil { miss_m: f64::NAN, ..plain }), "wind[0].dust_devil.miss_m"));
    cases.push((devil(DustDevil { core_radius_m: 0.0, ..plain }), "wind[0].dust_devil.core_radius_m"));
    cases.push((devil(DustDevil { swirl_m_s: -101.0, ..plain }), "wind[0].dust_devil.swirl_m_s"));
    cases.push((devil(DustDevil { inflow_m_s: -1.0, ..plain }), "wind[0].dust_devil.inflow_m_s"));
    cases.push((devil(DustDevil { travel_m_s: Some(0.0), ..plain }), "wind[0].dust_devil.travel_m_s"));
    cases.push((devil(DustDevil { travel_azimuth_deg: Some(f64::NAN), ..plain }), "dust_devil.travel_azimuth_deg"));
    let still = WindEntry { dust_devil: Some(plain), ..entry(0.0, "", 0.0) };
    cases.push((vec![still], "`wind[0].dust_devil.travel_m_s` is 0: it must be 0.01 to 100; without it"));
    for (entries, name) in cases {
        let error = SimulatedWind::new(&entries, 0.01, ChaCha8Rng::seed_from_u64(1)).unwrap_err().to_string();
        assert!(error.contains(name), "{error}");
    }
}
