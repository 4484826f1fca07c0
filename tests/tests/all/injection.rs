//! Faults by the ten thousand: whatever goes wrong, no heater is on without a fresh, valid reading,
//! and every fault ends in correct readings, a trip or a counted drop. And bits that flip anywhere
//! in the board's RAM: of those, what cannot be promised is bounded, and told.
//!
//! The tables of what came of them are reviewed snapshots: `UPDATE_SNAPSHOTS=1 cargo test … --test
//! all injection::` writes them anew.

use anemo_tests::calibrated::blown;
use anemo_tests::injection::{End, Kind, Region, Row, campaign, table, upsets, warm, with_bench};
use anemo_tests::{experiment, file, firmware};
use host_sim::instrument::emulated::{Emulated, EmulatorLink as Way};
use host_sim::settings::{self, Settings};

/// Number of each kind. With fewer the rare outcomes would not show.
const IN_PROCESS: u32 = 900;
const ON_THE_BOARD: u32 = 15;

fn compare(name: &str, text: &str) {
    let path = file("tests/snapshots").join(name);
    println!("{text}");
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        return std::fs::write(&path, text).expect("the folder is there");
    }
    let reviewed = std::fs::read_to_string(&path).unwrap_or_default();
    assert_eq!(text, reviewed, "{}: review what has changed, then write it anew (top of this test)", path.display());
}

#[test]
fn in_process_every_fault_ends_well() {
    let experiment = experiment("gusts.toml");
    // Its settings in flash have tests of its own, in the firmware.
    let kinds = Kind::ALL.iter().filter(|&&kind| kind != Kind::PowerCut);
    let rows: Vec<Row> = kinds
        .map(|&kind| with_bench(|mut bench| campaign(&mut bench, &experiment, kind, IN_PROCESS, 20_261_121)))
        .collect();
    assert!(rows.iter().map(|row| row.faults).sum::<u32>() >= 20_000);
    compare("faults_in_process.md", &table(&rows));
}

#[test]
fn on_the_emulated_board_every_fault_ends_well() {
    let experiment = experiment("gusts.toml");
    let kinds = Kind::ALL.iter().filter(|&&kind| kind != Kind::Upset);
    let rows: Vec<Row> = kinds
        .map(|&kind| {
            // The counters of the host's link are in the status, and only the USART is counted
            // there.
            let way = if kind.is_counted() { Way::Usart } else { Way::Fifo };
            let folder = tempfile::tempdir().expect("there is room for temporary files");
            let flash = (kind == Kind::PowerCut).then(|| folder.path().join("board.flash"));
            let mut board =
                Emulated::start_with(&firmware(), way, flash.as_deref()).expect("the emulated board starts");
            if flash.is_some() {
                let mut settings = Settings::default();
                settings.set_head(&experiment.head, experiment.sample_period_s).expect("a head can be kept");
                settings::write(&mut board, &settings).expect("the board keeps it");
            }
            campaign(&mut board, &experiment, kind, ON_THE_BOARD, 20_261_122)
        })
        .collect();
    assert!(rows.iter().map(|row| row.faults).sum::<u32>() >= 300);
    compare("faults_on_the_board.md", &table(&rows));
}

/// Expected outcomes of the flips in a region: where statics lie, and so what is hit, is another in
/// each build. Shares are of all flips, in per cent.
struct Held {
    region: Region,
    flips: u32,
    /// It runs on as before, trips, starts anew, or is silent and low; messages that did not come
    /// are known.
    well_at_least: u32,
    wrong_wind_at_most: u32,
    wrong_number_at_most: u32,
    /// It runs on, and is not stopped by a command.
    deaf_at_most: u32,
    /// Neither watchdog nor timer is in the emulator to end that.
    no_answer_at_most: u32,
}

