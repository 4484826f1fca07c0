//! Speed of the simulated sensors: times of real time on one core, each at its own rate, with
//! turbulence and noise.
//!
//! ```text
//! cargo run --release -p anemo-tests --example sensor_speed [HEAD]
//! valgrind --tool=callgrind target/release/examples/sensor_speed sphere-b
//! ```

use std::time::Instant;

use anemometry::gas::Species;
use anemometry::head::Head;
use host_sim::sensor::{Imperfections, Sensor, SensorConfig, Spectrum, Turbulence, WindEntry};

const SECONDS: f64 = 2000.0;

fn main() {
    for (name, period_s, species, pressure_pa, gas_c, speed_m_s) in [
        ("sphere-a", 0.01, Species::CarbonDioxide, 1000.0, -53.15, 3.0),
        ("sphere-b", 0.01, Species::CarbonDioxide, 1000.0, -53.15, 3.0),
        ("rems", 0.025, Species::Air, 24_000.0, 21.0, 0.3),
        ("rems", 1.0, Species::Air, 24_000.0, 21.0, 0.3),
    ] {
        if std::env::args().nth(1).is_some_and(|only| only != name) {
            continue;
        }
        let head = Head::read(&anemo_tests::file(&format!("heads/{name}.toml"))).expect("the head is right");
        let wind = WindEntry {
            start_s: 0.0,
            label: "breeze".to_owned(),
            speed_m_s,
            azimuth_deg: 200.0,
            elevation_deg: -20.0,
            turbulence: Some(Turbulence {
                intensity: 0.15,
                spectrum: Spectrum::Relaxation { correlation_time_s: 1.5 },
            }),
            ..WindEntry::default()
        };
        let config = SensorConfig {
            construction: host_sim::sensor::construction_of(&head)
                .expect("a head of the project")
                .expect("the head names its sensor"),
            sample_period_s: period_s,
            species,
            pressure_pa,
            gas_temperature_c: gas_c,
            support_temperature_c: gas_c,
            elements: head.elements.iter().map(|element| element.nominal).collect(),
            volt_per_code: head.volt_per_code,
            imperfections: Imperfections { noise_v_rms: 1.5e-6, ..Imperfections::default() },
            wind: vec![wind],
            ..SensorConfig::default()
        };
        let mut sensor = Sensor::new(&config).expect("the sensor can be simulated");
        let ticks = (SECONDS / period_s) as u32;
        let mut check = 0_i64;
        let start = Instant::now();
        for tick in 0..ticks {
            sensor.advance((tick.wrapping_mul(40_503) >> 3) as u16 as usize);
            check += i64::from(sensor.codes()[0]);
        }
        let wall_s = start.elapsed().as_secs_f64();
        println!(
            "{name}: {} elements at {} Hz, {:.2} µs a tick, {:.0} times real time (sum of codes {check})",
            sensor.codes().len(),
            1.0 / period_s,
            1e6 * wall_s / f64::from(ticks),
            SECONDS / wall_s
        );
    }
}
