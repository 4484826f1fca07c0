//! `studies thesis`: the experiments of the thesis on the simulated sensors.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, anyhow, ensure};
use host_sim::experiment::Experiment;
use host_sim::run::RunError;
use recording::text::suggest;
use recording::toml_file::FileError;
use studies::thesis::{STUDIES, Study, StudyLab, page};

use super::output::{self, announce};

/// Run the experiments of the thesis on the simulated sensors, and compare its findings with ours.
///
/// Each study runs its experiments, identifies models, predicts with them, and leaves a page and a
/// picture: the published value, ours, and whether the bar is met. All take about a minute.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  studies thesis --list
  studies thesis
  studies thesis rems-self -o out/results")]
pub struct Arguments {
    /// The studies, as --list names them; by default all, and a page over them.
    #[arg(value_name = "STUDY")]
    names: Vec<String>,
    /// List the studies.
    #[arg(long)]
    list: bool,
    /// The folder for pages and pictures, which are written anew; their links to docs/sensors hold
    /// from the default.
    #[arg(short, long, value_name = "FOLDER", default_value = "docs/results")]
    output: PathBuf,
    /// The folder with the experiments.
    #[arg(long, value_name = "FOLDER", default_value = "experiments/thesis")]
    experiments: PathBuf,
}

pub fn execute(arguments: &Arguments) -> Result<()> {
    if arguments.list {
        let line = |study: &Study| format!("{:22} {}\n", study.name, study.title());
        return output::print(&STUDIES.iter().map(line).collect::<String>());
    }
    let studies = chosen(&arguments.names)?;
    output::is_experiments(&arguments.experiments)?;
    ensure!(
        !arguments.output.exists() || arguments.output.is_dir(),
        "{}: is a file, and a folder for pages and pictures belongs here",
        arguments.output.display()
    );
    read_all(&arguments.experiments)?;
    output::make_folder(&arguments.output)?;
    let lab = StudyLab::new(&arguments.experiments, &announce);
    let mut done = Vec::with_capacity(studies.len());
    for study in studies {
        announce(study.name);
        let findings = study.run(&lab).map_err(|error| in_study(study, error))?;
        page::write(&arguments.output, study, &findings)?;
        done.push((study, findings));
    }
    // The page over all of them is of all of them.
    if arguments.names.is_empty() {
        page::write_index(&arguments.output, &done)?;
    }
    let scores = done.iter().map(|(_, findings)| findings.score());
    let (bars, met) = scores.fold((0, 0), |sum, score| (sum.0 + score.0, sum.1 + score.1));
    output::print(&format!("{met} of {bars} bars met; pages and pictures are in {}\n", arguments.output.display()))
}

/// Reads every experiment of the folder, so that no study begins, and no page is written, while one
/// of them is wrong.
fn read_all(folder: &Path) -> Result<()> {
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            Experiment::read(&path)?;
        }
    }
    Ok(())
}

/// The studies of these names.
fn chosen(names: &[String]) -> Result<Vec<&'static Study>> {
    let of = |name: &String| {
        STUDIES.iter().find(|study| study.name == name).ok_or_else(|| {
            let hint = suggest(name, STUDIES.iter().map(|study| study.name));
            anyhow!("there is no study `{name}`; {hint}")
        })
    };
    if names.is_empty() { Ok(STUDIES.iter().collect()) } else { names.iter().map(of).collect() }
}

/// A failure with its study, unless it names a file or an experiment itself.
fn in_study(study: &Study, error: anyhow::Error) -> anyhow::Error {
    if error.is::<FileError>() || error.is::<RunError>() { error } else { error.context(study.name) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(output: PathBuf, experiments: PathBuf) -> String {
        let names = vec!["rems-self".to_owned()];
        execute(&Arguments { names, list: false, output, experiments }).unwrap_err().to_string()
    }

    #[test]
    fn nothing_begins_without_a_folder_to_write_to_or_with_an_experiment_that_is_wrong() {
        let folder = tempfile::tempdir().unwrap();
        let (file, output) = (folder.path().join("broken.toml"), folder.path().join("pages"));
        std::fs::write(&file, "title = 3\n").unwrap();
        let sentence = refused(file.clone(), folder.path().to_owned());
        assert!(
            sentence.ends_with("broken.toml: is a file, and a folder for pages and pictures belongs here"),
            "{sentence}"
        );
        let sentence = refused(output.clone(), folder.path().to_owned());
        assert!(sentence.contains("broken.toml, line 1: `title`"), "{sentence}");
        assert!(!output.exists());
    }
}
