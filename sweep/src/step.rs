//! What is done with a run's recordings: the project's own commands, each a process of `anemo` in
//! the folder of the run.
//!
//! `{recording}` stands for the run's recording, `{sweep}` for the folder of the sweep file. The
//! JSON object that a step prints becomes columns of the results; it is kept beside, and so is what
//! the step says on the way. A pattern such as `identify-*.parquet` is replaced by the files that
//! match it.

use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use recording::Temporary;
use serde_json::{Map, Value};

use crate::columns::{flatten, identifier};
use crate::error::{EntryError, RunFailure};

/// Where steps' messages go.
const LOG: &str = "steps.log";

/// A command behind `anemo`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct StepCommand {
    /// With which its columns begin.
    name: String,
    /// As it is written.
    pub words: Vec<String>,
}

/// Whatever stands in a step for something of the run.
pub(crate) struct StepPlaces<'a> {
    pub recording: &'a str,
    pub sweep: &'a str,
}

impl StepPlaces<'_> {
    /// The arguments of a word, with the files of a folder that match a pattern, as a shell has it:
    /// a recording whose name has a `*` is none.
    fn arguments(&self, folder: &Path, word: &str) -> Vec<String> {
        let filled = |of: fn(&str) -> String| {
            word.replace("{recording}", &of(self.recording)).replace("{sweep}", &of(self.sweep))
        };
        let literal = filled(str::to_owned);
        if !is_pattern(word) {
            return vec![literal];
        }
        let names: Vec<String> = matching(folder, &filled(glob::Pattern::escape))
            .map(|path| path.strip_prefix(folder).unwrap_or(&path).to_string_lossy().into_owned())
            .collect();
        if names.is_empty() { vec![literal] } else { names }
    }
}

impl StepCommand {
    /// Reads a line as a shell would.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(line: &str) -> Result<Self, EntryError> {
        let mut words =
            shlex::split(line).ok_or_else(|| EntryError(format!("is `{line}`, in which a quote is not closed")))?;
        if words.first().is_some_and(|first| first == "anemo") {
            words.remove(0);
        }
        let named: Vec<&str> =
            words.iter().map(String::as_str).take_while(|word| word.bytes().all(|b| b.is_ascii_lowercase())).collect();
        match named.first() {
            None => Err(EntryError(format!(
                "is `{line}`: a command of anemo belongs here, such as `identify {{recording}} --json`"
            ))),
            Some(&"sweep") => Err("is a sweep in a sweep: it would have no end".into()),
            Some(_) => Ok(Self { name: identifier(&named.join("_")), words }),
        }
    }

    /// The files beside the sweep file that it may read, by its words with `{sweep}`.
    pub fn files_in(&self, sweep: &Path) -> Vec<PathBuf> {
        let named = |word: &String| Some(word.split_once("{sweep}")?.1.trim_start_matches('/').to_owned());
        let of =
            |name: String| if is_pattern(&name) { matching(sweep, &name).collect() } else { vec![sweep.join(name)] };
        self.words.iter().filter_map(named).flat_map(of).filter(|path| path.is_file()).collect()
    }

    /// Steps with a name each: the second `identify` is `identify_2`.
    pub fn named(steps: Vec<Self>) -> Vec<Self> {
        let name = |place: usize| {
            let before = steps[..place].iter().filter(|step| step.name == steps[place].name).count();
            if before == 0 { steps[place].name.clone() } else { format!("{}_{}", steps[place].name, before + 1) }
        };
        let names: Vec<String> = (0..steps.len()).map(name).collect();
        steps.into_iter().zip(names).map(|(step, name)| Self { name, ..step }).collect()
    }

    /// Runs it in a run's folder and adds its numbers to the results.
    ///
    /// # Errors
    /// If it cannot be started or fails: its own sentence.
    pub fn run(
        &self,
        program: &Path,
        folder: &Path,
        places: &StepPlaces<'_>,
        results: &mut Map<String, Value>,
    ) -> Result<(), RunFailure> {
        let words: Vec<String> = self.words.iter().flat_map(|word| places.arguments(folder, word)).collect();
        let shown = self.words.join(" ");
        let mut command = Command::new(program);
        // A sweep has a thread for every core already.
        command.args(&words).current_dir(folder).env("RAYON_NUM_THREADS", "1").stdin(Stdio::null());
        let output = command.output().map_err(|error| {
            RunFailure::Failed(format!("`{shown}`: {} cannot be started: {error}", program.display()))
        })?;
        let said = String::from_utf8_lossy(&output.stderr);
        if !said.is_empty() {
            let log = OpenOptions::new().create(true).append(true).open(folder.join(LOG));
            log.and_then(|mut log| write!(log, "{shown}\n{said}")).map_err(RunFailure::unwritten(folder))?;
        }
        if !output.status.success() {
            // From the word that every error begins with to the end; warnings stand before it.
            let begin = said.rfind("anemo: ").map_or(0, |at| at + "anemo: ".len());
            let words: Vec<&str> = said[begin..].split_whitespace().collect();
            let sentence = if words.is_empty() { "it ended without a word".to_owned() } else { words.join(" ") };
            return Err(RunFailure::Failed(format!("`{shown}`: {sentence}")));
        }
        // A step that prints a text for people has no numbers.
        if let Ok(value @ Value::Object(_)) = serde_json::from_slice(&output.stdout) {
            flatten(&self.name, &value, results);
            let summary = folder.join(format!("{}.summary.json", self.name));
            Temporary::write(&summary, &output.stdout).map_err(RunFailure::unwritten(&summary))?;
        }
        Ok(())
    }
}

