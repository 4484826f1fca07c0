//! Reads a table that no anemometer made: sample period, mean of every column, and what is wrong
//! with a bad one.

use recording::{ColumnValues, Recording, text::tidy};

const TABLE: &str = "t,u_V,phase\n0,9.5,warm-up\n0.5,9.1,warm-up\n1,9,steady\n1.5,9,steady\n";

/// Text about the table.
pub fn text() -> Result<String, Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("bridge.csv");
    std::fs::write(&path, TABLE)?;
    let recording = Recording::read(&path)?;
    let mut text = format!("{} rows, one each {} s\n", recording.len(), recording.sample_period_s()?);
    for column in &recording.columns {
        text += &match &column.values {
            ColumnValues::Numbers(numbers) => {
                format!("{}: mean {}\n", column.name, tidy(numbers.iter().sum::<f64>() / numbers.len() as f64))
            }
            ColumnValues::Words(words) => format!("{}: {}\n", column.name, words.dictionary().join(", ")),
        };
    }
    std::fs::write(&path, TABLE.replace("9.1", "9,1"))?;
    let error = Recording::read(&path).expect_err("a comma separates columns").to_string();
    Ok(text + &error.replace(&format!("{}/", folder.path().display()), "") + "\n")
}

#[allow(dead_code)]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    print!("{}", text()?);
    Ok(())
}
