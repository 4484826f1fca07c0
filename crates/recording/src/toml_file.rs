//! Strict reading of the project's TOML files: whatever is not understood is refused, with the
//! place where it stands.
//!
//! A [`TomlSource`] is a file's path and text. [`TomlSource::parse`] turns it into a type that
//! denies unknown keys; [`TomlSource::refuse`] makes the error for a value that parses but cannot
//! be meant. Both name file, line and key in one sentence, and an unknown key is answered with the
//! nearest one that the same table knows.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Deserializer};
use toml::de::{DeTable, DeValue};

use crate::text::{one_line, suggest};

/// A file that cannot be used, and why: `gusts.toml, line 12: unknown key …`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}{}: {sentence}", path.display(), line.map(|line| format!(", line {line}")).unwrap_or_default())]
pub struct FileError {
    /// The file.
    pub path: PathBuf,
    /// Counted from 1; absent when the whole file is meant.
    pub line: Option<usize>,
    /// Sentence: what is wrong, and what would be right.
    pub sentence: String,
}

/// The text of a TOML file with the path under which the user knows it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TomlSource {
    /// The file.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
}

impl TomlSource {
    /// Reads a file.
    ///
    /// # Errors
    /// If it is missing or no text.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let text = crate::regular::read_text(path).map_err(|error| FileError {
            path: path.to_owned(),
            line: None,
            sentence: match error.kind() {
                std::io::ErrorKind::NotFound => "there is no such file".to_owned(),
                std::io::ErrorKind::InvalidData => "is not text: a TOML file in UTF-8 belongs here".to_owned(),
                _ => format!("cannot be read: {error}"),
            },
        })?;
        Ok(Self { path: path.to_owned(), text })
    }

    /// Reads a type that denies unknown keys.
    ///
    /// # Errors
    /// Names the line, the key and the nearest known one.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, FileError> {
        toml::from_str(&self.text).map_err(|error| FileError {
            path: self.path.clone(),
            line: error.span().map(|span| self.line_at(span.start)),
            sentence: one_line(reword(error.message(), error.span().and_then(|span| self.key_before(span.start)))),
        })
    }

    /// The error for the value under `key` (dotted, with `[n]` for the n-th table of an array).
    pub fn refuse(&self, key: &str, sentence: impl AsRef<str>) -> FileError {
        FileError {
            path: self.path.clone(),
            line: self.line_of(key),
            sentence: one_line(format!("`{key}` {}", sentence.as_ref())),
        }
    }

    /// The error for a file that `key` names: this file's mistake if it cannot be read, its own if
    /// a line of it is wrong.
    pub fn unusable(&self, key: &str, error: FileError) -> FileError {
        if error.line.is_some() { error } else { self.refuse(key, format!("cannot be used: {error}")) }
    }

    /// Passes a finite value inside the range; refuses any other, NaN included.
    pub fn within(&self, key: &str, value: f64, range: RangeInclusive<f64>, unit: &str) -> Result<f64, FileError> {
        if range.contains(&value) {
            return Ok(value);
        }
        let gap = if unit.is_empty() { "" } else { " " };
        let (low, high) = (range.start(), range.end());
        Err(self.refuse(key, format!("is {value}{gap}{unit}: it must lie between {low} and {high}{gap}{unit}")))
    }

    /// Passes a finite value above zero.
    pub fn positive(&self, key: &str, value: f64, unit: &str) -> Result<f64, FileError> {
        if value.is_finite() && value > 0.0 {
            return Ok(value);
        }
        Err(self.refuse(key, format!("is {value} {unit}: it must be finite and above 0 {unit}")))
    }

    fn line_at(&self, offset: usize) -> usize {
        let end = offset.min(self.text.len());
        1 + self.text.as_bytes()[..end].iter().filter(|&&byte| byte == b'\n').count()
    }

    /// The key whose value starts at or after `offset` of its line: what stands before the last
    /// `=`.
    fn key_before(&self, offset: usize) -> Option<&str> {
        let before = self.text.get(..offset)?;
        let (_, line) = before.rsplit_once('\n').unwrap_or(("", before));
        let (key, _) = line.rsplit_once('=')?;
        let key = key.trim_end().rsplit(|c: char| c.is_whitespace() || ",{".contains(c)).next()?;
        Some(key).filter(|key| !key.is_empty())
    }

    fn line_of(&self, key: &str) -> Option<usize> {
        let document = DeTable::parse(&self.text).ok()?;
        let mut line = None;
        let mut table = Some(document.get_ref());
        for step in key.split('.') {
            let (name, index) = match step.split_once('[') {
                Some((name, index)) => (name, index.strip_suffix(']')?.parse::<usize>().ok()),
                None => (step, None),
            };
            // A missing key is reported at the deepest table that is there.
            let Some((found, mut value)) = table.and_then(|table| table.get_key_value(name)) else { break };
            line = Some(self.line_at(found.span().start));
            if let (Some(index), DeValue::Array(array)) = (index, value.get_ref()) {
                let Some(item) = array.get(index) else { break };
                value = item;
                line = Some(self.line_at(value.span().start));
            }
            table = value.get_ref().as_table();
        }
        line
    }
}

