//! Every example of every help text: it runs, with files that the help texts themselves make.
//!
//! They run in one folder, subcommand by subcommand, on the shipped experiments cut short. Files
//! of the reader's own (`heater.csv`, `three-winds.csv`, `winds.csv`, `heater-second-half.csv`) are
//! made here. What needs a board, the emulator or minutes is only read by the command's parser.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use recording::Recording;

/// Subcommands whose examples make files that others read, in order; all others come behind.
const FIRST: [&str; 13] = [
    "head new",
    "run",
    "identify",
    "validate",
    "model reduce",
    "model export",
    "analyse",
    "design",
    "predict",
    "head identify",
    "model merge",
    "calibrate",
    "wind",
];

/// Examples that are only parsed: a user's own table, a board and its log, the emulator, a killed
/// program.
const PARSED: [&str; 11] = [
    "calibrate speeds.csv",
    "head compare",
    " mast/",
    "serial:",
    "scpi:",
    "--on qemu",
    "board flash",
    "anemo recover",
    "anemo combine",
    "wind everywhere.parquet",
    "wind today.parquet",
];

/// Shorter experiments: longer ticks, fewer and shorter winds.
const SHORTER: [(&str, &[(&str, &str)]); 7] = [
    ("prbs.toml", &[("duration_s = 3600.0", "duration_s = 2400.0")]),
    (
        "wind/sphere-b/identify-*",
        &[
            ("= 0.01\n", "= 0.05\n"),
            ("duration_s = 5400.0", "duration_s = 1800.0"),
            ("bit_time_s = 0.02", "bit_time_s = 0.1"),
        ],
    ),
    (
        "wind/sphere-b/tunnel.toml",
        &[
            ("= 0.001\n", "= 0.02\n"),
            ("duration_s = 3900.0", "duration_s = 1860.0"),
            ("winds = 120", "winds = 60"),
            ("hold_s = 30.0", "hold_s = 26.0"),
        ],
    ),
    (
        "wind/sphere-b/winds.toml",
        &[("= 0.001\n", "= 0.02\n"), ("duration_s = 3060.0", "duration_s = 360.0"), ("winds = 500", "winds = 50")],
    ),
    (
        "wind/rems/identify-*",
        &[
            ("= 0.025\n", "= 0.1\n"),
            ("duration_s = 7200.0", "duration_s = 1800.0"),
            ("bit_time_s = 0.05", "bit_time_s = 0.1"),
        ],
    ),
    (
        "wind/rems/tunnel.toml",
        &[
            ("= 0.005 ", "= 0.02 "),
            ("duration_s = 7800.0", "duration_s = 1900.0"),
            ("winds = 120", "winds = 60"),
            ("hold_s = 60.0", "hold_s = 25.0"),
            ("still_s = 600.0", "still_s = 400.0"),
        ],
    ),
    (
        "wind/rems/winds.toml",
        &[("= 0.005 ", "= 0.02 "), ("duration_s = 6600.0", "duration_s = 1200.0"), ("winds = 200", "winds = 20")],
    ),
];

/// Runs a line of the shell in a folder, with `anemo` on the path.
fn shell(folder: &Path, line: &str) -> Result<String, String> {
    let anemo = Path::new(env!("CARGO_BIN_EXE_anemo")).parent().unwrap();
    let path = format!("{}:{}", anemo.display(), std::env::var("PATH").unwrap());
    let output = Command::new("bash").args(["-ec", line]).current_dir(folder).env("PATH", path).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    if output.status.success() { Ok(text(&output.stdout)) } else { Err(text(&output.stderr)) }
}

/// Help texts by subcommand, that of the command itself under the empty name.
fn helps() -> BTreeMap<String, String> {
    let (mut all, mut open) = (BTreeMap::new(), vec![String::new()]);
    while let Some(command) = open.pop() {
        let help = shell(Path::new("."), &format!("anemo {command} --help")).unwrap();
        // Headings of groups and "Commands:" come before the options.
        let listed = help.lines().take_while(|line| *line != "Options:").filter_map(|line| line.strip_prefix("  "));
        for name in listed.filter_map(|line| line.split(' ').next()) {
            if name.starts_with(|first: char| first.is_ascii_lowercase()) && name != "help" {
                open.push(format!("{command} {name}").trim().to_owned());
            }
        }
        all.insert(command, help);
    }
    all
}

/// The examples of a help text, each with the lines that continue it.
fn examples(help: &str) -> Vec<String> {
    let behind = help.lines().skip_while(|line| !["Example:", "Examples:"].contains(line)).skip(1);
    let mut examples: Vec<String> = Vec::new();
    for line in behind.take_while(|line| line.is_empty() || line.starts_with("  ")) {
        match line.get(2..) {
            Some(line) if ["anemo ", "for ", "sed "].iter().any(|first| line.starts_with(first)) => {
                examples.push(format!("{line}\n"));
            }
            Some(line) => examples.last_mut().unwrap().extend([line, "\n"]),
            None => {}
        }
    }
    examples
}

