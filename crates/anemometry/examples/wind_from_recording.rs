//! Wind from a recording of a calibrated sphere: ten seconds, of which the first four are
//! quiescent.
//!
//! `cargo run --release -p anemometry --example wind_from_recording` prints what stands in
//! `wind_from_recording.out`.

use std::path::Path;

use anemometry::head::Head;
use anemometry::wind::{WindEstimation, WindOptions};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures");
    let head = Head::read(&fixtures.join("sphere-b-calibrated.toml"))?;
    let options = WindOptions { bandwidth_hz: Some(1.0), interval_s: Some(1.0), ..WindOptions::default() };
    let recording = fixtures.join("sphere-b-wind.parquet");
    let mut estimation = WindEstimation::new(&recording, &head, &options, None)?;
    println!("time   speed     standard uncertainty");
    while let Some(estimate) = estimation.next_estimate()? {
        let (time_s, sample) = (estimate.moment.time_s, estimate.sample);
        println!("{time_s:4.1} s {:5.2} m/s  {:.2} m/s", sample.speed_m_s, sample.speed_error_m_s);
    }
    let report = estimation.report();
    println!("{} estimates of head {}, flagged {:?}", report.estimates, report.head, report.counted.quality_flags);
    Ok(())
}
