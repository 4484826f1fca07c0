//! A record that does not fit in memory is identified from its file, in memory that does not grow
//! with its length.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use recording::{RecordingLayout, RecordingRow, RecordingWriter};

/// Writes a recording of chance bits of 1 s and a temperature that follows them within 0.5 s, 2
/// kHz.
fn write(path: &Path, rows: usize) {
    let layout = RecordingLayout {
        elements: vec!["wire".to_owned()],
        true_wind: false,
        gas: false,
        observed: Vec::new(),
        estimates: Vec::new(),
        combined_wind: false,
        earth_wind: false,
        cores: Vec::new(),
        numbers: Vec::new(),
    };
    let mut writer = RecordingWriter::create(path, layout, &Vec::new()).unwrap();
    let (mut seed, mut power_w, mut rise_k) = (1_u64, 0.0_f32, 0.0_f32);
    for n in 0..rows {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        if n % 2_000 == 0 {
            power_w = if seed >> 63 == 1 { 1.0 } else { 0.0 };
        }
        let noise_k = (seed >> 40) as f32 / (1 << 24) as f32 - 0.5;
        writer
            .push(&RecordingRow {
                time_s: n as f64 * 5e-4,
                temperature_c: &[20.0 + rise_k + 0.1 * noise_k],
                power_w: &[power_w],
                true_wind_m_s: None,
                gas_temperature_c: None,
                estimate: &[],
                equivalent_power_w: &[],
                heaters: usize::from(power_w > 0.0),
                event: "",
                state: "running",
            })
            .unwrap();
        rise_k += 1e-3 * (5.0 * power_w - rise_k);
    }
    writer.finish(&Vec::new()).unwrap();
}

/// The greatest resident memory that a process has had so far, MiB, as Linux reports it in KiB.
fn greatest_mib(process: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? / 1024)
}

/// Identifies a record of so many rows with the command, whose greatest resident memory is handed
/// back, MiB.
fn memory_mib(rows: usize) -> u64 {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.parquet");
    write(&path, rows);
    let started = std::time::Instant::now();
    let mut child = Command::new(env!("CARGO_BIN_EXE_anemo"))
        .args(["identify", "--order", "8", "--mesh", "0.006:6000", "--json"])
        .arg(&path)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut memory_mib = 0;
    while child.try_wait().unwrap().is_none() {
        memory_mib = greatest_mib(child.id()).unwrap_or(memory_mib);
        std::thread::sleep(Duration::from_millis(5));
    }
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let model: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(model["provenance"]["rows"], rows);
    eprintln!("{rows} rows: {memory_mib} MiB, {:.1} s", started.elapsed().as_secs_f64());
    memory_mib
}

#[test]
fn a_million_rows_are_identified_in_64_mib() {
    let memory_mib = memory_mib(1_000_000);
    assert!((1..=64).contains(&memory_mib), "{memory_mib} MiB");
}

/// Takes minutes, and 2 GB on the disk: `cargo test --release -p anemo --test command long_record
/// -- --ignored --nocapture`
#[test]
#[ignore = "takes minutes, and 2 GB on the disk"]
fn a_hundred_million_rows_are_identified_in_64_mib() {
    let memory_mib = memory_mib(100_000_000);
    assert!((1..=64).contains(&memory_mib), "{memory_mib} MiB");
}
