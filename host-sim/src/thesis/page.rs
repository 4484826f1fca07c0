//! What a study leaves behind: `<name>.md` and `<name>.svg`, and `README.md` over all of them.

use std::fmt::Write as _;
use std::path::Path;

use super::{Findings, Study};
use crate::plot::{Canvas, PlotError};
use crate::recording::Temporary;

/// Writes page and picture of a study into a folder.
///
/// # Errors
/// If a file cannot be written; a file is there in whole or as it was.
pub fn write(folder: &Path, study: &Study, findings: &Findings) -> Result<(), PlotError> {
    Canvas::create(&folder.join(format!("{}.svg", study.name)))?.write(&findings.svg)?;
    write_text(&folder.join(format!("{}.md", study.name)), &page(study, findings))
}

/// Writes the page over all studies.
///
/// # Errors
/// If it cannot be written.
pub fn write_index(folder: &Path, studies: &[(&Study, Findings)]) -> Result<(), PlotError> {
    write_text(&folder.join("README.md"), &index(studies))
}

fn write_text(path: &Path, text: &str) -> Result<(), PlotError> {
    let failed = |error: std::io::Error| PlotError::Io { path: path.to_owned(), reason: error.to_string() };
    let (temporary, mut file) = Temporary::create(path).map_err(failed)?;
    std::io::Write::write_all(&mut file, text.as_bytes()).and_then(|()| temporary.keep()).map_err(failed)
}

fn page(study: &Study, findings: &Findings) -> String {
    // Writing to a String cannot fail.
    let mut text = format!("# {}\n\nThesis: {}. Made by `anemo thesis {}`.\n", study.title, study.source, study.name);
    for paragraph in &findings.words {
        let _ = write!(text, "\n{paragraph}\n");
    }
    let _ = write!(text, "\n![{}]({}.svg)\n\n{}", findings.caption, study.name, table(findings));
    text
}

fn table(findings: &Findings) -> String {
    let mut text = "| what | published | ours | bar | |\n|---|---|---|---|---|\n".to_owned();
    for finding in &findings.findings {
        let met = match finding.met {
            None => "",
            Some(true) => "met",
            Some(false) => "**not met**",
        };
        let _ =
            writeln!(text, "| {} | {} | {} | {} | {met} |", finding.what, finding.published, finding.ours, finding.bar);
    }
    text
}

fn index(studies: &[(&Study, Findings)]) -> String {
    let mut text = "# The experiments of the thesis, on the simulated sensors\n\nMade by `anemo thesis`: every number and picture here comes from running the experiments in [`experiments/thesis`](../../experiments/thesis).\nPublished values are those of the thesis; where it gives none, ours is the first. The sensors are thermal networks\n([sphere A](../sensors/sphere-a.md), [sphere B](../sensors/sphere-b.md), [REMS](../sensors/rems.md)), never diffusive models.\n\nWhat the thesis does not publish of a sensor is derived from its size and material, assumed, or calibrated to some of the values below: the pole of a\ndie, the diagonal against the adjacent die, the resistance of a die (by which four give some 10 K of cross-heating), poles and rise of the boom, and the tail of sphere A. Of those the tables say that a\nnetwork of plausible parts has them, not that it was foreseen. All else is found.\n\nWords: a *symbol* is the share R of a thermal resistance at each rate ξ = 2πf; rates lie on a *mesh*, or are *free poles*\n([models](../models.md)); *zeros* are the rates of a closed loop, and the *limit of fast sampling* is what it does between them, the *one-bit rule* what\na sampled one does ([closed loops](../closed-loop.md)). A *bar* is what a value has to reach; one without is only told.\n\n| study | bars | met |\n|---|---|---|\n".to_owned();
    for (study, findings) in studies {
        let (bars, met) = findings.score();
        let _ = writeln!(text, "| [{}]({}.md) | {bars} | {met} |", study.title, study.name);
    }
    let missed: Vec<String> = studies
        .iter()
        .flat_map(|(study, findings)| {
            let missed = findings.findings.iter().filter(|finding| finding.met == Some(false));
            missed.map(|of| {
                format!(
                    "- [{}]({}.md): {}: {}, where the bar is {}\n",
                    study.title, study.name, of.what, of.ours, of.bar
                )
            })
        })
        .collect();
    if !missed.is_empty() {
        let _ = write!(text, "\n## Not met\n\nWhy is said on the pages.\n\n{}", missed.concat());
    }
    text
}
