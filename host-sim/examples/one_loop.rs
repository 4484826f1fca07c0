//! One closed loop against a simulated sphere: a sector is held 5 K above the gas, and a step of
//! the wind shows in its power.
use std::error::Error;
use std::fmt::Write as _;

use host_sim::experiment::Experiment;
use host_sim::instrument::{LockStep, in_process::InProcess};
use host_sim::run::run;
use recording::toml_file::TomlSource;

const EXPERIMENT: &str = r#"
title = "One loop"
head = "../heads/sphere-b.toml"
sample_period_s = 0.01
duration_s = 60.0
gas = { species = "co2", pressure_pa = 1000.0, temperature_c = -53.15 }
drives = { sector1 = { temperature_c = -48.15 } }
wind = [{ start_s = 0.0, speed_m_s = 4.0 }, { start_s = 30.0, speed_m_s = 8.0 }]
"#;

/// Mean temperature and power of the sector over each 10 s.
pub fn table() -> Result<String, Box<dyn Error>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../experiments/one-loop.toml").into();
    let experiment = Experiment::from_source(TomlSource { path, text: EXPERIMENT.to_owned() })?;
    let instrument = LockStep::new(InProcess::new(), experiment.sensor()?);
    let mut sums = vec![(0.0, 0.0); 6];
    run(&experiment, Box::new(instrument), &mut |row| {
        let (celsius, watt) = &mut sums[(row.time_s / 10.0) as usize];
        (*celsius, *watt) = (*celsius + f64::from(row.temperature_c[0]), *watt + f64::from(row.power_w[0]));
        Ok(())
    })?;
    let lines = (10..).step_by(10).zip(sums).try_fold(String::new(), |mut text, (end_s, (celsius, watt))| {
        writeln!(text, "to {end_s} s  {:7.3} °C  {:6.3} mW", celsius / 1000.0, watt).map(|()| text)
    });
    Ok(lines?)
}

fn main() -> Result<(), Box<dyn Error>> {
    print!("{}", table()?);
    Ok(())
}
