//! A record that does not fit in memory is identified from its file, in memory that does not grow with its length.

use std::path::Path;
use std::process::Command;

use host_sim::recording::{Layout, RecordingWriter, Row};
use nix::sys::resource::{UsageWho, getrusage};

/// Writes a recording of chance bits of 1 s and a temperature that follows them within 0.5 s, 2 kHz.
fn write(path: &Path, rows: usize) {
    let layout = Layout {
        elements: vec!["wire".to_owned()],
        wind: false,
        gas: false,
        observed: Vec::new(),
        answers: Vec::new(),
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
            .push(&Row {
                time_s: n as f64 * 5e-4,
                temperature_c: &[20.0 + rise_k + 0.1 * noise_k],
                power_w: &[power_w],
                wind_m_s: None,
                gas_temperature_c: None,
                answer: &[],
                equivalent_power_w: &[],
                heaters: u16::from(power_w > 0.0),
                event: "",
                state: "running",
            })
            .unwrap();
        rise_k += 1e-3 * (5.0 * power_w - rise_k);
    }
    writer.finish(&Vec::new()).unwrap();
}

/// Identifies a record of so many rows with the command, whose greatest resident memory is handed back, MiB.
fn memory_mib(rows: usize) -> i64 {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.parquet");
    write(&path, rows);
    let started = std::time::Instant::now();
    let output = Command::new(env!("CARGO_BIN_EXE_anemo"))
        .args(["identify", "--order", "8", "--mesh", "0.006:6000", "--json"])
        .arg(&path)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let model: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(model["provenance"]["rows"], rows);
    // Linux counts in KiB.
    let memory_mib = getrusage(UsageWho::RUSAGE_CHILDREN).unwrap().max_rss() / 1024;
    eprintln!("{rows} rows: {memory_mib} MiB, {:.1} s", started.elapsed().as_secs_f64());
    memory_mib
}

#[test]
fn a_million_rows_are_identified_in_64_mib() {
    let memory_mib = memory_mib(1_000_000);
    assert!(memory_mib <= 64, "{memory_mib} MiB");
}

/// Takes minutes, and 2 GB on the disk: `cargo test --release -p host-sim --test long_record -- --ignored --nocapture`
#[test]
#[ignore = "takes minutes, and 2 GB on the disk"]
fn a_hundred_million_rows_are_identified_in_64_mib() {
    let memory_mib = memory_mib(100_000_000);
    assert!(memory_mib <= 64, "{memory_mib} MiB");
}
