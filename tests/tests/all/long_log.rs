//! A log that goes on for long: every sample is there or was removed on purpose, and the program
//! does not grow, while a page and a broker listen.
//!
//! `cargo xtask campaign log 86400` is a day.

use anemo_tests::Desk;
use recording::Recording;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// If nobody asks for another time.
const SECONDS: u64 = 720;
const RATE_HZ: u64 = 1_000;
const MOST_MIB: f64 = 100.0;
/// The last quarter of a long run may need so much more than the second, MiB. In a short one the
/// queues of the listeners are still filling, as far as a loaded processor lets them.
const GROWTH_MIB: f64 = 5.0;
const WAITING_MIB: f64 = 30.0;
const IS_LONG_S: u64 = 6 * 3_600;

/// Resident memory of a program, MiB; none once it has ended.
fn resident_mib(program: &Child) -> Option<f64> {
    let status = std::fs::read_to_string(format!("/proc/{}/status", program.id())).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    line.split_whitespace().nth(1)?.parse::<f64>().ok().map(|kib| kib / 1024.0)
}

/// A port of the loopback that nobody has.
#[expect(clippy::disallowed_types, reason = "a test, on the loopback")]
fn free_port() -> u16 {
    std::net::TcpListener::bind("127.0.0.1:0").and_then(|listener| listener.local_addr()).unwrap().port()
}

struct Broker(Child);

impl Broker {
    /// mosquitto, where it is installed.
    fn start(desk: &Desk, port: u16) -> Option<Self> {
        let config = desk.path().join("mosquitto.conf");
        std::fs::write(&config, format!("user root\nlistener {port} 127.0.0.1\nallow_anonymous true\n")).unwrap();
        let mut broker = Command::new("mosquitto");
        match broker.arg("-c").arg(&config).stderr(Stdio::null()).stdout(Stdio::null()).spawn() {
            Ok(broker) => Some(Self(broker)),
            Err(error) => {
                println!("mosquitto: {error}; this log is published to a broker that is not there");
                None
            }
        }
    }
}

impl Drop for Broker {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

/// Takes all pictures of a page; returns how many bytes came until it ended.
fn watch(address: &str) -> u64 {
    let (host, path) = address.trim_start_matches("http://").split_once('/').unwrap();
    let mut stream = TcpStream::connect(host).unwrap();
    write!(stream, "GET /{path}events?window=60&width=900 HTTP/1.1\r\nHost: {host}\r\n\r\n").unwrap();
    let mut head = [0; 15];
    stream.read_exact(&mut head).unwrap();
    assert_eq!(&head, b"HTTP/1.1 200 OK");
    std::io::copy(&mut stream, &mut std::io::sink()).unwrap_or_default()
}

#[test]
fn a_log_with_listeners_loses_nothing_and_does_not_grow() {
    let seconds = std::env::var("ANEMO_LOG_S").ok().and_then(|text| text.parse().ok()).unwrap_or(SECONDS);
    let desk = Desk::new("steady.toml", &[("sample_period_s = 0.01", "sample_period_s = 0.001"), ("models = ", "# ")]);
    let port = free_port();
    let broker = Broker::start(&desk, port);
    // A day keeps an hour, half an hour a minute and a quarter.
    let (keep_s, segment_s) = (seconds / 24, seconds / 144);
    let (time, keep, segment) = (format!("{seconds}s"), format!("{keep_s}s"), format!("{segment_s}s"));
    let mqtt = format!("mqtt://127.0.0.1:{port}");
    let arguments =
        ["log", "e.toml", "--on", "sim", "--fast", "-o", "r", "--json", "--for", &time, "--keep", &keep, "--segment"];
    let rest = [segment.as_str(), "--every", "1s", "--publish", &mqtt, "--page", "0"];
    let mut log = desk.command(&[arguments.as_slice(), &rest].concat(), &[]);
    let mut log = log.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut said = BufReader::new(log.stderr.take().unwrap()).lines().map_while(Result::ok);
    let address = said.find_map(|line| line.strip_prefix("anemo: live at ").map(str::to_owned)).unwrap();
    let said = std::thread::spawn(move || said.collect::<Vec<_>>());
    let page = std::thread::spawn(move || watch(&address));

    let begin = Instant::now();
    let mut resident = Vec::new();
    while let Some(mib) = resident_mib(&log) {
        resident.push(mib);
        std::thread::sleep(Duration::from_millis(100));
    }
    let took_s = begin.elapsed().as_secs_f64();
    let output = log.wait_with_output().unwrap();
    let said = said.join().unwrap();
    assert!(output.status.success(), "{said:?}");
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let rows = [&summary["rows"], &summary["lost"], &summary["gaps"]].map(|count| count.as_u64().unwrap());
    assert_eq!(rows, [seconds * RATE_HZ, 0, 0], "{summary} {said:?}");

    let kept = Recording::read(&desk.path().join("r")).unwrap();
    assert!((kept.sample_period_s().unwrap() - 1.0 / RATE_HZ as f64).abs() < 1e-9);
    let last_s = kept.time_s().unwrap().last().copied().unwrap();
    assert!((last_s - (seconds as f64 - 1.0 / RATE_HZ as f64)).abs() < 1e-6, "{last_s}");
    // The kept rows are no less than was asked for, and at most a segment and the journal more.
    let kept_s = kept.len() as u64 / RATE_HZ;
    assert!((keep_s..=keep_s + 2 * segment_s).contains(&kept_s), "{kept_s} s of {keep_s} s");
    let means = Recording::read(&desk.path().join("r/every-1s")).unwrap();
    assert_eq!(means.len() as u64, seconds);

    let quarter = resident.len() / 4;
    let most = |part: &[f64]| part.iter().copied().fold(0.0, f64::max);
    let (early, late, all) = (most(&resident[quarter..2 * quarter]), most(&resident[3 * quarter..]), most(&resident));
    let bytes = page.join().unwrap();
    println!(
        "{seconds} s at {RATE_HZ} Hz in {took_s:.0} s: {} rows, none lost; at most {all:.0} MiB, {early:.0} in the \
        second quarter, {late:.0} in the last; the page took {:.1} MB, the broker was {}",
        rows[0],
        bytes as f64 / 1e6,
        if broker.is_some() { "there" } else { "not there" }
    );
    let growth_mib = if seconds < IS_LONG_S { WAITING_MIB } else { GROWTH_MIB };
    assert!(all <= MOST_MIB && late <= early + growth_mib, "{all} MiB, {early} MiB, then {late} MiB");
    assert!(bytes > 10_000, "{bytes}");
}
