//! MATLAB's MAT-file, level 4 (MAT-File Format, The MathWorks, appendix): every variable a matrix
//! behind five numbers. Every MATLAB reads it, Octave and SciPy do; `matfile` only reads, and level
//! 5 would add nothing to columns of numbers.
//!
//! A column is a vector of its name. Text is a vector of codes `<name>_code` from 1 on, and the
//! words are the rows of `<name>_words`: `deblank(state_words(state_code(n), :))`.

use super::table::{ConvertedColumn, ConvertedTable, FormError};
use recording::TIME;
use std::fs::File;
use std::io::{BufWriter, Write};

/// Longer names are cut by MATLAB, and two might be one then.
const LONGEST_NAME: usize = 63;
/// The kinds of a matrix: numbers, and text.
const NUMBERS: i32 = 0;
const TEXT: i32 = 1;

pub(super) fn write(table: &ConvertedTable, file: File) -> Result<(), FormError> {
    let mut file = BufWriter::new(file);
    vector(&mut file, TIME, table.time_s.iter().copied())?;
    if let Some(start) = table.start_utc {
        words(&mut file, "start_utc", &[start.to_string()])?;
    }
    for (name, column) in &table.columns {
        match column {
            ConvertedColumn::Numbers(numbers) => vector(&mut file, name, numbers.iter().copied())?,
            ConvertedColumn::Words(column) => {
                vector(&mut file, &format!("{name}_code"), column.codes().iter().map(|&code| f64::from(code) + 1.0))?;
                words(&mut file, &format!("{name}_words"), column.dictionary())?;
            }
        }
    }
    Ok(file.flush()?)
}

fn vector(file: &mut impl Write, name: &str, numbers: impl ExactSizeIterator<Item = f64>) -> Result<(), FormError> {
    matrix(file, name, NUMBERS, [numbers.len(), 1])?;
    for number in numbers {
        file.write_all(&number.to_le_bytes())?;
    }
    Ok(())
}

/// Words as rows of characters, with blanks behind the shorter ones.
fn words(file: &mut impl Write, name: &str, words: &[String]) -> Result<(), FormError> {
    let letters: Vec<Vec<char>> = words.iter().map(|word| word.chars().collect()).collect();
    let longest = letters.iter().map(Vec::len).max().unwrap_or(0);
    matrix(file, name, TEXT, [words.len(), longest])?;
    for at in 0..longest {
        for word in &letters {
            let letter = f64::from(u32::from(word.get(at).copied().unwrap_or(' ')));
            file.write_all(&letter.to_le_bytes())?;
        }
    }
    Ok(())
}

/// What stands before the numbers, column by column in f64, little-endian.
fn matrix(file: &mut impl Write, name: &str, kind: i32, size: [usize; 2]) -> Result<(), FormError> {
    let is_name = name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
        && name.starts_with(|letter: char| letter.is_ascii_alphabetic())
        && name.len() <= LONGEST_NAME;
    if !is_name {
        return Err(FormError::Unfit(format!("`{name}` is no name of a variable: rename the column")));
    }
    let too_long = |_| FormError::Unfit(format!("`{name}` is too long for MATLAB's level 4"));
    let [rows, columns] = size.map(|size| i32::try_from(size).map_err(too_long));
    for number in [kind, rows?, columns?, 0, name.len() as i32 + 1] {
        file.write_all(&number.to_le_bytes())?;
    }
    file.write_all(name.as_bytes())?;
    Ok(file.write_all(&[0])?)
}
