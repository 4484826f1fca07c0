//! Forecast of a constant-temperature loop (CTA), from a model that was identified open loop.
//!
//! The analysis of the loop first, then an experiment tick by tick: a film held 20 K above the gas
//! while a gust comes and goes.

use diffusive::model::Model;
use diffusive::predict::analysis_report::{AnalysisReport, AnalysisRequest};
use diffusive::predict::closed::{LoopStart, predict};
use diffusive::predict::scenario::{Heated, Heater, Scenario};
use dr_core::control::Drive;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/hot_film.json");
    let model = Model::read(file.as_ref())?;
    let request = AnalysisRequest { target_k: Some(20.0), ..AnalysisRequest::default() };
    println!("{}", AnalysisReport::new(&model, &request)?);

    let scenario = Scenario {
        sample_period_s: 0.01,
        ticks: 9000,
        winds: vec![(0, 0), (3000, 1), (6000, 0)], // first tick, index of the class
        elements: vec![Heated {
            name: "film".to_owned(),
            drive: Drive::Temperature { target_c: 40.0 },
            heater: Heater::Fixed { low_w: 0.01, high_w: 0.4 },
        }],
        gas_c: None,
    };
    let film = &predict(&model, &scenario, LoopStart::Standby)?.elements[0];
    println!("time s  power in the limit mW  power under the one-bit rule mW");
    for (n, (limit_w, sampled_w)) in film.limit_w.chunks(1000).zip(film.sampled_w.chunks(1000)).enumerate() {
        let mean_mw = |w: &[f64]| 1e3 * w.iter().sum::<f64>() / w.len() as f64;
        println!("{:>4}–{:<3} {:>16.2} {:>20.2}", 10 * n, 10 * (n + 1), mean_mw(limit_w), mean_mw(sampled_w));
    }
    Ok(())
}
