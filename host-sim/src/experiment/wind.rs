//! Winds of an experiment, entry by entry or as the runs of a car in a linear tunnel.
//!
//! In a linear tunnel the air rests and a car carries the sensor along a straight track, so that
//! slow winds are known as exactly as the car's speed. `[tunnel]` describes what the car does, in
//! place of `[[wind]]`:
//!
//! | key | unit | meaning |
//! |---|---|---|
//! | `track_m` | m | length of a run |
//! | `speeds_m_min` | m/min | the car goes forward and back at the first speed, then at the second …, and begins anew until the experiment ends |
//! | `pause_s` | s | rest after each run; 0 turns at once |
//! | `first_pause_s` | s | rest before the first run; 0 if not given |
//! | `order_seed` | | each time round the speeds come in another order, drawn with this seed; without it as they are written |
//! | `azimuth_deg`, `elevation_deg` | ° | into which the air goes, seen from the car, when it runs forward; 180 and 0 if not given: x looks forward |
//!
//! It becomes ordinary entries with the labels `forward 7.5 m/min`, `back 7.5 m/min` and `rest`,
//! which are the event classes of an identification. A run ends with the last whole sample period
//! that fits on the track.
//!
//! `[[wind]]` becomes entries as it is written. The simulated wind judges the ranges of gusts, sines
//! and turbulence.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use recording::toml_file::{FileError, TomlSource};

use super::grid::TickGrid;
use super::table::{SpectrumName, TunnelTable, TurbulenceTable, WindTable};
use crate::sensor::{Spectrum, Turbulence, WindEntry};

pub(super) const HIGHEST_SPEED_M_S: f64 = 100.0;
/// More would be a mistake of units rather than an experiment.
const MOST_ENTRIES: usize = 100_000;

/// A run at one of the car's speeds.
struct Run {
    speed_m_min: f64,
    ticks: u32,
}

impl Run {
    /// Entry that begins at a tick.
    fn entry(&self, grid: &TickGrid, table: &TunnelTable, tick: u32, forward: bool) -> WindEntry {
        let (way, azimuth_deg, elevation_deg) = match forward {
            true => ("forward", table.azimuth_deg, table.elevation_deg),
            false => ("back", (table.azimuth_deg + 180.0) % 360.0, -table.elevation_deg),
        };
        let (label, speed_m_s) = match self.speed_m_min {
            0.0 => ("rest".to_owned(), 0.0),
            speed_m_min => (format!("{way} {speed_m_min} m/min"), speed_m_min / 60.0),
        };
        let start_s = grid.time_s(tick);
        WindEntry { start_s, label, speed_m_s, azimuth_deg, elevation_deg, ..WindEntry::default() }
    }
}

/// The entries of an experiment.
pub(super) fn tunnel_entries(grid: &TickGrid, table: &TunnelTable) -> Result<Vec<WindEntry>, FileError> {
    let mut runs = runs(grid, table)?;
    let rest = Run { speed_m_min: 0.0, ticks: grid.pause_ticks("tunnel.pause_s", table.pause_s)? };
    let first_rest = Run { ticks: grid.pause_ticks("tunnel.first_pause_s", table.first_pause_s)?, ..rest };
    let mut order = table.order_seed.map(ChaCha8Rng::seed_from_u64);
    let mut entries = Vec::new();
    let mut now = 0;
    if first_rest.ticks > 0 {
        entries.push(first_rest.entry(grid, table, now, true));
        now += first_rest.ticks;
    }
    loop {
        if let Some(order) = &mut order {
            shuffle(&mut runs, order);
        }
        for (run, forward) in runs.iter().flat_map(|run| [(run, true), (&rest, true), (run, false), (&rest, true)]) {
            if now >= grid.ticks {
                return Ok(entries);
            }
            if entries.len() >= MOST_ENTRIES {
                let sentence = format!(
                    "makes more than {MOST_ENTRIES} runs and pauses: a longer track, or a shorter experiment, would not"
                );
                return Err(grid.source.refuse("tunnel", sentence));
            }
            if run.ticks > 0 {
                entries.push(run.entry(grid, table, now, forward));
                now = now.saturating_add(run.ticks);
            }
        }
    }
}

