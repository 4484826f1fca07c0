//! Progress at a terminal: bars, the table of a running instrument, Ctrl-C, and the pace of a
//! simulation or recording. Without a terminal the table is a line a minute.

use std::fmt::Write as _;
use std::io::{IsTerminal as _, Write as _, stderr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::output::{complain, printable};
use dr_core::wind::QualityFlags;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use recording::head_mounting::HeadMounting;
use recording::{RecordingRow, interrupt};

/// A bar of so many ticks on a terminal, nothing anywhere else.
pub(super) fn progress(title: &str, ticks: Option<u64>) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(ticks, ProgressDrawTarget::stderr_with_hz(10));
    set_template(&bar, "{msg}  {bar:40}  {percent:>3} %  {eta} left");
    bar.set_message(title.to_owned());
    bar
}

fn set_template(bar: &ProgressBar, template: &str) {
    bar.set_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
}

/// Set by the first Ctrl-C (or a request to terminate, or the end of the terminal), so that the run
/// ends tidily and no heater stays on; the second one ends the process at once.
pub(super) fn on_interrupt() -> Arc<AtomicBool> {
    // A program around the command hears of signals itself.
    if let Some(flag) = interrupt::flag() {
        return flag;
    }
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    // Without a handler Ctrl-C still works, only less tidily.
    let _ = ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(1);
        }
    });
    interrupted
}

/// A bar on a terminal, nothing elsewhere.
pub(super) fn progress_bar() -> impl FnMut(&'static str, u64, u64) {
    let bar = ProgressBar::new(1);
    // Choosing cannot tell how far it is, and may take minutes with many event classes: the clock
    // shows that it goes on.
    bar.enable_steady_tick(std::time::Duration::from_millis(500));
    set_template(&bar, "{msg:18} {wide_bar} {percent} % {elapsed}");
    move |what, done, all| {
        end_if_interrupted();
        bar.set_message(what);
        bar.set_length(all.max(1));
        bar.set_position(done);
        if done >= all {
            bar.set_position(0);
        }
    }
}

/// Payload that unwinds from work that shows its progress, once its caller wants its end.
pub(super) struct Ended;

fn end_if_interrupted() {
    if interrupt::is_interrupted() {
        // Unwinding lets go of all that is half done; whoever set the flag catches it.
        std::panic::resume_unwind(Box::new(Ended));
    }
}

/// Longest sleep before another look whether to end.
const LOOK: Duration = Duration::from_millis(50);

/// So many seconds of a run in one of the clock.
pub struct Pace {
    speed: f64,
    begun: Instant,
}

impl Pace {
    /// From now on.
    pub fn new(speed: f64) -> Self {
        Self { speed, begun: Instant::now() }
    }

    /// Waits until a row of this time is due, or somebody asks to end. What is late is made up for.
    pub fn wait(&self, time_s: f64, interrupted: &AtomicBool) {
        let due = Duration::try_from_secs_f64(time_s / self.speed).unwrap_or_default();
        while let Some(left) = due.checked_sub(self.begun.elapsed())
            && !left.is_zero()
            && !interrupted.load(Ordering::Relaxed)
        {
            std::thread::sleep(left.min(LOOK));
        }
    }
}

const DRAW_EVERY: Duration = Duration::from_millis(250);
const LINE_EVERY: Duration = Duration::from_secs(60);

pub(super) struct LiveTable {
    title: String,
    elements: Vec<String>,
    bar: Option<ProgressBar>,
    drawn: Instant,
    rows: u64,
    /// High ticks of each element, and ticks, since the table was drawn.
    high: Vec<u32>,
    ticks: u32,
    /// The last one, as [`recording::wind::numbers`] has it.
    estimate: Vec<f32>,
    mounting: HeadMounting,
    lost: u64,
}

impl LiveTable {
    /// Table of a run of so many ticks, or one whose end is not known; winds come from a head with
    /// this mounting.
    pub fn new(title: &str, elements: Vec<String>, ticks: Option<u64>, mounting: HeadMounting) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::with_draw_target(ticks, ProgressDrawTarget::stderr_with_hz(5));
            set_template(&bar, ticks.map_or("{msg}", |_| "{msg}\n{bar:40}  {percent:>3} %  {eta} left"));
            bar
        });
        let high = vec![0; elements.len()];
        let drawn = Instant::now();
        Self {
            title: printable(title).into_owned(),
            elements: elements.iter().map(|name| printable(name).into_owned()).collect(),
            bar,
            drawn,
            rows: 0,
            high,
            ticks: 0,
            estimate: Vec::new(),
            mounting,
            lost: 0,
        }
    }

    /// Takes a row; `lost` is how many are missing so far.
    pub fn push(&mut self, row: &RecordingRow<'_>, lost: u64) {
        self.rows += 1;
        self.ticks += 1;
        self.lost = lost;
        self.high.iter_mut().enumerate().for_each(|(i, high)| *high += (row.heaters >> i & 1) as u32);
        if row.estimate.iter().any(|number| number.is_finite()) {
            self.estimate.clear();
            self.estimate.extend_from_slice(row.estimate);
        }
        if self.drawn.elapsed() < if self.bar.is_some() { DRAW_EVERY } else { LINE_EVERY } {
            return;
        }
        match &self.bar {
            Some(bar) => {
                bar.set_message(self.table(row));
                bar.set_position(self.rows);
            }
            None => {
                let (rows, wind) = (self.rows, self.wind_text());
                // Nobody reads it, or a full disk takes it: the log goes on.
                let _ = writeln!(stderr(), "{:.0} s, {rows} rows, {lost} lost, {}{wind}", row.time_s, row.state);
            }
        }
        self.drawn = Instant::now();
        self.high.fill(0);
        self.ticks = 0;
    }

    /// Prints a line that stays.
    pub fn say(&self, line: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| complain(line)),
            None => complain(line),
        }
    }

    fn wind_text(&self) -> String {
        let [x, y, z, speed_m_s, _, error_m_s, .., flags] = *self.estimate else { return String::new() };
        if !speed_m_s.is_finite() {
            return String::new();
        }
        let from_deg = self.mounting.from_deg([x, y, z].map(f64::from));
        let has_direction = !QualityFlags(flags as u16).has(QualityFlags::NO_DIRECTION);
        let from = if has_direction { format!(" from {from_deg:.0}°") } else { String::new() };
        format!(", {speed_m_s:.2} ± {error_m_s:.2} m/s{from}, flags {flags}")
    }

    fn table(&self, row: &RecordingRow<'_>) -> String {
        let width = self.elements.iter().map(|name| name.chars().count()).max().unwrap_or(0).max(7);
        let mut text = format!("{} · {:.1} s · {}", self.title, row.time_s, row.state);
        let _ = write!(
            text,
            " · {} lost{}\n{:width$}  temperature   power     duty",
            self.lost,
            self.wind_text(),
            "element"
        );
        for ((name, high), (temperature_c, power_w)) in
            self.elements.iter().zip(&self.high).zip(row.temperature_c.iter().zip(row.power_w))
        {
            let duty = 100.0 * f64::from(*high) / f64::from(self.ticks.max(1));
            let _ = write!(text, "\n{name:width$}  {temperature_c:>8.2} °C  {:>6.2} mW  {duty:>3.0} %", power_w * 1e3);
        }
        text
    }
}

impl Drop for LiveTable {
    fn drop(&mut self) {
        self.bar.iter().for_each(ProgressBar::finish_and_clear);
    }
}
