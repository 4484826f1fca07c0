use diffusive::random::StandardNormal;
use dr_core::model::{
    ConvectionObserver, ConvectionObserverState, GainsConfig, NetworkSelfHeatingConfig, ORDER, TickInput,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;
use rand_distr::Distribution as _;

use super::*;
use crate::network::from_model::sections;
use crate::network::from_model::share;

/// An element like one of sphere A's: behind a film and a ceramic of 0.6 s.
const RATES: [f64; 4] = [0.00296, 0.0306, 1.69, 126.9];
const R: [f64; 4] = [459.6, 72.11, 124.5, 6.204];
const REST_C: f64 = -44.6;
const POWER_W: f64 = 0.03;
const NOISE: ReadingNoise = ReadingNoise { low_k: 0.5e-3, high_k: 0.5e-3 };

fn shares(layers: usize) -> Vec<f64> {
    let found = sections(&RATES, &R, layers).unwrap();
    RATES.iter().map(|&rate| share(&found, rate)).collect()
}

fn element(layers: usize) -> SelfHeatingParameters {
    SelfHeatingParameters {
        element: 0,
        name: "element".to_owned(),
        rest_c: REST_C,
        noise: NOISE,
        mesh_rad_s: RATES.to_vec(),
        r_k_per_w: R.to_vec(),
        surface: Some(shares(layers)),
        layers: Vec::new(),
    }
}

fn plant(own: &SelfHeatingParameters, sample_period_s: f64) -> Plant<'_> {
    Plant { own, sample_period_s }
}

/// The truth in f64, with its own convection.
struct TrueElement<'a> {
    gains: Vec<f64>,
    surface: &'a [f64],
    x: Vec<f64>,
}

impl<'a> TrueElement<'a> {
    /// Settled without convection.
    fn new(plant: &Plant<'a>) -> Self {
        Self { gains: plant.gains(), surface: plant.own.surface.as_deref().unwrap(), x: vec![POWER_W; 4] }
    }

    fn temperature_c(&self) -> f64 {
        REST_C + self.x.iter().zip(R).map(|(x, r)| x * r).sum::<f64>()
    }

    fn step(&mut self, q: f64) {
        for ((x, g), m) in self.x.iter_mut().zip(&self.gains).zip(self.surface) {
            *x += g * (POWER_W - m * q - *x);
        }
    }
}

/// The filter written out in f64, in the form of the textbook: predicted, then corrected.
struct TextbookLoop<'a> {
    truth: TrueElement<'a>,
    q: f64,
}

impl TextbookLoop<'_> {
    fn step(&mut self, filter: &KalmanFilter, temperature_c: f64) -> f64 {
        let e = temperature_c - self.truth.temperature_c();
        self.q -= filter.convection_w_per_k * e;
        for (k, x) in self.truth.x.iter_mut().enumerate() {
            *x += filter.correction_w_per_k[k] * self.truth.gains[k] / (1.0 - self.truth.gains[k]) * e;
        }
        self.truth.step(self.q);
        self.q
    }
}

/// The same on the board's network.
struct BoardLoop {
    network: ConvectionObserver<1>,
    state: ConvectionObserverState<1>,
}

impl BoardLoop {
    fn new(plant: &Plant<'_>, filter: &KalmanFilter) -> Self {
        let padded = |values: &[f64], with: f32| -> [f32; ORDER] {
            std::array::from_fn(|k| values.get(k).map_or(with, |&value| value as f32))
        };
        let mut mesh_rad_s = padded(&RATES, 0.0);
        (4..ORDER).for_each(|k| mesh_rad_s[k] = 1e3 * k as f32);
        let config = NetworkSelfHeatingConfig {
            mesh_rad_s,
            r_k_per_w: padded(&R, 0.0),
            surface: padded(plant.own.surface.as_deref().unwrap(), 1.0),
            rest_c: REST_C as f32,
            gains: GainsConfig {
                correction_w_per_k: padded(&filter.correction_w_per_k, 0.0),
                convection_w_per_k: filter.convection_w_per_k as f32,
                weights: filter.weights.map(|weight| weight as f32),
                variance_w2: (filter.noise_w * filter.noise_w) as f32,
            },
            alarm: None,
        };
        let mut network = ConvectionObserver::default();
        network.set_self_heating(0, &config, plant.sample_period_s as f32).unwrap();
        Self { network, state: ConvectionObserverState::default() }
    }

    fn step(&mut self, temperature_c: f64) -> f64 {
        let look = TickInput {
            temperature_c: &[temperature_c as f32],
            valid: 1,
            read_high: 0,
            power_w: &[POWER_W as f32],
            standing_w: &[POWER_W as f32],
        };
        f64::from(self.network.step(&mut self.state, &look).unwrap().power_w[0])
    }
}

