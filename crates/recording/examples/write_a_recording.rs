//! Writes a recording of one element row by row and shows the file.

use recording::{Metadata, RecordingLayout, RecordingRow, RecordingWriter};

/// The file's text.
pub fn text() -> Result<String, Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("heating.csv");
    let layout = RecordingLayout { elements: vec!["card1-die2".to_owned()], ..RecordingLayout::default() };
    let title: Metadata = vec![("title".to_owned(), "A heated die".to_owned())];
    let mut writer = RecordingWriter::create(&path, layout, &title)?;
    for n in 0_u8..4 {
        let heated = n >= 2;
        writer.push(&RecordingRow {
            time_s: f64::from(n) * 0.25,
            temperature_c: &[20.0 + if heated { 0.25 * f32::from(n) } else { 0.0 }],
            power_w: &[if heated { 0.042 } else { 0.0015 }],
            equivalent_power_w: &[],
            heaters: usize::from(heated),
            event: "quiescent",
            state: "running",
            true_wind_m_s: None,
            gas_temperature_c: None,
            estimate: &[],
        })?;
    }
    writer.finish(&vec![("lost".to_owned(), "0".to_owned())])?;
    Ok(std::fs::read_to_string(path)?)
}

#[allow(dead_code)]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    print!("{}", text()?);
    Ok(())
}
