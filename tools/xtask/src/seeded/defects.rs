//! The defects, which stand in `defects.toml`.

use super::change::{SeededChange, read};
use anyhow::{Context, Result, bail};
use serde::Deserialize;

/// One defect; `defects.toml` says what each key means.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Defect {
    name: String,
    file: String,
    text: String,
    becomes: String,
    scenario: String,
    shows: String,
}

impl Defect {
    fn seeded(self) -> Result<SeededChange> {
        let Self { name, file, text, becomes, scenario, shows } = self;
        let path = format!("firmware/src/{file}");
        let sound = read(&crate::shell::root().join(&path))?;
        let changed = match sound.matches(&text).count() {
            1 => sound.replacen(&text, &becomes, 1),
            n => bail!("{name}: its text stands {n} times in {path}, and has to once"),
        };
        Ok(SeededChange { name, path, text: changed, has_unit_tests: false, scenarios: vec![scenario], shows })
    }
}

/// All defects.
///
/// # Errors
/// One whose text does not stand in its file exactly once.
pub fn list() -> Result<Vec<SeededChange>> {
    #[derive(Deserialize)]
    struct DefectList {
        defects: Vec<Defect>,
    }
    let list: DefectList = toml::from_str(include_str!("defects.toml")).context("defects.toml cannot be read")?;
    list.defects.into_iter().map(Defect::seeded).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whoever changes such a line takes its defect along.
    #[test]
    fn every_text_stands_exactly_once_in_its_file() {
        let changes = list().unwrap_or_else(|error| panic!("{error}"));
        assert!(!changes.is_empty());
        for change in changes {
            let sound = read(&crate::shell::root().join(&change.path)).expect("the file");
            assert_ne!(change.text, sound, "{}", change.name);
        }
    }
}
