//! What an instrument does now, at a terminal: a table that is drawn anew; one line a minute where
//! there is none.

use std::fmt::Write as _;
use std::io::IsTerminal as _;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use publish::feed::{FeedRow, FeedWind};

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
    wind: Option<FeedWind>,
    lost: u64,
}

impl LiveTable {
    pub fn new(title: &str, elements: Vec<String>) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(5));
            bar.set_style(ProgressStyle::with_template("{msg}").unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar
        });
        let high = vec![0; elements.len()];
        let drawn = Instant::now();
        Self { title: title.to_owned(), elements, bar, drawn, rows: 0, high, ticks: 0, wind: None, lost: 0 }
    }

    /// Takes a row; `lost` is how many are missing so far.
    pub fn push(&mut self, row: &FeedRow, lost: u64) {
        self.rows += 1;
        self.ticks += 1;
        self.lost = lost;
        self.high.iter_mut().enumerate().for_each(|(i, high)| *high += u32::from(row.heaters >> i & 1));
        if row.wind.is_some() {
            self.wind.clone_from(&row.wind);
        }
        if self.drawn.elapsed() < if self.bar.is_some() { DRAW_EVERY } else { LINE_EVERY } {
            return;
        }
        match &self.bar {
            Some(bar) => bar.set_message(self.table(row)),
            None => {
                eprintln!("{:.0} s, {} rows, {} lost, {}{}", row.time_s, self.rows, lost, row.state, self.wind_text())
            }
        }
        self.drawn = Instant::now();
        self.high.fill(0);
        self.ticks = 0;
    }

    /// Prints a line that stays.
    pub fn say(&self, line: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| eprintln!("anemo: {line}")),
            None => eprintln!("anemo: {line}"),
        }
    }

    fn wind_text(&self) -> String {
        let Some(wind) = self.wind.as_ref().filter(|wind| wind.is_valid()) else { return String::new() };
        let from = if wind.has_direction() { format!(" from {:.0}°", wind.from_deg) } else { String::new() };
        let flags = wind.estimate.quality_flags.0;
        format!(", {:.2} ± {:.2} m/s{from}, flags {flags}", wind.estimate.speed_m_s, wind.estimate.speed_error_m_s)
    }

    fn table(&self, row: &FeedRow) -> String {
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
            self.elements.iter().zip(&self.high).zip(row.temperature_c.iter().zip(&row.power_w))
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
