//! Faults by the ten thousand: whatever goes wrong, no heater is on without a fresh, valid reading, and every fault ends in correct readings,
//! a trip or a counted drop.
//!
//! The table of what came of them is a reviewed snapshot: `UPDATE_SNAPSHOTS=1 cargo test … --test injection` writes it anew.

use anemo_tests::calibrated::blown;
use anemo_tests::injection::{Kind, Region, Row, campaign, table, upsets, warm, with_bench};
use anemo_tests::{experiment, file, firmware};
use host_sim::instrument::emulated::{Emulated, Path as Way};
use host_sim::settings;
use std::collections::BTreeMap;

/// Of each kind. With fewer the rare outcomes would not show.
const IN_PROCESS: u32 = 900;
const ON_THE_BOARD: u32 = 15;

fn compare(name: &str, rows: &[Row]) {
    let (text, path) = (table(rows), file("tests/snapshots").join(name));
    println!("{text}");
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        return std::fs::write(&path, &text).expect("the folder is there");
    }
    let reviewed = std::fs::read_to_string(&path).unwrap_or_default();
    assert_eq!(text, reviewed, "{}: review what has changed, then write it anew (top of this test)", path.display());
}

#[test]
fn in_process_every_fault_ends_well() {
    let experiment = experiment("gusts.toml");
    // What it keeps in flash has tests of its own, in the firmware.
    let kinds = Kind::ALL.iter().filter(|&&kind| kind != Kind::PowerCut);
    let rows: Vec<Row> = kinds
        .map(|&kind| with_bench(|mut bench| campaign(&mut bench, &experiment, kind, IN_PROCESS, 20_261_121)))
        .collect();
    assert!(rows.iter().map(|row| row.faults).sum::<u32>() >= 20_000);
    compare("faults_in_process.md", &rows);
}

#[test]
fn on_the_emulated_board_every_fault_ends_well() {
    let experiment = experiment("gusts.toml");
    let kinds = Kind::ALL.iter().filter(|&&kind| kind != Kind::Upset);
    let rows: Vec<Row> = kinds
        .map(|&kind| {
            // What the host's link counts is in the status, and only the USART is counted there.
            let way = if kind.is_counted() { Way::Usart } else { Way::Fifo };
            let folder = tempfile::tempdir().expect("there is room for temporary files");
            let flash = (kind == Kind::PowerCut).then(|| folder.path().join("board.flash"));
            let mut board =
                Emulated::start_with(&firmware(), way, flash.as_deref()).expect("the emulated board starts");
            if flash.is_some() {
                let mut settings = BTreeMap::new();
                settings::of_head(&experiment.head, experiment.sample_period_s, &mut settings)
                    .expect("a head can be kept");
                settings::change(&mut board, &[], &settings).expect("the board keeps it");
            }
            campaign(&mut board, &experiment, kind, ON_THE_BOARD, 20_261_122)
        })
        .collect();
    assert!(rows.iter().map(|row| row.faults).sum::<u32>() >= 300);
    compare("faults_on_the_board.md", &rows);
}

#[test]
fn a_bit_that_flips_anywhere_in_its_ram_heats_nothing() {
    let (firmware, experiment) = (firmware(), blown(60.0, &[]).experiment());
    let began = std::time::Instant::now();
    let warm = warm(&experiment, 20_000);
    println!("warm {:?}", began.elapsed());
    let flips = std::env::var("FLIPS").ok().and_then(|n| n.parse().ok()).unwrap_or(150);
    for region in Region::ALL {
        let all = upsets(&firmware, &experiment, &warm, region, flips, 20_261_123);
        println!("{region:?}: {:?} {} {:?}", all.ends, all.ticks_to_safe, began.elapsed());
        for (end, what, seen) in &all.notable {
            println!("    {end:?}: {what}: {seen}");
        }
    }
}
