//! Endings of runs and logs at random moments: what was received is there, whatever ended them.
//!
//! `cargo xtask endings N` asks for more of them than a run of all tests has.

use anemo_tests::Desk;
use anemo_tests::fake_board::{FakeBoard, Quirks};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use recording::Recording;
use std::collections::BTreeMap;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Endings, if nobody asks for another number.
const ENDINGS: u32 = 20;
/// At once: each waits most of its time.
const THREADS: u32 = 4;

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Ending {
    Kill,
    Terminate,
    Unplug,
    Reset,
    FullDisk,
}

const ALL: [Ending; 5] = [Ending::Kill, Ending::Terminate, Ending::Unplug, Ending::Reset, Ending::FullDisk];

/// Cost of an ending.
#[derive(Debug, Default)]
struct Cost {
    endings: u32,
    rows: u64,
    lost: u64,
    /// Longest time of one ending, s of the board's time as it passed for the host.
    longest_s: f64,
}

fn desk(period_s: &str) -> Desk {
    let period = format!("sample_period_s = {period_s}\nhost_timeout_s = 0.0");
    Desk::new("steady.toml", &[("sample_period_s = 0.01", &period), ("models = ", "# ")])
}

/// One ending: rows that are there; how many that were received are not, and of a program that was
/// killed, that went out on the cable; and over how long these had come, s.
fn end(ending: Ending, is_log: bool, period_s: &str, random: &mut ChaCha8Rng) -> (u64, u64, f64) {
    let desk = desk(period_s);
    let ticks = 200 + random.next_u32() % 3000;
    let quirks = match ending {
        Ending::Unplug => Quirks { unplugged_at: Some(ticks), ..Quirks::default() },
        Ending::Reset => Quirks { restarts_at: Some(ticks), ..Quirks::default() },
        _ => Quirks::default(),
    };
    let board = FakeBoard::new(&desk.experiment(), quirks);
    let on = format!("serial:{}", board.device);
    let command = if is_log { "log" } else { "run" };
    let mut run = desk.command(&[command, "e.toml", "--on", &on, "-o", "r", "--segment", "10s", "--json"], &[]);
    let run = run.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let deadline = Instant::now() + Duration::from_secs(60);
    // Number that had gone out when.
    let mut history = Vec::new();
    while board.sent() < ticks && Instant::now() < deadline {
        history.push((Instant::now(), board.sent()));
        std::thread::sleep(Duration::from_millis(2));
    }
    let signal = |signal| kill(Pid::from_raw(run.id().try_into().unwrap()), signal).unwrap();
    let sent = board.sent();
    let ended = Instant::now();
    match ending {
        Ending::Kill => signal(Signal::SIGKILL),
        Ending::Terminate | Ending::FullDisk => signal(Signal::SIGTERM),
        Ending::Unplug | Ending::Reset if is_log => {
            // It would wait for ever.
            std::thread::sleep(Duration::from_millis(700));
            signal(Signal::SIGTERM);
        }
        Ending::Unplug | Ending::Reset => {}
    }
    let output = run.wait_with_output().unwrap();
    board.finish();
    if ending == Ending::Kill {
        assert!(desk.anemo(&["recover", "r"], &[]).status.success());
    }
    let recording = Recording::read(&desk.path().join("r")).unwrap();
    // The rows are of the run, and from its beginning: no row twice, and none missing.
    let states = recording.words("state").unwrap();
    let rows = states.iter().take_while(|state| *state == "running").count() as u64;
    let running = recording.clone().between(0.0, (rows - 1) as f64 * period_s.parse::<f64>().unwrap());
    assert!(running.unwrap().sample_period_s().is_ok(), "{ending:?}");
    if ending != Ending::Kill {
        // A row that is still on the cable when a program ends has not been received.
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let received = summary[if is_log { "rows" } else { "ticks" }].as_u64().unwrap();
        return (rows, received - recording.len() as u64, 0.0);
    }
    let lost = u64::from(sent).saturating_sub(rows);
    let last = history.iter().rev().find(|(_, sent)| u64::from(*sent) <= rows).map_or(ended, |(at, _)| *at);
    (rows, lost, if lost > 0 { (ended - last).as_secs_f64() } else { 0.0 })
}

