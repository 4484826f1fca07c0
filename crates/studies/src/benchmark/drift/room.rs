//! A heater on three relaxations, in a room whose temperature moves by tenths of a kelvin.
//!
//! ```text
//! y = 22 °C + Σ_k R_k x_k + d(t) + e,     dx_k/dt = (u − x_k)/τ_k
//! ```
//!
//! 90 min at 20 Hz of pseudo-random power, 0.012 and 0.12 W, each bit four rows, after a quiet
//! minute in which the body stands; readings have a noise of 8 mK.

use std::f64::consts::TAU;

use diffusive::identify::record::{RecordError, RecordTable};
use diffusive::identify::{DriftGiven, DriftKind};
use diffusive::random::StandardNormal;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;
use rand_distr::Distribution as _;

/// s
pub const SAMPLE_PERIOD_S: f64 = 0.05;
/// Rows of a record.
pub const ROWS: usize = 108_000;
/// Resistances, K/W, and time constants, s.
const RELAXATIONS: [(f64, f64); 3] = [(18.0, 0.8), (55.0, 14.0), (140.0, 240.0)];
const POWERS_W: [f64; 2] = [0.012, 0.12];
const QUIET_ROWS: usize = 1_200;
const ROWS_A_BIT: usize = 4;
const ROOM_C: f64 = 22.0;
const NOISE_K: f64 = 0.008;
/// Distance by which a room moves, K.
const MOVES_K: f64 = 0.15;

/// Motion of a room's temperature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RoomDrift {
    /// Not at all.
    None,
    /// A random walk of 0.15 K in 90 min.
    RandomWalk,
    /// By 0.15 K about its mean, with this correlation time, s.
    Correlated(f64),
    /// A sine of 0.15 K and 5200 s, and 0.1 K an hour.
    Sine,
    /// A door that is opened twice: a fall by 0.15 K that wears off in five minutes.
    Door,
}

impl RoomDrift {
    /// All that are measured.
    pub const ALL: [Self; 7] = [
        Self::None,
        Self::RandomWalk,
        Self::Correlated(60.0),
        Self::Correlated(600.0),
        Self::Correlated(6000.0),
        Self::Sine,
        Self::Door,
    ];

    /// For a table.
    pub fn name(self) -> String {
        match self {
            Self::None => "none".to_owned(),
            Self::RandomWalk => "random walk".to_owned(),
            Self::Correlated(time_s) => format!("correlated for {time_s} s"),
            Self::Sine => "sine and trend".to_owned(),
            Self::Door => "door opened twice".to_owned(),
        }
    }

    /// Drift that a fit is told; `None` where it is no process of the fit's.
    pub fn known(self) -> Option<DriftGiven> {
        match self {
            Self::None => Some(DriftGiven::None),
            Self::RandomWalk => Some(DriftGiven::Kind(DriftKind::RandomWalk)),
            Self::Correlated(_) => Some(DriftGiven::Kind(DriftKind::Correlated)),
            Self::Sine | Self::Door => None,
        }
    }

    fn temperatures(self, random: &mut ChaCha8Rng) -> Vec<f64> {
        let mut normal = || -> f64 { StandardNormal.sample(random) };
        let time_s = |row: usize| row as f64 * SAMPLE_PERIOD_S;
        match self {
            Self::None => vec![0.0; ROWS],
            Self::RandomWalk => {
                let step_k = MOVES_K / (ROWS as f64).sqrt();
                let mut level = 0.0;
                let walk = |_| {
                    level += step_k * normal();
                    level
                };
                (0..ROWS).map(walk).collect()
            }
            Self::Correlated(correlation_s) => {
                let kept = libm::exp(-SAMPLE_PERIOD_S / correlation_s);
                let fresh = MOVES_K * (1.0 - kept * kept).sqrt();
                let mut level = MOVES_K * normal();
                let walk = |_| {
                    level = kept * level + fresh * normal();
                    level
                };
                (0..ROWS).map(walk).collect()
            }
            Self::Sine => {
                let phase = TAU * uniform(normal());
                (0..ROWS)
                    .map(|row| MOVES_K * libm::sin(TAU * time_s(row) / 5200.0 + phase) + 0.1 * time_s(row) / 3600.0)
                    .collect()
            }
            Self::Door => {
                let span_s = time_s(ROWS);
                let opened = [uniform(normal()) * span_s, uniform(normal()) * span_s];
                let after = |row: usize, opened_s: f64| {
                    let since_s = time_s(row) - opened_s;
                    if since_s < 0.0 { 0.0 } else { -MOVES_K * libm::exp(-since_s / 300.0) }
                };
                (0..ROWS).map(|row| opened.iter().map(|&opened_s| after(row, opened_s)).sum()).collect()
            }
        }
    }
}

/// Between 0 and 1, from a normal number.
fn uniform(normal: f64) -> f64 {
    let wide = 1000.0 * normal;
    wide - wide.floor()
}

/// The gain that is to be found, K/W.
pub fn true_gain_k_per_w() -> f64 {
    RELAXATIONS.iter().map(|(resistance, _)| resistance).sum()
}

/// A record of the rig.
///
/// # Errors
/// None but of the table itself.
pub fn record(room: RoomDrift, seed: u64) -> Result<RecordTable, RecordError> {
    record_and_room(room, seed).map(|(record, _)| record)
}

/// The same, with the room's temperature in every row, °C.
///
/// # Errors
/// None but of the table itself.
pub fn record_and_room(room: RoomDrift, seed: u64) -> Result<(RecordTable, Vec<f64>), RecordError> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut bit = 0;
    let mut power = |row: usize| {
        if row.is_multiple_of(ROWS_A_BIT) {
            let normal: f64 = StandardNormal.sample(&mut random);
            bit = usize::from(normal > 0.0);
        }
        POWERS_W[if row < QUIET_ROWS { 0 } else { bit }]
    };
    let power_w: Vec<f64> = (0..ROWS).map(&mut power).collect();
    let room_k = room.temperatures(&mut random);
    let mut states = RELAXATIONS.map(|_| POWERS_W[0]);
    let mut temperature_c = Vec::with_capacity(ROWS);
    for (power, room_k) in power_w.iter().zip(&room_k) {
        let noise: f64 = StandardNormal.sample(&mut random);
        let rise: f64 = RELAXATIONS.iter().zip(&states).map(|((resistance, _), state)| resistance * state).sum();
        temperature_c.push(ROOM_C + rise + room_k + NOISE_K * noise);
        for ((_, time_s), state) in RELAXATIONS.iter().zip(&mut states) {
            *state += -libm::expm1(-SAMPLE_PERIOD_S / time_s) * (power - *state);
        }
    }
    let record = RecordTable::new(
        SAMPLE_PERIOD_S,
        vec![("power_w".to_owned(), power_w)],
        vec![("temperature_c".to_owned(), temperature_c)],
    )?;
    Ok((record, room_k.iter().map(|room_k| ROOM_C + room_k).collect()))
}
