//! What `studies thesis` prints: the studies that were run, as text and as JSON.

use std::fmt;
use std::path::PathBuf;

use serde::ser::{Serialize, SerializeMap, Serializer};

use super::catalogue::Study;
use super::findings::StudyFindings;

/// Studies with their findings.
pub struct ThesisReport<'a> {
    /// In the order in which they were run.
    pub studies: Vec<(&'a Study, StudyFindings)>,
    /// The folder with their pages.
    pub folder: PathBuf,
}

impl Serialize for ThesisReport<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.studies.len()))?;
        for (study, findings) in &self.studies {
            map.serialize_entry(study.name, findings)?;
        }
        map.end()
    }
}

impl fmt::Display for ThesisReport<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (study, findings) in &self.studies {
            writeln!(f, "{}", study.title())?;
            for finding in &findings.findings {
                let mark = match finding.met {
                    None => "       ",
                    Some(true) => "met    ",
                    Some(false) => "NOT MET",
                };
                let known = [("published", &finding.published), ("bar", &finding.bar)];
                let known = known.into_iter().filter(|(_, words)| !words.is_empty());
                let known: Vec<String> = known.map(|(name, words)| format!("{name}: {words}")).collect();
                let known = if known.is_empty() { String::new() } else { format!("  ({})", known.join("; ")) };
                writeln!(f, "  {mark}  {}: {}{known}", finding.what, finding.ours)?;
            }
            writeln!(f)?;
        }
        let scores = self.studies.iter().map(|(_, findings)| findings.score());
        let (bars, met) = scores.fold((0, 0), |sum, score| (sum.0 + score.0, sum.1 + score.1));
        writeln!(f, "{met} of {bars} bars met; pages and pictures are in {}", self.folder.display())
    }
}
