//! Common parts of the tests: programs, ports, a feed with a wind that is known.

use dr_core::wind::QualityFlags;
use publish::feed::{Feed, FeedItem, FeedLayout, FeedRow, FeedWind};
use publish::listen::{Listening, Token};
use publish::output::{PublishContext, Publishing};
use std::error::Error;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant, SystemTime};

pub type Tested = Result<(), Box<dyn Error>>;

/// Long enough for a busy machine.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// The program, or a skip that is said.
pub fn program(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::env::split_paths(&path).chain([PathBuf::from("/usr/sbin")]);
    found(name, folders.map(|folder| folder.join(name)).find(|file| file.is_file()))
}

/// Python with what `cargo xtask counterparts` installs.
pub fn python() -> Option<PathBuf> {
    let target = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("..");
    let python = target.join("tools/counterparts/bin/python");
    found("python with pynmea2, pyvisa and playwright", python.is_file().then_some(python))
}

fn found(name: &str, file: Option<PathBuf>) -> Option<PathBuf> {
    if file.is_none() {
        let is_wanted = std::env::var_os("ANEMO_COUNTERPARTS").is_some_and(|wanted| wanted == "all");
        assert!(!is_wanted, "{name} is absent: `cargo xtask counterparts` installs it");
        eprintln!("skipped: {name} is absent (`cargo xtask counterparts` installs it)");
    }
    file
}

/// A program that ends with the test.
pub struct Running(pub Child);

impl Running {
    pub fn start(command: &mut Command) -> std::io::Result<Self> {
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().map(Self)
    }

    /// Output of a program that has ended by itself.
    pub fn printed(mut self) -> Result<String, Box<dyn Error>> {
        let deadline = Instant::now() + PATIENCE;
        while self.0.try_wait()?.is_none() {
            if Instant::now() > deadline {
                return Err("the program does not end".into());
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        let read = |stream: Option<&mut dyn std::io::Read>| {
            let mut text = String::new();
            stream.map(|stream| stream.read_to_string(&mut text)).transpose().map(|_| text)
        };
        let printed = read(self.0.stdout.as_mut().map(|stream| stream as _))?;
        match self.0.wait()?.success() {
            true => Ok(printed),
            false => Err(format!("{printed}{}", read(self.0.stderr.as_mut().map(|stream| stream as _))?).into()),
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

pub fn listening() -> Listening {
    Listening::new(None, Token::new("the-token-of-the-tests").expect("long enough"))
}

/// An address that was free a moment ago.
pub fn free() -> Result<SocketAddr, Box<dyn Error>> {
    Ok(listening().bind(([127, 0, 0, 1], 0).into())?.address())
}

/// Waits until a program listens.
pub fn wait_for(address: SocketAddr) -> Tested {
    wait_until("it listens", || std::net::TcpStream::connect(address).is_ok())
}

pub fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) -> Tested {
    let deadline = Instant::now() + PATIENCE;
    while !is_so() {
        if Instant::now() > deadline {
            return Err(format!("waited too long until {what}").into());
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    Ok(())
}

/// A run at 50 Hz, with a wind of 2.5 m/s from the west in every row, and what is published of it.
pub struct Run {
    pub feed: Feed,
    pub sentences: Arc<Mutex<Vec<String>>>,
    publishing: Option<Publishing>,
    is_over: Arc<AtomicBool>,
    rows: Option<std::thread::JoinHandle<()>>,
}

impl Run {
    pub fn start(address: &str) -> Result<Self, Box<dyn Error>> {
        let layout = FeedLayout {
            title: "mast".to_owned(),
            head: "sphere, \"silver\"".to_owned(),
            elements: vec!["sector-1".to_owned(), "core".to_owned()],
            surfaces: vec!["sector-1".to_owned()],
            sample_period_s: 0.02,
            firmware: "anemo 0.2.0".to_owned(),
            unique_id: [1, 2, 3],
            ..FeedLayout::default()
        };
        let feed = Feed::new(layout);
        let sentences = Arc::new(Mutex::new(Vec::new()));
        let said = sentences.clone();
        let report = Arc::new(move |sentence: &str| said.lock().expect("no panic").push(sentence.to_owned()));
        let context = PublishContext { listening: listening(), commands: None, report };
        let publishing = publish::start(&publish::targets(address)?, &feed, &context)?;
        let is_over = Arc::new(AtomicBool::new(false));
        let (until, rows) = (is_over.clone(), feed.clone());
        let rows = std::thread::spawn(move || {
            let mut tick = 0;
            while !until.load(Ordering::Relaxed) {
                rows.push(&FeedItem::Row(Arc::new(row(f64::from(tick) * 0.02))));
                tick += 1;
                std::thread::sleep(Duration::from_millis(20));
            }
        });
        Ok(Self { feed, sentences, publishing: Some(publishing), is_over, rows: Some(rows) })
    }

    /// Tells whether a sentence was reported that contains this.
    pub fn has_said(&self, part: &str) -> bool {
        self.sentences.lock().expect("no panic").iter().any(|sentence| sentence.contains(part))
    }

    /// Ends it, and gives the outputs that did not say good-bye.
    pub fn end(mut self) -> Vec<String> {
        self.is_over.store(true, Ordering::Relaxed);
        self.rows.take().into_iter().for_each(|rows| rows.join().expect("no panic"));
        let publishing = self.publishing.take();
        drop(self);
        publishing.map(Publishing::join).unwrap_or_default()
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
    }
}

fn row(time_s: f64) -> FeedRow {
    let estimate = wire::WindSample {
        quality_flags: QualityFlags::default(),
        wind_m_s: [0.0, -2.5, 0.0],
        speed_m_s: 2.5,
        across_m_s: 0.0,
        covariance_m2_s2: [0.0; 6],
        speed_error_m_s: 0.125,
        direction_error_rad: 0.1,
        chi_square: 1.0,
        gas_c: 20.0,
        conductance_w_k: [0.001].into_iter().collect(),
        raw_w_k: [0.002].into_iter().collect(),
    };
    FeedRow {
        time_s,
        utc: SystemTime::now(),
        temperature_c: vec![60.5, f32::NAN],
        power_w: vec![0.05, 0.5],
        equivalent_power_w: vec![],
        heaters: 1,
        state: "running".into(),
        wind: Some(FeedWind::new(estimate, &recording::head_mounting::HeadMounting::default())),
        true_wind_m_s: None,
        gas_temperature_c: None,
    }
}