/// The runs in the order in which their speeds are written.
fn runs(grid: &TickGrid, table: &TunnelTable) -> Result<Vec<Run>, FileError> {
    let source = grid.source;
    let track_m = source.positive("tunnel.track_m", table.track_m, "m")?;
    let key = "tunnel.speeds_m_min";
    if table.speeds_m_min.is_empty() {
        return Err(source.refuse(key, "is empty: at least one speed of the car belongs there"));
    }
    // The words that the entries' own check would say of an entry that nobody wrote.
    if !table.azimuth_deg.is_finite() {
        let sentence = format!("is {}: it must be a finite angle", table.azimuth_deg);
        return Err(source.refuse("tunnel.azimuth_deg", sentence));
    }
    source.within("tunnel.elevation_deg", table.elevation_deg, -90.0..=90.0, "°")?;
    let run = |&speed_m_min: &f64| {
        source.positive(key, speed_m_min, "m/min")?;
        source.within(key, speed_m_min, 0.0..=60.0 * HIGHEST_SPEED_M_S, "m/min")?;
        let (run_s, period_s) = (60.0 * track_m / speed_m_min, grid.sample_period_s);
        // A run that is a whole number of periods but for rounding is that number.
        let ticks = (run_s / period_s + 1e-6).floor();
        if ticks < 1.0 {
            let sentence = format!(
                "has {speed_m_min} m/min, at which {track_m} m take {run_s} s: a run lasts at least one sample period, {period_s} s"
            );
            return Err(source.refuse(key, sentence));
        }
        Ok(Run { speed_m_min, ticks: ticks as u32 })
    };
    table.speeds_m_min.iter().map(run).collect()
}

/// Fisher and Yates; every order is as likely.
fn shuffle(runs: &mut [Run], order: &mut ChaCha8Rng) {
    for last in (1..runs.len()).rev() {
        // A product instead of a remainder: no bias worth naming.
        let chosen = (u128::from(order.next_u64()) * (last as u128 + 1)) >> 64;
        runs.swap(last, chosen as usize);
    }
}

/// The entries of `[[wind]]`.
pub(super) fn held_entries(grid: &TickGrid, tables: &[WindTable]) -> Result<Vec<WindEntry>, FileError> {
    let source = grid.source;
    let mut entries = Vec::with_capacity(tables.len());
    let ends = tables.iter().skip(1).map(|next| next.start_s).chain([grid.end_s()]);
    for ((index, table), end_s) in tables.iter().enumerate().zip(ends) {
        let key = format!("wind[{index}]");
        // Starts, angles and what blows on top are the simulated wind's to judge.
        source.within(&format!("{key}.speed_m_s"), table.speed_m_s, 0.0..=HIGHEST_SPEED_M_S, "m/s")?;
        grid.check_start(&format!("{key}.start_s"), table.start_s)?;
        // A wind that nobody would feel is a mistake.
        let lasts_s = end_s - table.start_s;
        let gust = table.gust.map(|gust| ("gust.start_s", gust.start_s));
        let devil = table.dust_devil.map(|devil| ("dust_devil.time_s", devil.time_s));
        for (what, time_s) in gust.into_iter().chain(devil) {
            if lasts_s > 0.0 && time_s >= lasts_s {
                let sentence = format!("is {time_s} s after the start of a wind that is over after {lasts_s} s");
                return Err(source.refuse(&format!("{key}.{what}"), sentence));
            }
        }
        let turbulence = table.turbulence.as_ref().map(|table| table.turbulence(source, &format!("{key}.turbulence")));
        entries.push(WindEntry {
            start_s: table.start_s,
            // After its number, so that every event of a recording has a name.
            label: table.label.clone().unwrap_or_else(|| format!("wind {}", index + 1)),
            speed_m_s: table.speed_m_s,
            azimuth_deg: table.azimuth_deg,
            elevation_deg: table.elevation_deg,
            swing: table.swing,
            sine: table.sine,
            gust: table.gust,
            dust_devil: table.dust_devil,
            turbulence: turbulence.transpose()?,
        });
    }
    Ok(entries)
}

