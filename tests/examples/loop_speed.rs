//! One line of JSON on a predicted loop and how long that took, for
//! `docs/performance/closed_loop.py`.
//!
//! `loop_speed TICKS WINDS OUT`: predicts the loop of [`anemo_tests::loops`] at 100 Hz with WINDS
//! changes, and writes its power in the limit of fast sampling to OUT, as f64, little-endian.

use anemo_tests::loops::{LEVELS_W, OFFSET_C, R_K_PER_W, RATES_RAD_S, scenario, symbol_model};
use anemo_tests::speed::least_s;
use diffusive::predict::closed::{LoopStart, predict};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [ticks, winds, out] = arguments.as_slice() else { panic!("usage: loop_speed TICKS WINDS OUT") };
    let (ticks, winds): (usize, usize) = (ticks.parse().expect("a number"), winds.parse().expect("a number"));
    let winds: Vec<(usize, usize)> = (0..winds).map(|n| (n * ticks / winds, [0, 2, 1, 0, 1, 2][n % 6])).collect();
    let (model, scenario) = (symbol_model(), scenario(34.0, winds.clone(), ticks));
    let mut prediction = predict(&model, &scenario, LoopStart::Rest).expect("the model can be predicted");
    let seconds = least_s(5, || prediction = predict(&model, &scenario, LoopStart::Rest).expect("as before"));
    let of = &prediction.elements[0];
    let bytes: Vec<u8> = of.limit_w.iter().flat_map(|w| w.to_le_bytes()).collect();
    std::fs::write(out, bytes).expect("OUT can be written");
    let report = serde_json::json!({
        "seconds": seconds,
        "period_s": 0.01,
        "rise_k": 34.0 - OFFSET_C,
        "high_w": LEVELS_W.1,
        "rates_rad_s": RATES_RAD_S,
        "r_k_per_w": R_K_PER_W,
        "winds": winds,
        "first_met_s": of.first_met_s,
        "saturated": of.saturated(),
    });
    println!("{report}");
}
