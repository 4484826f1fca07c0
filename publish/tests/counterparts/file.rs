//! Files, read by the programs that they are for.

use crate::bench::{Running, Tested, program};
use publish::file::{ConvertOptions, convert};
use recording::Recording;
use std::path::PathBuf;
use std::process::Command;

/// A recording of two rows as a file of this extension.
fn converted(folder: &tempfile::TempDir, extension: &str) -> Result<PathBuf, Box<dyn std::error::Error>> {
    let csv = folder.path().join("winds.csv");
    std::fs::write(
        &csv,
        "# title: gusts\n# start_utc: 2026-02-28T23:59:59.5Z\ntime_s,power_w_core,state,wind_x_m_s,wind_y_m_s,wind_z_m_s,wind_speed_m_s,quality_flags\n0,0.125,standby,2,0,0,2,0\n0.5,,running,0,2,0,2,257\n",
    )?;
    let path = folder.path().join(format!("winds.{extension}"));
    convert(&Recording::read(&csv)?, &ConvertOptions { heading_deg: Some(90.0), ..ConvertOptions::default() }, &path)?;
    Ok(path)
}

#[test]
fn ncdump_shows_units_and_flags() -> Tested {
    let Some(ncdump) = program("ncdump") else { return Ok(()) };
    let folder = tempfile::tempdir()?;
    let text = Running::start(Command::new(ncdump).arg(converted(&folder, "nc")?))?.printed()?;
    for part in [
        "time:units = \"seconds since 2026-02-28 23:59:59.500000\"",
        "wind_from_deg:standard_name = \"wind_from_direction\"",
        "power_w_core:units = \"W\"",
        "state:flag_meanings = \"standby running\"",
        "quality_flags:flag_masks = 1, 2, 4,",
        ":Conventions = \"CF-1.11\"",
        " power_w_core = 0.125, _ ;",
        " state = 0, 1 ;",
        " wind_from_deg = 270, 180 ;",
        " time = 0, 0.5 ;",
    ] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
    Ok(())
}

#[test]
fn octave_loads_vectors_and_words() -> Tested {
    let Some(octave) = program("octave-cli") else { return Ok(()) };
    let folder = tempfile::tempdir()?;
    let script = format!(
        "load('{}'); printf('%g ', time_s, power_w_core, wind_from_deg, quality_flags); disp(deblank(state_words(state_code(2), :)));",
        converted(&folder, "mat")?.display()
    );
    let mut command = Command::new(octave);
    command.args(["--norc", "--no-history", "--eval", &script]);
    assert_eq!(Running::start(&mut command)?.printed()?, "0 0.5 0.125 NaN 270 180 0 257 running\n");
    Ok(())
}
