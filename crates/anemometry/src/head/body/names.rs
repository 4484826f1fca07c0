//! Names that stand for several: `card[1-3]-die[1-4]` are twelve, the last number running fastest,
//! and `core1,core2` are two.

/// More names than a body can use.
const MOST_NAMES: usize = 4096;

/// Why a pattern stands for nothing: the rest of a sentence about its key.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NamesError {
    /// It is no word.
    #[error("has the name {0:?}: a word without brackets, `:` and quotation marks belongs here")]
    Word(String),
    /// There are too many.
    #[error("stands for more than {MOST_NAMES} names")]
    TooMany,
    /// What stands in brackets.
    #[error("has `[{0}`, which is no range: write `[1-4]` for the numbers 1 to 4")]
    Range(String),
}

/// All that a pattern stands for, in order.
///
/// # Errors
/// If a part of it is no word or no range, or stands for too many.
pub fn all(pattern: &str) -> Result<Vec<String>, NamesError> {
    let mut names = Vec::new();
    for part in pattern.split(',').map(str::trim) {
        expand(part, String::new(), &mut names)?;
    }
    Ok(names)
}

fn expand(rest: &str, before: String, names: &mut Vec<String>) -> Result<(), NamesError> {
    let Some((plain, behind)) = rest.split_once('[') else {
        let name = before + rest;
        if name.is_empty() || name.contains(|c: char| c.is_whitespace() || "[]:\"".contains(c)) {
            return Err(NamesError::Word(name));
        }
        if names.len() == MOST_NAMES {
            return Err(NamesError::TooMany);
        }
        names.push(name);
        return Ok(());
    };
    let range = behind.split_once(']').and_then(|(range, behind)| {
        let (first, last) = range.split_once('-')?;
        Some((first.parse::<u16>().ok()?, last.parse::<u16>().ok()?, behind))
    });
    match range {
        Some((first, last, behind)) if first <= last => {
            (first..=last).try_for_each(|number| expand(behind, format!("{before}{plain}{number}"), names))
        }
        _ => Err(NamesError::Range(behind.to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_run_like_the_digits_of_a_number() {
        assert_eq!(all("a[1-2]-b[3-4]").unwrap(), ["a1-b3", "a1-b4", "a2-b3", "a2-b4"]);
        assert_eq!(all("core1, core2,x[9-10]y").unwrap(), ["core1", "core2", "x9y", "x10y"]);
    }

    #[test]
    fn what_is_no_range_is_refused() {
        for (pattern, expected) in [
            ("a[4-1]", "has `[4-1]`, which is no range"),
            ("a[1", "has `[1`, which is no range"),
            ("a[x-y]", "is no range"),
            ("a]", "has the name \"a]\""),
            ("a,,b", "has the name \"\""),
            ("", "has the name \"\""),
            ("a[0-9][0-9][0-9][0-9]", "stands for more than 4096 names"),
        ] {
            let sentence = all(pattern).unwrap_err().to_string();
            assert!(sentence.contains(expected), "{pattern}: {sentence}");
        }
    }
}