fn is_pattern(word: &str) -> bool {
    word.contains(['*', '?'])
}

/// The files of a folder that match a pattern, or lie elsewhere if it says so.
fn matching(folder: &Path, pattern: &str) -> impl Iterator<Item = PathBuf> {
    let pattern = Path::new(&glob::Pattern::escape(&folder.to_string_lossy())).join(pattern);
    glob::glob(&pattern.to_string_lossy()).into_iter().flatten().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_named_by_its_command_and_by_a_number_when_it_stands_twice() {
        let steps = ["anemo identify {recording} --json", "head identify a.parquet", "identify 'b c.parquet'"];
        let steps = StepCommand::named(steps.map(|line| StepCommand::parse(line).unwrap()).to_vec());
        let names: Vec<&str> = steps.iter().map(|step| step.name.as_str()).collect();
        assert_eq!(names, ["identify", "head_identify", "identify_2"]);
        assert_eq!(steps[2].words, ["identify", "b c.parquet"]);
        for wrong in ["", "identify 'a", "sweep a.toml", "--json"] {
            StepCommand::parse(wrong).unwrap_err();
        }
    }

    #[test]
    fn only_what_is_written_as_a_pattern_is_one() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a-1.parquet", "a-2.parquet", "b.parquet"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let places = StepPlaces { recording: "/r/a*?.parquet", sweep: "/s[1]" };
        let of = |word: &str| places.arguments(folder.path(), word);
        assert_eq!(of("{recording}"), ["/r/a*?.parquet"]);
        assert_eq!(of("a-*.parquet"), ["a-1.parquet", "a-2.parquet"]);
        assert_eq!(of("none-*"), ["none-*"]);
        let places = StepPlaces { sweep: &folder.path().to_string_lossy(), ..places };
        assert_eq!(places.arguments(folder.path(), "{sweep}/?.parquet"), ["b.parquet"]);
        let step = StepCommand::parse("calibrate --network={sweep}/b.parquet {sweep}/a-* {sweep}/none x").unwrap();
        let files = ["b.parquet", "a-1.parquet", "a-2.parquet"].map(|name| folder.path().join(name));
        assert_eq!(step.files_in(folder.path()), files);
    }
}
