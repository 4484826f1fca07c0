//! The live page in a real browser: Chromium, headless, driven by Playwright (`live_page.py`).

use std::io::{BufRead, BufReader, Lines, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use publish::commands::{CommandRefusal, FeedCommand, channel};
use publish::feed::{Feed, FeedEvent, FeedEventKind, FeedItem, FeedLayout, FeedRow};
use publish::listen::{Listening, Token};
use publish::page::LivePage;
use serde_json::Value;

use crate::bench;

/// The first line is drawn after this, at the latest.
const DRAWN_MS: f64 = 2000.0;
/// A trip is seen after this.
const TRIP_MS: f64 = 500.0;
/// Memory that an hour at 1 kHz may take in the tab.
const MEMORY_MB: f64 = 300.0;
const HOUR: u32 = 3_600_000;
const ELEMENTS: [&str; 6] = ["sector1", "sector2", "sector3", "sector4", "core1", "core2"];

/// Names by which a screen reader calls what there is.
const NAMES: [&str; 16] = [
    "heading \"Gusts\"",
    "status: Running",
    "button \"Arm\"",
    "button \"Start\"",
    "button \"Stop\"",
    "button \"Acknowledge\"",
    "button \"Self-test\"",
    "combobox \"Window\"",
    "button \"Dark colours\"",
    "img \"Wind rose: where the wind comes from\"",
    "combobox \"Element\"",
    "spinbutton \"Temperature, °C\"",
    "textbox \"Text of the mark\"",
    "img \"Temperature °C\"",
    "img \"Power mW, mean of",
    "combobox \"Channel of the noise spectrum\"",
];

fn row(n: u32, state: &str) -> FeedItem {
    let wave = libm::sin(f64::from(n) * 0.01) as f32;
    FeedItem::Row(Arc::new(FeedRow {
        time_s: f64::from(n) * 0.001,
        utc: SystemTime::now(),
        temperature_c: (0..6).map(|i| 20.0 + wave + 5.0 * i as f32).collect(),
        power_w: vec![0.02; ELEMENTS.len()],
        equivalent_power_w: Vec::new(),
        heaters: n as usize,
        state: state.into(),
        wind: None,
        true_wind_m_s: Some([f64::from(wave), 1.0, 0.0]),
        gas_temperature_c: None,
    }))
}

/// Number of programs that share a processor, by the minute before: times are those of a machine
/// that does nothing else.
fn load() -> f64 {
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let waiting = load.split(' ').next().and_then(|load| load.parse::<f64>().ok()).unwrap_or(0.0);
    (waiting / std::thread::available_parallelism().map_or(1.0, |count| count.get() as f64)).max(1.0)
}

/// The script, which answers each line with one of JSON.
struct Script {
    child: Child,
    input: ChildStdin,
    output: Lines<BufReader<ChildStdout>>,
}

impl Script {
    fn start(python: &Path, chromium: &Path, address: &str) -> Self {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/counterparts/live_page.py");
        let mut command = Command::new(python);
        command.arg(script).arg(address).arg(chromium).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let (input, output) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        Self { child, input, output: BufReader::new(output).lines() }
    }

    fn next(&mut self) -> Value {
        serde_json::from_str(&self.output.next().expect("the script goes on").unwrap()).unwrap()
    }

    fn ask(&mut self, what: &str) -> Value {
        writeln!(self.input, "{what}").unwrap();
        self.next()
    }
}

impl Drop for Script {
    fn drop(&mut self) {
        // It has ended, unless the test fails.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn the_page_draws_alarms_keeps_its_memory_and_has_names() {
    let Some((python, chromium)) = bench::python().zip(bench::program("chromium")) else { return };
    let feed = Feed::new(FeedLayout {
        title: "Gusts".to_owned(),
        elements: ELEMENTS.map(str::to_owned).to_vec(),
        sample_period_s: 0.001,
        ..FeedLayout::default()
    });
    let (commands, requests) = channel();
    let listening = Listening::new(None, Token::random().unwrap());
    let page = LivePage::serve(&feed, Some(commands), &listening, ([127, 0, 0, 1], 0).into()).unwrap();
    (0..1000).for_each(|n| feed.push(&row(n, "running")));
    let mut script = Script::start(&python, &chromium, page.address());

    let opened = script.next();
    let drawn_ms = opened["drawn_ms"].as_f64().unwrap();
    println!("drawn after {drawn_ms:.0} ms");
    assert!(drawn_ms < DRAWN_MS * load(), "{drawn_ms} ms, load {}", load());
    let names = opened["names"].as_str().unwrap();
    let missing: Vec<&str> = NAMES.into_iter().filter(|name| !names.contains(name)).collect();
    assert!(missing.is_empty(), "{missing:?} in\n{names}");

    // An hour, 200 times as fast as it would be.
    let begun = Instant::now();
    for n in 1000..HOUR {
        feed.push(&row(n, "running"));
        if n % 1000 == 0 {
            let due = Duration::from_secs(u64::from(n / 1000)) / 200;
            std::thread::sleep(due.saturating_sub(begun.elapsed()));
        }
    }
    let hour = script.ask("memory");
    println!("{hour}");
    assert!(hour["memory_mb"].as_f64().unwrap() < MEMORY_MB);
    assert_eq!([&hour["missed"], &hour["lost"], &hour["clock"]], ["0", "0", "59:59"]);
    assert!((590..=620).contains(&hour["points"].as_i64().unwrap()));

    let tripped_ms = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs_f64() * 1e3;
    feed.push(&row(HOUR, "tripped:open:sector1"));
    let kind = FeedEventKind::Trip { cause: "open".to_owned(), element: Some("sector1".to_owned()) };
    feed.push(&FeedItem::Event(FeedEvent { time_s: 3600.0, utc: SystemTime::now(), kind }));
    let alarm = script.ask("trip");
    let late_ms = alarm["alarm_ms"].as_f64().unwrap() - tripped_ms;
    println!("trip seen after {late_ms:.0} ms");
    assert!(late_ms < TRIP_MS * load(), "{late_ms} ms, load {}", load());
    assert_eq!(alarm["text"], "Tripped: open, sector1. Heaters are low.");
    assert!(alarm["wide"].as_i64().unwrap() <= 1280, "nothing lies beyond the edge");

    // By the keyboard alone, and refused by the run in its own words.
    let run = std::thread::spawn(move || {
        let request = requests.recv().unwrap();
        assert_eq!(request.command, FeedCommand::Stop);
        request.answer(Err(CommandRefusal("it is tripped".to_owned())));
    });
    let keys = script.ask("keys");
    assert_eq!(keys["answer"], "it is tripped");
    assert_eq!((&keys["outside"], &keys["errors"]), (&Value::Array(Vec::new()), &Value::Array(Vec::new())));
    run.join().unwrap();
}
