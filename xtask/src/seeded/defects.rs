//! The defects, which stand in `defects.toml`.

use anyhow::{Context, Result, bail};
use serde::Deserialize;

/// One defect; `defects.toml` says what each key means.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Defect {
    pub name: String,
    file: String,
    text: String,
    becomes: String,
    pub scenario: String,
    pub shows: String,
}

impl Defect {
    /// The file from the workspace's root on.
    pub fn path(&self) -> String {
        format!("firmware/src/{}", self.file)
    }

    /// The file's text with the defect.
    pub fn applied_to(&self, sound: &str) -> Result<String> {
        match sound.matches(&self.text).count() {
            1 => Ok(sound.replacen(&self.text, &self.becomes, 1)),
            n => bail!("{}: its text stands {n} times in {}, and has to once", self.name, self.path()),
        }
    }
}

/// All defects.
pub fn read() -> Result<Vec<Defect>> {
    #[derive(Deserialize)]
    struct DefectList {
        defects: Vec<Defect>,
    }
    let list: DefectList = toml::from_str(include_str!("defects.toml")).context("defects.toml cannot be read")?;
    Ok(list.defects)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whoever changes such a line takes its defect along.
    #[test]
    fn every_text_stands_exactly_once_in_its_file() {
        for defect in read().expect("the list") {
            let sound = std::fs::read_to_string(crate::shell::root().join(defect.path())).expect("the file");
            let changed = defect.applied_to(&sound).unwrap_or_else(|error| panic!("{error}"));
            assert_ne!(changed, sound, "{}", defect.name);
        }
    }
}