const HELD: [Held; 3] = [
    Held {
        region: Region::Statics,
        flips: 150,
        well_at_least: 85,
        wrong_wind_at_most: 8,
        wrong_number_at_most: 5,
        deaf_at_most: 5,
        no_answer_at_most: 5,
    },
    Held {
        region: Region::EachStatic,
        flips: 100,
        well_at_least: 85,
        wrong_wind_at_most: 5,
        wrong_number_at_most: 5,
        deaf_at_most: 10,
        no_answer_at_most: 10,
    },
    Held {
        region: Region::Stack,
        flips: 100,
        well_at_least: 85,
        wrong_wind_at_most: 5,
        wrong_number_at_most: 5,
        deaf_at_most: 10,
        no_answer_at_most: 10,
    },
];

/// The next tick, or the turn of a piece of what the anemometer has been told: 55 on a board of 16
/// elements.
const TICKS_TO_SAFE: u32 = 60;

#[test]
fn a_bit_that_flips_anywhere_in_its_ram_heats_nothing() {
    let (firmware, experiment) = (firmware(), blown(60.0, &[]).experiment());
    let warm = warm(&experiment, 20_000);
    let mut text = "| bits flipped on the board, one a board | flips | as before, dropped, tripped or started anew, at least | wind told wrong, at most | \
                    another number told wrong, at most | deaf to commands, at most | no answer any more, at most | heated otherwise | ticks to heaters low, at most |\n\
                    |---|--:|--:|--:|--:|--:|--:|--:|--:|\n"
        .to_owned();
    let mut felt = 0;
    for held in &HELD {
        let Held {
            region,
            flips,
            well_at_least,
            wrong_wind_at_most,
            wrong_number_at_most,
            deaf_at_most,
            no_answer_at_most,
        } = held;
        let of = upsets(&firmware, &experiment, &warm, *region, *flips, 20_261_123);
        println!("{}: {:?}, {} ticks to heaters low", region.name(), of.ends, of.ticks_to_safe);
        of.notable.iter().for_each(|(end, what, seen)| println!("    {end:?}: {what}: {seen}"));
        let percent = |which: fn(End) -> bool| 100.0 * f64::from(of.count(which)) / f64::from(*flips);
        let [wind, number, deaf, none, otherwise] = [
            percent(|end| end == End::WrongWind),
            percent(|end| end == End::WrongNumber),
            percent(|end| end == End::Deaf),
            percent(|end| end == End::NoAnswer),
            percent(|end| end == End::HeatedOtherwise),
        ];
        assert!(
            100.0 - wind - number - deaf - none - otherwise >= f64::from(*well_at_least),
            "{region:?}: {:?}",
            of.ends
        );
        assert!(wind <= f64::from(*wrong_wind_at_most), "{region:?}: {:?}", of.ends);
        assert!(number <= f64::from(*wrong_number_at_most), "{region:?}: {:?}", of.ends);
        assert!(deaf <= f64::from(*deaf_at_most), "{region:?}: {:?}", of.ends);
        assert!(none <= f64::from(*no_answer_at_most), "{region:?}: {:?}", of.ends);
        assert_eq!(otherwise, 0.0, "{region:?}: {:?}", of.notable);
        felt += of.count(|end| end != End::AsBefore);
        assert!(of.ticks_to_safe <= TICKS_TO_SAFE, "{region:?}: {}", of.ticks_to_safe);
        text += &format!(
            "| {} | {flips} | {well_at_least} % | {wrong_wind_at_most} % | {wrong_number_at_most} % | {deaf_at_most} % | {no_answer_at_most} % | 0 | {TICKS_TO_SAFE} |\n",
            region.name()
        );
    }
    let all: u32 = HELD.iter().map(|held| held.flips).sum();
    // Flips that reach nothing would pass all that. A bit of a small static often does nothing.
    assert!(felt > all / 20, "{felt} of {all} did anything");
    text += &format!("\n{all} flips. No heater was on against the invariant at any tick.\n");
    compare("upsets_on_the_board.md", &text);
}