/// A disk of 1 MiB in a namespace of its own; none where the system gives none.
fn fill_disk(random: &mut ChaCha8Rng) -> Option<u64> {
    let desk = Desk::new("steady.toml", &[]);
    let script = "mkdir d && mount -t tmpfs -o size=1m tmpfs d || exit 77; \
        \"$0\" log e.toml --on sim --fast --for ${1}s -o d/r --segment 20s 2> said; code=$?; \
        df d | tail -1 > df; cp -r d/r out; exit $code";
    let for_s = (150 + random.next_u32() % 100).to_string();
    let status = Command::new("unshare")
        .args(["-rm", "sh", "-c", script, &anemo_tests::anemo().display().to_string(), &for_s])
        .current_dir(desk.path())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    let status = status.ok().filter(|status| status.code() != Some(77) && status.code() != Some(1))?;
    let said = std::fs::read_to_string(desk.path().join("said")).unwrap();
    assert!(status.success(), "{status:?} {said}");
    let recording = Recording::read(&desk.path().join("out")).unwrap();
    let time_s = recording.time_s().unwrap();
    let whole = time_s.iter().enumerate().take_while(|(n, time_s)| (**time_s - *n as f64 / 100.0).abs() < 1e-9).count();
    // A missing row was left out of a full disk, and nothing before.
    let last_line = said.lines().last().unwrap();
    let left_out: usize = last_line.split(' ').nth(1).and_then(|count| count.parse().ok()).unwrap_or(0);
    assert_eq!(recording.len() + left_out, 100 * for_s.parse::<usize>().unwrap(), "{said}");
    // A simulation may be through before the recorder meets the end of the disk, and says it then.
    assert!(whole > 1000 && left_out > 0 && said.contains("the disk "), "{whole} {said}");
    Some(whole as u64)
}

#[test]
fn what_was_received_is_there_whatever_ends_it() {
    let endings: u32 = std::env::var("ANEMO_ENDINGS").ok().and_then(|text| text.parse().ok()).unwrap_or(ENDINGS);
    let mut all: BTreeMap<(Ending, &str, bool), Cost> = BTreeMap::new();
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..THREADS)
            .map(|worker| {
                scope.spawn(move || {
                    let ours = (0..endings).filter(move |n| n % THREADS == worker);
                    ours.filter_map(|n| {
                        let mut random = ChaCha8Rng::seed_from_u64(n.into());
                        let ending = ALL[n as usize % ALL.len()];
                        let period_s = ["0.01", "0.001"][n as usize / ALL.len() % 2];
                        let is_log = n / (2 * ALL.len() as u32) % 2 == 1;
                        let cost = match ending {
                            Ending::FullDisk => (fill_disk(&mut random)?, 0, 0.0),
                            ending => end(ending, is_log, period_s, &mut random),
                        };
                        Some(((ending, period_s, is_log), cost))
                    })
                    .collect::<Vec<_>>()
                })
            })
            .collect();
        for (key, (rows, lost, seconds)) in workers.into_iter().flat_map(|worker| worker.join().unwrap()) {
            let cost = all.entry(key).or_default();
            (cost.endings, cost.rows, cost.lost) = (cost.endings + 1, cost.rows + rows, cost.lost + lost);
            cost.longest_s = cost.longest_s.max(seconds);
        }
    });
    println!("ending      period  what  endings      rows   lost  longest loss");
    for ((ending, period_s, is_log), Cost { endings, rows, lost, longest_s }) in &all {
        let (ending, what) = (format!("{ending:?}"), if *is_log { "log" } else { "run" });
        println!("{ending:<10} {period_s:>6} s  {what}  {endings:>7} {rows:>9} {lost:>6}  {longest_s:>6.3} s");
    }
    for ((ending, ..), cost) in &all {
        match ending {
            Ending::Kill => assert!(cost.longest_s <= 1.0, "{ending:?} {cost:?}"),
            _ => assert_eq!(cost.lost, 0, "{ending:?}"),
        }
    }
}
