//! A sweep's runs, worked out and named before any of them begins.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use toml::Value;

use crate::documents::{Documents, ExpandedRun, folder_of};
use crate::error::SweepError;
use crate::report::MissingShard;
use crate::run_folder::{RunFolder, write_experiments};
use crate::sampling::combinations;
use crate::sweep_file::SweepFile;
use host_sim::experiment::Experiment;
use recording::toml_file::FileError;

/// A run of a sweep, before it is done.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedRun {
    /// Hash of its experiment, head, models and steps, and of this version: the name of its folder,
    /// on whatever machine.
    pub hash: String,
    /// The values of the sweep's keys, in the order of [`Plan::keys`].
    pub values: Vec<Value>,
}

/// All runs of a sweep. It holds whatever they need: files that change later are not read again. It
/// can be shared by threads; other processes read the same plan from the same file.
#[derive(Debug, Clone)]
pub struct Plan {
    pub(crate) file: SweepFile,
    pub(crate) documents: Documents,
    pub(crate) program: PathBuf,
    runs: Vec<PlannedRun>,
}

/// The k-th of n parts of a sweep, counted from 1: every n-th run, so that parts take alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// 1 … `of`.
    pub number: usize,
    /// How many there are.
    pub of: usize,
}

/// Text that is no shard.
#[derive(Debug, thiserror::Error)]
#[error("a shard reads as 2/7: the second of seven parts")]
pub struct ShardError;

impl FromStr for Shard {
    type Err = ShardError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let both = text.split_once('/').and_then(|(number, of)| number.parse().ok().zip(of.parse().ok()));
        let shard = both.map(|(number, of)| Self { number, of });
        shard.filter(|shard| (1..=shard.of).contains(&shard.number)).ok_or(ShardError)
    }
}

impl Shard {
    /// Whether the run with this place in the plan belongs to it.
    pub fn has(self, run: usize) -> bool {
        run % self.of + 1 == self.number
    }
}

impl Plan {
    /// Reads a sweep file with all files that it names, and works out its runs.
    ///
    /// # Errors
    /// If a file is wrong, a key leads nowhere, or none of the runs can be read: file, line and
    /// what is wrong.
    pub fn read(path: &Path) -> Result<Self, SweepError> {
        let file = SweepFile::read(path)?;
        let documents = Documents::read(&file)?;
        let points: Vec<_> = file.keys.iter().map(|key| key.points.clone()).collect();
        let mut runs = Vec::with_capacity(file.count);
        let mut first = None;
        for values in combinations(file.set, file.count, file.seed, &points) {
            let expanded = documents.expand(&file, &values).map_err(|(place, sentence)| {
                file.source.refuse(&format!("vary[{place}].key"), format!("is `{}`: {sentence}", file.keys[place].name))
            })?;
            runs.push(PlannedRun { hash: documents.hash(&file, &expanded), values });
            first.get_or_insert(expanded);
        }
        let plan = Self { file, documents, program: PathBuf::from("anemo"), runs };
        plan.check(first.as_ref())?;
        Ok(plan)
    }

    /// The same, whose steps are run by this program in place of the `anemo` on the path.
    ///
    /// # Errors
    /// If `refusal`, which is given the words behind `anemo`, has a sentence on one of the steps.
    pub fn with_program(
        self,
        program: PathBuf,
        refusal: impl Fn(&[String]) -> Option<String>,
    ) -> Result<Self, SweepError> {
        for (place, step) in self.file.then.iter().enumerate() {
            if let Some(sentence) = refusal(&step.words) {
                let refused = self.file.source.refuse(&format!("then[{place}]"), format!("is refused: {sentence}"));
                return Err(refused.into());
            }
        }
        Ok(Self { program, ..self })
    }

    /// What the sweep is called.
    pub fn title(&self) -> &str {
        &self.file.title
    }

    /// The varied keys, as the sweep file has them.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        self.file.keys.iter().map(|key| key.name.as_str())
    }

    /// All runs in their order; equal ones have the same hash, and are done once.
    pub fn runs(&self) -> &[PlannedRun] {
        &self.runs
    }

    /// The place of a run in [`Plan::runs`].
    pub fn place(&self, hash: &str) -> Option<usize> {
        self.runs.iter().position(|run| run.hash == hash)
    }

    /// Places of the runs of a shard, or of all; of equal runs the first.
    pub fn places(&self, shard: Option<Shard>) -> Vec<usize> {
        let mut known = std::collections::HashSet::new();
        let own = |place: &usize| shard.is_none_or(|shard| shard.has(*place));
        (0..self.runs.len()).filter(|place| known.insert(&self.runs[*place].hash)).filter(own).collect()
    }

    /// The shards, of so many, that have not settled all of their runs in the folder of a sweep: a
    /// run that failed is settled.
    pub fn missing(&self, folder: &Path, of: usize) -> Vec<MissingShard> {
        let settled = |place: &usize| {
            self.is_complete(*place, folder) || RunFolder::new(folder, &self.runs[*place].hash).failed().is_some()
        };
        let mut shards: Vec<MissingShard> =
            (1..=of).map(|shard| MissingShard { shard, of, missing: 0, runs: 0 }).collect();
        for place in self.places(None) {
            let shard = &mut shards[place % of];
            shard.runs += 1;
            shard.missing += usize::from(!settled(&place));
        }
        shards.retain(|shard| shard.missing > 0);
        shards
    }

    /// The values of a run for people: `wind.speed_m_s = 2.0, seed = 1`.
    pub fn described(&self, place: usize) -> String {
        let values = self.keys().zip(&self.runs[place].values);
        values.map(|(key, value)| format!("{key} = {value}")).collect::<Vec<_>>().join(", ")
    }

    /// The files of a run, which could be worked out before.
    pub(crate) fn expanded(&self, place: usize) -> ExpandedRun {
        self.documents.expand(&self.file, &self.runs[place].values).unwrap_or_default()
    }

    /// The folder of the sweep file, whole.
    pub(crate) fn folder(&self) -> PathBuf {
        let folder = folder_of(&self.file.source.path);
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        folder.canonicalize().unwrap_or_else(|_| folder.to_owned())
    }

    /// Refuses a sweep none of whose runs can be read: a wrong key is wrong in all of them. One
    /// that can is enough, since others may have values that are meant to be tried.
    fn check(&self, first: Option<&ExpandedRun>) -> Result<(), SweepError> {
        let Some(first) = first else { return Ok(()) };
        let scratch = tempfile::tempdir().map_err(|error| SweepError::folder(&std::env::temp_dir(), &error))?;
        let read = |run: &ExpandedRun| -> Result<Option<FileError>, SweepError> {
            let paths =
                write_experiments(run, scratch.path()).map_err(|error| SweepError::folder(scratch.path(), &error))?;
            Ok(paths.iter().find_map(|path| Experiment::read(path).err()))
        };
        let Some(error) = read(first)? else { return Ok(()) };
        for place in 1..self.runs.len() {
            if read(&self.expanded(place))?.is_none() {
                return Ok(());
            }
        }
        // The key whose name the sentence has is the one to look at.
        let blames = |last: &str| error.sentence.contains(&format!("`{last}`"));
        let names = self.file.keys.iter().map(|key| key.name.rsplit('.').next().unwrap_or_default());
        let key = names.into_iter().position(blames).map_or("vary".to_owned(), |place| format!("vary[{place}].key"));
        let which = error.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let sentence = format!("makes no run that can be read; {which} of the first: {}", error.sentence);
        Err(self.file.source.refuse(&key, sentence).into())
    }
}