/// Experiments, cut short, and heads.
fn ship(folder: &Path) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let copied = format!("cp -r {0}/experiments {0}/heads .", root.display());
    shell(folder, &copied).unwrap();
    for (pattern, changes) in SHORTER {
        let files = shell(folder, &format!("ls experiments/{pattern}")).unwrap();
        for path in files.lines().map(|name| folder.join(name)) {
            let text = std::fs::read_to_string(&path).unwrap();
            let shorter = changes.iter().fold(text.clone(), |text, (from, to)| text.replace(from, to));
            assert_ne!(text, shorter, "{}", path.display());
            std::fs::write(path, shorter).unwrap();
        }
    }
}

/// Tables of the reader's own: a body of two poles, and one of one pole in three winds.
fn write_tables(folder: &Path) {
    let bit = |n: usize, held: usize| {
        let mixed = ((n / held + held) as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        (mixed ^ mixed >> 32).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 40 & 1
    };
    let (mut slow, mut fast) = (0.0, 0.0);
    let mut halves = [0, 1].map(|_| "time_s,power,temperature\n".to_owned());
    for n in 0..12_000 {
        let power = if bit(n, 7) == 1 { 0.5 } else { 0.1 };
        let noise = 0.001 * (bit(n, 1) as f64 - 0.5);
        writeln!(halves[n / 6000], "{:.1},{power},{:.5}", 0.1 * n as f64, 20.0 + 50.0 * slow + 20.0 * fast + noise)
            .unwrap();
        slow += (1.0 - libm::exp(-0.1_f64 / 40.0)) * (power - slow);
        fast += (1.0 - libm::exp(-0.1_f64 / 3.0)) * (power - fast);
    }
    std::fs::write(folder.join("heater.csv"), &halves[0]).unwrap();
    std::fs::write(folder.join("heater-second-half.csv"), &halves[1]).unwrap();

    // C dT/dt = P − (G + ΔG) (T − 18 °C)
    let (mut above_k, mut text) = (0.0_f64, "time_s,power,temperature,wind\n".to_owned());
    for n in 0..18_000 {
        let power = if bit(n, 11) == 1 { 0.5 } else { 0.1 };
        let (wind, more_w_k) = [("still", 0.0), ("breeze", 0.004), ("gust", 0.01)][n / 3000 % 3];
        writeln!(text, "{:.1},{power},{:.6},{wind}", 0.1 * n as f64, 18.0 + above_k + 0.001 * (bit(n, 1) as f64 - 0.5))
            .unwrap();
        let rate: f64 = (0.01 + more_w_k) / 0.2;
        above_k += (1.0 - libm::exp(-0.1 * rate)) * (power / (0.01 + more_w_k) - above_k);
    }
    std::fs::write(folder.join("three-winds.csv"), text).unwrap();
}

/// The winds of a tunnel whose own recording does not know them.
fn write_winds(folder: &Path) {
    let tunnel = Recording::read(&folder.join("tunnel.parquet")).unwrap();
    let of = |name| tunnel.numbers(name).unwrap();
    let components = ["true_wind_x_m_s", "true_wind_y_m_s", "true_wind_z_m_s"].map(of);
    let mut text = "event,wind_x_m_s,wind_y_m_s,wind_z_m_s\n".to_owned();
    for (first, _, label) in tunnel.events().unwrap().stretches() {
        let [x, y, z] = components.map(|column| column[first]);
        writeln!(text, "{label},{x},{y},{z}").unwrap();
    }
    std::fs::write(folder.join("winds.csv"), text).unwrap();
}

/// Live pages keep pace with time, and tests have little.
fn hurried(example: &str) -> String {
    example.replace("--speed 10\n", "--speed 1000\n").replace("--speed 20\n", "--speed 1000\n")
}

#[test]
fn every_example_of_every_help_text_runs() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    ship(folder);
    write_tables(folder);
    let helps = helps();
    let others = helps.keys().map(String::as_str).filter(|name| !FIRST.contains(name));
    let mut failed = Vec::new();
    let mut ran = 0;
    for command in FIRST.into_iter().chain(others) {
        for example in examples(&helps[command]) {
            if PARSED.iter().any(|what| example.contains(what)) {
                // Help is asked for last: everything before it has been parsed by then.
                let parsed = format!("{} --help", example.trim_end());
                failed.extend(shell(folder, &parsed).err().map(|error| format!("{example}{error}")));
                continue;
            }
            if example.contains("--winds winds.csv") {
                write_winds(folder);
            }
            let begun = std::time::Instant::now();
            let result = shell(folder, &hurried(&example));
            println!("{:6.2} s  {}", begun.elapsed().as_secs_f64(), example.trim_end());
            failed.extend(result.err().map(|error| format!("{example}{error}")));
            ran += 1;
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
    assert!(ran > 40, "only {ran} examples were found");
}