/// For `deserialize_with`: a list of exactly N. Serde alone leaves out what a longer one has more.
///
/// # Errors
/// If it has another length.
pub fn exactly<'de, D: Deserializer<'de>, T: Deserialize<'de>, const N: usize>(from: D) -> Result<[T; N], D::Error> {
    let list = Vec::<T>::deserialize(from)?;
    let count = list.len();
    list.try_into().map_err(|_| D::Error::invalid_length(count, &format!("a list of {N}").as_str()))
}

/// The same of a key that may be missing.
///
/// # Errors
/// If it has another length.
pub fn exactly_if_any<'de, D: Deserializer<'de>, T: Deserialize<'de>, const N: usize>(
    from: D,
) -> Result<Option<[T; N]>, D::Error> {
    exactly(from).map(Some)
}

/// Puts serde's message into the words of someone who writes a file, not a deserialiser.
fn reword(message: &str, key: Option<&str>) -> String {
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let hint = |unknown: &str| match quoted.len() {
        0 | 1 => "no key is known here".to_owned(),
        _ => suggest(unknown, quoted[1..].iter().copied()),
    };
    if let (true, Some(unknown)) = (message.starts_with("unknown field"), quoted.first()) {
        return format!("unknown key `{unknown}`; {}", hint(unknown));
    }
    if let (true, Some(unknown)) = (message.starts_with("unknown variant"), quoted.first()) {
        let of = key.map(|key| format!(" for `{key}`")).unwrap_or_default();
        return format!("unknown choice `{unknown}`{of}; {}", hint(unknown));
    }
    if let (true, Some(missing)) = (message.starts_with("missing field"), quoted.first()) {
        return format!("the key `{missing}` is missing");
    }
    if message.starts_with("wanted exactly 1 element") {
        let of = key.map(|key| format!("`{key}`: ")).unwrap_or_default();
        return format!("{of}exactly one choice belongs here, such as {{ temperature_c = -23.15 }}");
    }
    let plain = in_words(message).replace('\n', " ");
    match key {
        Some(key) if message.starts_with("invalid") => format!("`{key}`: {plain}"),
        _ => plain,
    }
}

