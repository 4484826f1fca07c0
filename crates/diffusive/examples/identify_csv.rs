//! Identifies the thermal model of a heater from a CSV file: `cargo run --release -p diffusive
//! --example identify_csv [FILE]`.
//!
//! The file has a column of times in seconds, one of heating power and one of temperature.
//! `heater.csv` beside this program was simulated: R = 12, 6 and 2 K/W at 0.02, 0.2 and 2 rad/s, 20
//! K/W in all, and noise of 5 mK.

use std::path::Path;

use diffusive::identify::record::{RecordStream, Selection};
use diffusive::identify::report::IdentifyReport;
use diffusive::identify::validate::{ValidationStart, validate};
use diffusive::identify::{Constraints, IdentifyOptions, identify};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).unwrap_or_else(|| "examples/heater.csv".to_owned());
    // The order of the columns says which is what; `Selection` names them otherwise.
    let mut record = RecordStream::open(Path::new(&file), &Selection::default())?;

    // A heater without dead time or direct path, as three rates; all else is chosen.
    let constraints = Constraints { delay: Some(0), feed_through: Some(false), ..Constraints::default() };
    let options = IdentifyOptions { constraints, free_poles: Some(3), ..IdentifyOptions::default() };
    let model = identify(&mut record, &options, &mut |_, _, _| {}, &mut |_| {})?;
    print!("{}", IdentifyReport { model: &model, notes: &[], written: None });

    let report = validate(&model, &mut record, ValidationStart::Rest, &mut |_| {})?;
    println!("\nrun forward from rest: {report}");
    Ok(())
}
