//! Files that a study leaves behind: `<name>.md` and `<name>.svg`, and `README.md` over all of
//! them.

use anyhow::{Context, Result};
use std::path::Path;

use super::catalogue::Study;
use super::findings::StudyFindings;
use crate::table::ResultTable;
use plot::Canvas;
use recording::Temporary;
use recording::template::fill;

/// Writes page and picture of a study into a folder.
///
/// # Errors
/// If a file cannot be written; a file is there in whole or as it was.
pub fn write(folder: &Path, study: &Study, findings: &StudyFindings) -> Result<()> {
    let page = page(study, findings)?;
    Canvas::create(&folder.join(format!("{}.svg", study.name)))?.draw(&findings.figure)?;
    write_text(&folder.join(format!("{}.md", study.name)), &page)
}

/// Writes the page over all studies.
///
/// # Errors
/// If it cannot be written.
pub fn write_index(folder: &Path, studies: &[(&Study, StudyFindings)]) -> Result<()> {
    write_text(&folder.join("README.md"), &index(studies)?)
}

fn write_text(path: &Path, text: &str) -> Result<()> {
    Temporary::write(path, text.as_bytes()).with_context(|| format!("{}: cannot be written", path.display()))
}

fn page(study: &Study, findings: &StudyFindings) -> Result<String> {
    let table = table(findings);
    let mut values: Vec<(&str, &str)> = vec![("findings", table.trim_end())];
    values.extend(findings.values.iter().map(|(name, value)| (*name, value.as_str())));
    fill(study.page, &values)
}

/// Findings with a bar as a table, and the rest as a list below it.
fn table(findings: &StudyFindings) -> String {
    let (judged, reported): (Vec<_>, Vec<_>) = findings.findings.iter().partition(|of| of.met.is_some());
    let rows = judged.iter().map(|of| {
        let met = if of.met == Some(true) { "met" } else { "**not met**" };
        [of.what.clone(), of.published.clone(), of.ours.clone(), format!("{}: {met}", of.bar)]
    });
    let lines = reported.iter().map(|of| match of.published.as_str() {
        "" => format!("- {}: {}\n", of.what, of.ours),
        published => format!("- {}: {} (published: {published})\n", of.what, of.ours),
    });
    let table = ResultTable::new("what | published | ours | bar", rows).markdown();
    format!("{table}\n{}", lines.collect::<String>())
}

fn index(studies: &[(&Study, StudyFindings)]) -> Result<String> {
    let scores = studies.iter().map(|(study, findings)| {
        let (bars, met) = findings.score();
        let missed = findings.findings.iter().filter(|of| of.met == Some(false));
        let missed = missed.map(|of| format!("  - not met: {}: {} (bar: {})\n", of.what, of.ours, of.bar));
        format!("- [{}]({}.md): {met} of {bars}\n{}", study.title(), study.name, missed.collect::<String>())
    });
    fill(include_str!("pages/index.md"), &[("studies", &scores.collect::<String>())])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thesis::STUDIES;

    #[test]
    fn every_page_asks_for_its_frame_and_its_own_values() {
        for study in &STUDIES {
            // The picture has words for those who cannot see it.
            assert!(study.page.contains("\n![") && !study.page.contains("![]"), "{}", study.name);
            assert!(study.page.starts_with("# ") && study.title().len() > 10, "{}", study.name);
            let mut findings = StudyFindings::default();
            let own: Vec<&str> = study.page.split('{').skip(1).filter_map(|rest| rest.split('}').next()).collect();
            assert!(own.contains(&"findings"), "{}", study.name);
            findings.reported("what", "3 s");
            let known = page(study, &findings);
            let plain = own.iter().all(|name| *name == "findings");
            assert_eq!(known.is_ok(), plain, "{}: {known:?}", study.name);
        }
    }

    #[test]
    fn the_index_names_what_is_not_met_and_nothing_else() {
        let found = |met| {
            let mut findings = StudyFindings::default();
            findings.reported("time", "3 s").judged("at most 2 s", met);
            findings
        };
        let text = index(&[(&STUDIES[0], found(true))]).unwrap();
        assert!(text.ends_with("- [REMS: self-heating of a die](rems-self.md): 1 of 1\n"), "{text}");
        let text = index(&[(&STUDIES[0], found(false))]).unwrap();
        assert!(text.ends_with("(rems-self.md): 0 of 1\n  - not met: time: 3 s (bar: at most 2 s)\n"), "{text}");
    }
}