impl TurbulenceTable {
    /// Refuses scales of another spectrum under `key`.
    pub fn turbulence(&self, source: &TomlSource, key: &str) -> Result<Turbulence, FileError> {
        let scales =
            [("correlation_time_s", self.correlation_time_s), ("length_m", self.length_m), ("height_m", self.height_m)];
        let (of, (own, scale)) = match self.spectrum {
            None => ("turbulence without a `spectrum`", scales[0]),
            Some(SpectrumName::VonKarman) => ("spectrum \"von-karman\"", scales[1]),
            Some(SpectrumName::Kaimal) => ("spectrum \"kaimal\"", scales[2]),
        };
        if let Some((name, _)) = scales.iter().find(|(name, scale)| scale.is_some() && *name != own) {
            let sentence = format!("does not go with {of}, whose scale is `{own}`");
            return Err(source.refuse(&format!("{key}.{name}"), sentence));
        }
        let missing = || source.refuse(&format!("{key}.{own}"), format!("is missing: it is the scale of {of}"));
        let scale = scale.ok_or_else(missing)?;
        let spectrum = match self.spectrum {
            None => Spectrum::Relaxation { correlation_time_s: scale },
            Some(SpectrumName::VonKarman) => Spectrum::VonKarman { length_m: scale },
            Some(SpectrumName::Kaimal) => Spectrum::Kaimal { height_m: scale },
        };
        Ok(Turbulence { intensity: self.intensity, spectrum })
    }
}

#[cfg(test)]
mod tests {
    use crate::experiment::Experiment;
    use recording::toml_file::TomlSource;

    fn with(tunnel: &str) -> Result<Experiment, String> {
        let text = format!(
            "title = \"Tunnel\"\nhead = \"../heads/rems.toml\"\nsample_period_s = 0.025\nduration_s = 300.0\n\n\
             [gas]\nspecies = \"air\"\npressure_pa = 24000.0\ntemperature_c = 21.0\n\n[tunnel]\n{tunnel}\n"
        );
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments/tunnel.toml");
        Experiment::from_source(TomlSource { path, text }).map_err(|error| error.to_string())
    }

    #[test]
    fn a_car_goes_forward_and_back_with_pauses_until_the_end() {
        let experiment = with("track_m = 5.0\nspeeds_m_min = [7.5]\npause_s = 40.0").unwrap();
        let seen: Vec<_> = experiment.wind.iter().map(|entry| (entry.start_s, entry.label.as_str())).collect();
        // 5 m at 7.5 m/min are 40 s, as published.
        let expected = ["forward 7.5 m/min", "rest", "back 7.5 m/min", "rest"];
        let expected: Vec<_> = (0..8_u8).map(|k| (40.0 * f64::from(k), expected[usize::from(k) % 4])).collect();
        assert_eq!(seen, expected);
        // The sensor's x looks forward: the air comes from there, and from behind on the way back.
        let [forward, back] = [0, 2].map(|k| experiment.wind[k].mean_m_s());
        assert!((forward[0] + 0.125).abs() < 1e-12 && (back[0] - 0.125).abs() < 1e-12, "{forward:?} {back:?}");
        assert_eq!(experiment.wind[1].mean_m_s().map(f64::abs), [0.0; 3]);
        // 40 s are 1600 ticks.
        assert_eq!(
            [0, 1599, 1600, 3200].map(|tick| experiment.event(tick)),
            [expected[0].1, expected[0].1, "rest", expected[2].1]
        );
    }

    #[test]
    fn speeds_take_turns_and_a_seed_draws_their_order() {
        let forward = |more: &str| -> Vec<String> {
            let tunnel = format!("track_m = 0.5\nspeeds_m_min = [6.0, 12.0, 30.0]\npause_s = 1.0\n{more}");
            let wind = with(&tunnel).unwrap().wind;
            wind.iter().filter_map(|entry| entry.label.strip_prefix("forward ").map(str::to_owned)).collect()
        };
        let in_turn = forward("");
        assert_eq!(in_turn[..4], ["6 m/min", "12 m/min", "30 m/min", "6 m/min"]);
        let drawn = forward("order_seed = 1");
        assert_eq!(drawn, forward("order_seed = 1"));
        assert_ne!(drawn, forward("order_seed = 2"));
        assert_ne!(drawn, in_turn);
        // Each time round has every speed once.
        for round in drawn.chunks_exact(3) {
            let mut round = round.to_vec();
            round.sort();
            assert_eq!(round, ["12 m/min", "30 m/min", "6 m/min"]);
        }
    }