fn spread(of: &[f64]) -> f64 {
    let mean = of.iter().sum::<f64>() / of.len() as f64;
    (of.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / of.len() as f64).sqrt()
}

#[test]
fn the_noise_of_the_convective_power_is_as_foretold_in_f64_and_on_the_board() {
    // 200 s of 5 Hz are some 2000 independent values: 1.6 % of the figure. The board's f32 steps of
    // T, 4 µK, are nothing against 0.5 mK.
    for (layers, ts, bandwidth_hz) in
        [(0, 0.001, 5.0), (1, 0.001, 5.0), (2, 0.001, 5.0), (2, 0.01, 2.0), (2, 0.001, 0.5)]
    {
        let own = element(layers);
        let plant = plant(&own, ts);
        let filter = design(&plant, bandwidth_hz).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let truth = TrueElement::new(&plant);
        let (mut exact, mut board) =
            (TextbookLoop { truth: TrueElement::new(&plant), q: 0.0 }, BoardLoop::new(&plant, &filter));
        board.step(truth.temperature_c());
        let (mut q_exact, mut q_board) = (Vec::new(), Vec::new());
        let (settle, all) = ((20.0 / ts) as usize, ((20.0 + 1000.0 / bandwidth_hz) / ts) as usize);
        for n in 0..all {
            let noise: f64 = StandardNormal.sample(&mut rng);
            let temperature_c = truth.temperature_c() + NOISE.low_k * noise;
            let found = (exact.step(&filter, temperature_c), board.step(temperature_c));
            if n >= settle {
                q_exact.push(found.0);
                q_board.push(found.1);
            }
        }
        let ratios = (spread(&q_exact) / filter.noise_w, spread(&q_board) / filter.noise_w);
        println!(
            "{layers} layers, {ts} s, {bandwidth_hz} Hz: noise {:.3e} W, f64 {:.3}, board {:.3}",
            filter.noise_w, ratios.0, ratios.1
        );
        assert!((ratios.0 - 1.0).abs() < 0.1 && (ratios.1 - 1.0).abs() < 0.1, "{ratios:?}");
    }
}

/// Amplitude of the estimated q for a q of 1 mW that swings, by correlation over whole periods.
fn swing(plant: &Plant<'_>, hz: f64, mut estimate: impl FnMut(f64) -> f64) -> f64 {
    let mut truth = TrueElement::new(plant);
    let periods = (1.0 / (hz * plant.sample_period_s)).round();
    let omega = std::f64::consts::TAU / periods;
    let (mut sine, mut cosine, mut count) = (0.0, 0.0, 0.0);
    for n in 0..(60.0 * periods) as usize {
        let phase = omega * n as f64;
        let found = estimate(truth.temperature_c());
        truth.step(1e-3 * libm::sin(phase));
        if n as f64 >= 40.0 * periods {
            (sine, cosine, count) = (sine + found * libm::sin(phase), cosine + found * libm::cos(phase), count + 0.5);
        }
    }
    1e3 * libm::hypot(sine / count, cosine / count)
}

#[test]
fn the_bandwidth_is_what_was_asked_for_on_the_board() {
    for (layers, ts, bandwidth_hz) in
        [(0, 0.001, 0.5), (0, 0.001, 50.0), (1, 0.001, 10.0), (1, 0.001, 50.0), (1, 0.01, 5.0), (2, 0.001, 1.0)]
    {
        let own = element(layers);
        let plant = plant(&own, ts);
        let filter = design(&plant, bandwidth_hz).unwrap();
        assert!((filter.bandwidth_hz / bandwidth_hz - 1.0).abs() < 1e-4, "{}", filter.bandwidth_hz);
        let at = |factor: f64| {
            let mut board = BoardLoop::new(&plant, &filter);
            swing(&plant, factor * bandwidth_hz, |temperature_c| board.step(temperature_c))
        };
        let (below, above) = (at(0.95), at(1.05));
        println!(
            "{layers} layers, {ts} s: {bandwidth_hz} Hz, answers {below:.4} and {above:.4} of 5 % less and more, noise {:.2e} W",
            filter.noise_w
        );
        assert!(below > 0.5f64.sqrt() && above < 0.5f64.sqrt(), "{below} {above}");
    }
}

