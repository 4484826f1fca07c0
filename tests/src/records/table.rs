//! Columns of a simulated record as CSV: `time_s` first, numbers with the fewest digits that give
//! the same f64 back.

use std::io::{BufWriter, Write as _};
use std::path::Path;

/// One column of a table.
pub enum Column<'a> {
    Numbers(&'a [f64]),
    /// Labels by index.
    Labels(&'a [usize], &'a [String]),
}

/// Writes a record; columns are (name, values), all of the same length.
pub fn write_csv(path: &Path, sample_period_s: f64, columns: &[(&str, Column)]) -> std::io::Result<()> {
    let mut file = BufWriter::new(std::fs::File::create(path)?);
    let names: Vec<&str> = std::iter::once("time_s").chain(columns.iter().map(|(name, _)| *name)).collect();
    writeln!(file, "{}", names.join(","))?;
    let rows = columns.first().map_or(0, |(_, column)| match column {
        Column::Numbers(values) => values.len(),
        Column::Labels(values, _) => values.len(),
    });
    for n in 0..rows {
        write!(file, "{}", n as f64 * sample_period_s)?;
        for (_, column) in columns {
            match column {
                Column::Numbers(values) => write!(file, ",{}", values[n])?,
                Column::Labels(values, labels) => write!(file, ",{}", labels[values[n]])?,
            }
        }
        writeln!(file)?;
    }
    file.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_read_back_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("record.csv");
        let labels = ["still".to_owned(), "windy".to_owned()];
        let columns = [("u", Column::Numbers(&[0.1, 1.0 / 3.0])), ("event", Column::Labels(&[1, 0], &labels))];
        write_csv(&path, 0.5, &columns).unwrap();
        assert_eq!(
            std::fs::read_to_string(path).unwrap(),
            "time_s,u,event\n0,0.1,windy\n0.5,0.3333333333333333,still\n"
        );
    }
}
