//! What a study leaves behind: `<name>.md` and `<name>.svg`, and `README.md` over all of them.

use std::path::Path;

use super::catalogue::Study;
use super::error::StudyError;
use super::findings::StudyFindings;
use crate::template::{TemplateError, fill};
use plot::{Canvas, PlotError};
use recording::Temporary;

/// Writes page and picture of a study into a folder.
///
/// # Errors
/// If a file cannot be written; a file is there in whole or as it was.
pub fn write(folder: &Path, study: &Study, findings: &StudyFindings) -> Result<(), StudyError> {
    let page = page(study, findings)?;
    Canvas::create(&folder.join(format!("{}.svg", study.name)))?.draw(&findings.figure)?;
    write_text(&folder.join(format!("{}.md", study.name)), &page)
}

/// Writes the page over all studies.
///
/// # Errors
/// If it cannot be written.
pub fn write_index(folder: &Path, studies: &[(&Study, StudyFindings)]) -> Result<(), StudyError> {
    write_text(&folder.join("README.md"), &index(studies)?)
}

fn write_text(path: &Path, text: &str) -> Result<(), StudyError> {
    let failed = |error: std::io::Error| PlotError::Io { path: path.to_owned(), reason: error.to_string() };
    Ok(Temporary::write(path, text.as_bytes()).map_err(failed)?)
}

fn page(study: &Study, findings: &StudyFindings) -> Result<String, TemplateError> {
    let table = table(findings);
    let mut values: Vec<(&str, &str)> = vec![("findings", table.trim_end())];
    values.extend(findings.values.iter().map(|(name, value)| (*name, value.as_str())));
    fill(study.page, &values)
}

fn table(findings: &StudyFindings) -> String {
    let rows = findings.findings.iter().map(|finding| {
        let met = match finding.met {
            None => "",
            Some(true) => "met",
            Some(false) => "**not met**",
        };
        format!("| {} | {} | {} | {} | {met} |\n", finding.what, finding.published, finding.ours, finding.bar)
    });
    let head = "| what | published | ours | bar | |\n|---|---|---|---|---|\n".to_owned();
    head + &rows.collect::<String>()
}

fn index(studies: &[(&Study, StudyFindings)]) -> Result<String, TemplateError> {
    let scores = studies.iter().map(|(study, findings)| {
        let (bars, met) = findings.score();
        format!("| [{}]({}.md) | {bars} | {met} |\n", study.title(), study.name)
    });
    let missed = studies.iter().flat_map(|(study, findings)| {
        let missed = findings.findings.iter().filter(|finding| finding.met == Some(false));
        missed.map(|of| {
            format!("- [{}]({}.md): {}: {}, where the bar is {}\n", study.title(), study.name, of.what, of.ours, of.bar)
        })
    });
    let missed: String = missed.collect();
    let missed = match missed.as_str() {
        "" => String::new(),
        missed => fill(include_str!("pages/not-met.md"), &[("missed", missed)])?,
    };
    fill(include_str!("pages/index.md"), &[("studies", &scores.collect::<String>()), ("missed", &missed)])
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
        assert!(text.ends_with("| [REMS: self-heating of a die](rems-self.md) | 1 | 1 |\n"), "{text}");
        let text = index(&[(&STUDIES[0], found(false))]).unwrap();
        assert!(text.ends_with("(rems-self.md): time: 3 s, where the bar is at most 2 s\n"), "{text}");
    }
}