    #[test]
    fn a_run_ends_with_the_last_period_on_the_track() {
        // 5 m at 7 m/min are 42.857 s, 1714.3 periods of 25 ms.
        let experiment = with("track_m = 5.0\nspeeds_m_min = [7.0]\npause_s = 10.0\nfirst_pause_s = 5.0").unwrap();
        let starts: Vec<_> = experiment.wind[..4].iter().map(|entry| entry.start_s).collect();
        assert_eq!(starts, [0.0, 5.0, 47.85, 57.85]);
        // Turned at once there is no rest at all.
        let wind = with("track_m = 5.0\nspeeds_m_min = [7.0]\npause_s = 0.0").unwrap().wind;
        assert!(wind.iter().all(|entry| entry.speed_m_s > 0.0) && wind.len() == 8, "{}", wind.len());
    }

    #[test]
    fn yaw_and_pitch_turn_with_the_car() {
        let tunnel = "track_m = 5.0\nspeeds_m_min = [7.5]\npause_s = 40.0\nazimuth_deg = 210.0\nelevation_deg = -20.0";
        let wind = with(tunnel).unwrap().wind;
        let (forward, back) = (wind[0].mean_m_s(), wind[2].mean_m_s());
        assert!((0..3).all(|k| (forward[k] + back[k]).abs() < 1e-12), "{forward:?} {back:?}");
        assert_eq!((wind[2].azimuth_deg, wind[2].elevation_deg), (30.0, 20.0));
    }

    #[test]
    fn what_no_car_can_do_is_refused() {
        let good = "track_m = 5.0\nspeeds_m_min = [7.5]\npause_s = 40.0";
        for (from, to, expected) in [
            ("track_m = 5.0", "track_m = 0.0", "`tunnel.track_m` is 0 m: it must be finite and above 0 m"),
            ("[7.5]", "[]", "`tunnel.speeds_m_min` is empty"),
            ("[7.5]", "[7.5, -7.5]", "`tunnel.speeds_m_min` is -7.5 m/min: it must be finite and above 0 m/min"),
            ("[7.5]", "[6001.0]", "`tunnel.speeds_m_min` is 6001 m/min: it must lie between 0 and 6000 m/min"),
            ("track_m = 5.0", "track_m = 0.001", "a run lasts at least one sample period, 0.025 s"),
            (
                "pause_s = 40.0",
                "pause_s = 0.03",
                "`tunnel.pause_s` is 0.03 s, which is not a whole number of sample periods",
            ),
            ("pause_s = 40.0", "pause_s = -1.0", "`tunnel.pause_s` is -1 s: it must be finite and 0 s or more"),
            (
                "pause_s = 40.0",
                "pause_s = 40.0\nfirst_pause_s = nan",
                "`tunnel.first_pause_s` is NaN s: it must be finite and 0 s or more",
            ),
            ("pause_s = 40.0", "pause_s = 40.0\nelevation_deg = 91.0", "`tunnel.elevation_deg` is 91 °"),
            (
                "pause_s = 40.0",
                "pause_s = 40.0\nazimuth_deg = nan",
                "`tunnel.azimuth_deg` is NaN: it must be a finite angle",
            ),
            ("pause_s = 40.0", "pause = 40.0", "unknown key `pause`; did you mean `pause_s`?"),
            (
                "pause_s = 40.0",
                "pause_s = 40.0\n\n[[wind]]\nstart_s = 0.0\nspeed_m_s = 1.0",
                "`tunnel` is given besides [[wind]]",
            ),
        ] {
            let sentence = with(&good.replace(from, to)).unwrap_err();
            assert!(sentence.contains(expected), "{to}: {sentence}");
            assert!(sentence.contains("tunnel.toml, line ") && !sentence.contains('\n'), "{sentence}");
        }
    }
}