#[test]
fn in_f64_any_bandwidth_is_to_be_had_behind_two_layers() {
    let own = element(2);
    for (ts, bandwidth_hz) in [(0.001, 0.5), (0.001, 20.0), (0.001, 50.0), (0.01, 5.0), (0.01, 10.0)] {
        let plant = plant(&own, ts);
        let filter = design(&plant, bandwidth_hz).unwrap();
        let at = |factor: f64| {
            let mut exact = TextbookLoop { truth: TrueElement::new(&plant), q: 0.0 };
            swing(&plant, factor * bandwidth_hz, |temperature_c| exact.step(&filter, temperature_c))
        };
        let (below, above) = (at(0.95), at(1.05));
        println!(
            "2 layers, {ts} s: {bandwidth_hz} Hz, answers {below:.4} and {above:.4}, noise {:.2e} W",
            filter.noise_w
        );
        // Periods are whole samples: of 10 ms and 9.5 Hz eleven, which are 9.09 Hz.
        assert!(below > 0.5f64.sqrt() && above < 0.5f64.sqrt(), "{below} {above}");
    }
}

#[test]
fn a_step_of_the_wind_is_there_in_half_a_period_and_overshoots_little() {
    for (layers, hz) in [(0, 5.0), (1, 5.0), (2, 1.0)] {
        let own = element(layers);
        let plant = plant(&own, 0.001);
        let filter = design(&plant, hz).unwrap();
        let (mut truth, mut board) = (TrueElement::new(&plant), BoardLoop::new(&plant, &filter));
        board.step(truth.temperature_c());
        let answer: Vec<f64> = (0..120_000)
            .map(|_| {
                let found = board.step(truth.temperature_c());
                truth.step(1e-3);
                1e3 * found
            })
            .collect();
        let half_s = 1e-3 * answer.iter().position(|q| *q >= 0.5).unwrap() as f64;
        let greatest = answer.iter().copied().fold(0.0, f64::max);
        let settled = 1e-3 * answer.iter().rposition(|q| (q - 1.0).abs() > 0.02).unwrap() as f64;
        println!(
            "{layers} layers, {hz} Hz: half after {half_s:.3} s, overshoot {:.1} %, within 2 % after {settled:.3} s",
            100.0 * (greatest - 1.0)
        );
        assert!(half_s < 0.5 / hz && greatest < 1.2 && settled < 4.0 / hz, "{half_s} {greatest} {settled}");
        // Without a lasting error, long after.
        assert!((answer[119_999] - 1.0).abs() < 2e-3, "{}", answer[119_999]);
    }
}

#[test]
fn an_element_without_a_surface_finds_heat_that_its_model_does_not_have() {
    let own = SelfHeatingParameters { surface: None, ..element(0) };
    let plant = plant(&own, 0.01);
    let filter = design(&plant, 0.2).unwrap();
    let gains = plant.gains();
    let (mut truth, mut x, mut q) = ([0.0; 4], [0.0; 4], 0.0);
    // 1 mW flows away, as into a support that has become colder.
    for _ in 0..3000 {
        let e: f64 = truth.iter().zip(&x).zip(R).map(|((truth, x), r)| r * (truth - x)).sum();
        q -= filter.convection_w_per_k * e;
        for k in 0..4 {
            x[k] += gains[k] * (filter.correction_w_per_k[k] * e - q - x[k]);
            truth[k] += gains[k] * (-1e-3 - truth[k]);
        }
    }
    assert!((q / 1e-3 - 1.0).abs() < 0.01, "{q}");
}

#[test]
fn readings_are_weighted_by_what_they_are_worth() {
    let unequal = SelfHeatingParameters { noise: ReadingNoise { low_k: 2.6e-3, high_k: 0.37e-3 }, ..element(1) };
    let filter = design(&plant(&unequal, 0.001), 5.0).unwrap();
    let [low, high] = filter.weights;
    assert!((NOMINAL_DUTY * high + (1.0 - NOMINAL_DUTY) * low - 1.0).abs() < 1e-12);
    // By the squares of the noise, as the prediction is far surer than a reading.
    assert!(low / high > (0.37f64 / 2.6).powi(2) && low / high < 1.3 * (0.37f64 / 2.6).powi(2), "{}", low / high);
}

#[test]
fn what_the_sample_period_cannot_give_is_refused() {
    let own = element(2);
    let sentence = design(&plant(&own, 0.01), 20.0).unwrap_err().to_string();
    assert!(sentence.contains("at most 10.0000 Hz"), "{sentence}");
    assert!(design(&plant(&own, 0.01), 10.0).is_ok());
    assert!(design(&plant(&own, 0.01), f64::NAN).is_err());
    let silent = SelfHeatingParameters { noise: ReadingNoise { low_k: 0.0, ..NOISE }, ..element(2) };
    assert!(design(&plant(&silent, 0.01), 1.0).unwrap_err().to_string().contains("noise of readings is 0 K"));
}