/// A message with what was expected in the words of TOML, where serde names types of this program.
fn in_words(message: &str) -> String {
    let Some((before, expected)) = message.split_once("expected ") else { return message.to_owned() };
    let word = expected.split_whitespace().next().unwrap_or_default();
    let words = match word {
        "f32" | "f64" => "a number",
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number that is not negative",
        "i8" | "i16" | "i32" | "i64" | "isize" => "a whole number",
        "struct" => return format!("{before}expected a table"),
        "enum" => return format!("{before}expected one of the choices"),
        _ => expected,
    };
    let rest = if words == expected { "" } else { &expected[word.len()..] };
    let words = words.replacen("a map", "a table", 1).replacen("a sequence", "a list", 1);
    format!("{before}expected {}{rest}", words.replacen("path string", "a path in quotes", 1))
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)]
    struct ExampleFile {
        title: String,
        duration_s: f64,
        #[serde(default)]
        wind: Vec<ExampleWind>,
        #[serde(default, deserialize_with = "exactly_if_any")]
        shares: Option<[f64; 2]>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)]
    struct ExampleWind {
        start_s: f64,
        speed_m_s: f64,
    }

    fn source(text: &str) -> TomlSource {
        TomlSource { path: "example.toml".into(), text: text.into() }
    }

    #[test]
    fn a_blank_of_two_bytes_ends_a_key_as_any_other_does() {
        let before = "# no key\nx = { a\u{a0}start_s\u{a0}= ";
        assert_eq!(source(before).key_before(before.len()), Some("start_s"));
        assert_eq!(source("x").key_before(1), None);
    }

    #[test]
    fn a_control_character_in_the_file_does_not_reach_the_terminal() {
        for text in [
            "\"ti\u{7f}tle = 1",
            "title = \"\u{1b}[2J\"\n",
            "ti\u{1b}tle = 1",
            "\"ti\\u001btle\" = 1",
            "\"a\u{7f}b = {",
        ] {
            let sentence = sentence(text);
            assert!(!sentence.contains(char::is_control), "{sentence:?}");
        }
        let refused = source("").refuse("kinds.\u{1b}[2J", "is `\r\n`").to_string();
        assert_eq!(refused, "example.toml: `kinds. [2J` is `  `");
    }

    fn sentence(text: &str) -> String {
        source(text).parse::<ExampleFile>().unwrap_err().to_string()
    }

    #[test]
    fn an_unknown_key_is_named_with_its_line_and_the_nearest_known_one() {
        assert_eq!(
            sentence("title = \"a\"\nduraton_s = 1.0\n"),
            "example.toml, line 2: unknown key `duraton_s`; did you mean `duration_s`?"
        );
        assert_eq!(
            sentence("title = \"a\"\nduration_s = 1.0\n\n[[wind]]\nstart_s = 0.0\nspeed_ms = 2.0\n"),
            "example.toml, line 6: unknown key `speed_ms`; did you mean `speed_m_s`?"
        );
    }

    #[test]
    fn an_unknown_key_that_resembles_nothing_is_answered_with_the_known_ones() {
        assert_eq!(
            sentence("title = \"a\"\nduration_s = 1.0\n[[wind]]\nqqq = 1\n"),
            "example.toml, line 4: unknown key `qqq`; known are `start_s`, `speed_m_s`"
        );
    }

    #[test]
    fn a_missing_key_and_a_wrong_type_are_named() {
        assert_eq!(sentence("duration_s = 1.0\n"), "example.toml, line 1: the key `title` is missing");
        assert_eq!(
            sentence("title = \"a\"\nduration_s = \"long\"\n"),
            "example.toml, line 2: `duration_s`: invalid type: string \"long\", expected a number"
        );
    }

    #[test]
    fn what_was_expected_is_said_in_the_words_of_toml() {
        let table = sentence("title = \"a\"\nduration_s = 1.0\nwind = [3.0]\n");
        assert!(table.ends_with("invalid type: floating point `3.0`, expected a table"), "{table}");
        let list = sentence("title = \"a\"\nduration_s = 1.0\nwind = true\n");
        assert!(list.ends_with("invalid type: boolean `true`, expected a list"), "{list}");
        assert_eq!(
            in_words("invalid value: integer `-7`, expected u64"),
            "invalid value: integer `-7`, expected a whole number that is not negative"
        );
        assert_eq!(
            in_words("invalid length 1, expected struct WindTable with 3 elements"),
            "invalid length 1, expected a table"
        );
        assert_eq!(in_words("something else"), "something else");
    }

    #[test]
    fn broken_toml_is_one_line() {
        let sentence = sentence("title = \"a\"\nduration_s = = 1\n");
        assert!(sentence.starts_with("example.toml, line 2: "), "{sentence}");
        assert!(!sentence.contains('\n'));
    }

    #[test]
    fn a_refused_value_is_found_in_nested_tables_and_arrays() {
        let source = source("title = \"a\"\n[[wind]]\nstart_s = 0.0\n[[wind]]\nstart_s = 1.0\nspeed_m_s = -1.0\n");
        assert_eq!(source.refuse("wind[1].speed_m_s", "is -1").line, Some(6));
        assert_eq!(source.refuse("wind[1].label", "is not there").line, Some(4));
        assert_eq!(source.refuse("nothing.here", "is not there").line, None);
    }

    #[test]
    fn not_a_number_lies_in_no_range() {
        let source = source("duration_s = nan\n");
        assert_eq!(
            source.within("duration_s", f64::NAN, 0.0..=1.0, "s").unwrap_err().to_string(),
            "example.toml, line 1: `duration_s` is NaN s: it must lie between 0 and 1 s"
        );
        assert!(source.positive("duration_s", f64::INFINITY, "s").is_err());
    }

    #[test]
    fn a_missing_file_is_said_to_be_missing() {
        let error = TomlSource::read(Path::new("no/such.toml")).unwrap_err();
        assert_eq!(error.to_string(), "no/such.toml: there is no such file");
    }
}
