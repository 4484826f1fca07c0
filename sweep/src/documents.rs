//! The TOML files that a sweep changes, read once, and a run's own versions of them.
//!
//! A run's files are written without comments and with sorted keys, so that its hash is that of
//! what it does. The experiment names its head and models by their names in the run's folder: the
//! folder can be moved, and its experiment run again by `anemo run`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use toml::{Table, Value};
use twox_hash::XxHash3_128;

use crate::error::EntryError;
use crate::sweep_file::{SweepFile, VariedPlace};
use recording::toml_file::{FileError, TomlSource};

/// A file as it is read: its table, and the same as text.
#[derive(Debug, Clone)]
struct Document {
    table: Table,
    text: String,
}

/// All files that runs may begin from, by their paths from the working folder.
#[derive(Debug, Clone, Default)]
pub(crate) struct Documents {
    documents: BTreeMap<PathBuf, Document>,
    /// Hashes of recordings.
    recordings: BTreeMap<PathBuf, String>,
    /// Hashes of what steps read beside the sweep file.
    read_by_steps: Vec<String>,
}

/// An experiment of a run: the texts of its files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ExpandedExperiment {
    /// Name of its files: `steady` of `steady.toml`, `steady.head.toml`, `steady.parquet`.
    pub stem: String,
    pub experiment: String,
    pub head: String,
    pub models: Option<String>,
}

/// All that a run consists of.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct ExpandedRun {
    pub experiments: Vec<ExpandedExperiment>,
    /// A recording in place of experiments.
    pub recording: Option<PathBuf>,
}

impl Documents {
    /// Reads whatever the runs of a sweep may begin from.
    pub fn read(file: &SweepFile) -> Result<Self, FileError> {
        let mut all = Self::default();
        for experiment in &file.experiments {
            all.add_experiment(experiment).map_err(|error| named_by(&file.source, "experiment", error))?;
        }
        let folder = folder_of(&file.source.path);
        for (place, key) in file.keys.iter().enumerate() {
            let crate::sampling::Points::Listed(values) = &key.points else { continue };
            for (varied, path) in key
                .places
                .iter()
                .flat_map(|varied| values.iter().filter_map(move |value| Some((varied, value.as_str()?))))
            {
                let path = folder.join(path);
                let added = match varied {
                    VariedPlace::ExperimentFile => all.add_experiment(&path),
                    VariedPlace::HeadFile | VariedPlace::ModelsFile => all.add(&path).map(|_| ()),
                    VariedPlace::RecordingFile => all.add_recording(&path),
                    _ => continue,
                };
                added.map_err(|error| named_by(&file.source, &format!("vary[{place}].key"), error))?;
            }
        }
        for (place, step) in file.then.iter().enumerate() {
            for path in step.files_in(folder) {
                let hash = content_hash(&path);
                let hash = hash.map_err(|error| named_by(&file.source, &format!("then[{place}]"), error))?;
                all.read_by_steps.push(hash);
            }
        }
        Ok(all)
    }

    fn add(&mut self, path: &Path) -> Result<&Table, FileError> {
        if !self.documents.contains_key(path) {
            let table: Table = TomlSource::read(path)?.parse()?;
            let text = table.to_string();
            self.documents.insert(path.to_owned(), Document { table, text });
        }
        Ok(&self.documents[path].table)
    }

    fn add_experiment(&mut self, path: &Path) -> Result<(), FileError> {
        let table = self.add(path)?;
        let refuse = |sentence: &str| FileError { path: path.to_owned(), line: None, sentence: sentence.to_owned() };
        if table.contains_key("device") {
            return Err(refuse("is an experiment on a device: a sweep runs those on heads"));
        }
        let head =
            named_in(path, table, "head").ok_or_else(|| refuse("names no `head`: an experiment belongs here"))?;
        let models = named_in(path, table, "models");
        for (key, named) in [("head", Some(head)), ("models", models)] {
            let Some(named) = named else { continue };
            if let Err(error) = self.add(&named) {
                return Err(named_by(&TomlSource::read(path)?, key, error));
            }
        }
        Ok(())
    }

    fn add_recording(&mut self, path: &Path) -> Result<(), FileError> {
        self.recordings.insert(path.to_owned(), content_hash(path)?);
        Ok(())
    }

    /// The files of a run whose keys have these values.
    ///
    /// # Errors
    /// The place of the key that leads nowhere, and a sentence.
    pub fn expand(&self, file: &SweepFile, values: &[Value]) -> Result<ExpandedRun, (usize, EntryError)> {
        let folder = folder_of(&file.source.path);
        let given = |wanted: &VariedPlace| {
            let of = file.keys.iter().zip(values).find(|(key, _)| key.places.contains(wanted));
            of.and_then(|(_, value)| Some(folder.join(value.as_str()?)))
        };
        let recording = given(&VariedPlace::RecordingFile);
        if recording.is_some() {
            return Ok(ExpandedRun { experiments: Vec::new(), recording });
        }
        let own = given(&VariedPlace::ExperimentFile);
        let paths = own.as_ref().map_or(&file.experiments[..], std::slice::from_ref);
        let (head, models) = (given(&VariedPlace::HeadFile), given(&VariedPlace::ModelsFile));
        let experiments =
            paths.iter().map(|path| self.expand_one(file, values, path, head.as_deref(), models.as_deref()));
        Ok(ExpandedRun { experiments: experiments.collect::<Result<_, _>>()?, recording: None })
    }

    fn expand_one(
        &self,
        file: &SweepFile,
        values: &[Value],
        path: &Path,
        head: Option<&Path>,
        models: Option<&Path>,
    ) -> Result<ExpandedExperiment, (usize, EntryError)> {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut experiment = self.documents[path].table.clone();
        let head = head.map(Path::to_owned).or_else(|| named_in(path, &experiment, "head"));
        let models = models.map(Path::to_owned).or_else(|| named_in(path, &experiment, "models"));
        for (name, file) in [("head", &head), ("models", &models)] {
            if file.is_some() {
                experiment.insert(name.to_owned(), format!("{stem}.{name}.toml").into());
            }
        }
        let of = |path: Option<PathBuf>| path.and_then(|path| self.documents.get(&path));
        let (head, models) = (of(head), of(models));
        // Tables that no key changes are not copied.
        let (mut changed_head, mut changed_models) = (None, None);
        for (place, (key, value)) in file.keys.iter().zip(values).enumerate() {
            for varied in &key.places {
                let into = |document: Option<&Document>, changed: &mut Option<Table>, path: &crate::key::KeyPath| {
                    let document = document.ok_or(EntryError::from("the experiment names no such file"))?;
                    path.set(changed.get_or_insert_with(|| document.table.clone()), value)
                };
                let put = match varied {
                    VariedPlace::Experiment(path) => path.set(&mut experiment, value),
                    VariedPlace::Head(path) => into(head, &mut changed_head, path),
                    VariedPlace::Models(path) => into(models, &mut changed_models, path),
                    _ => Ok(()),
                };
                put.map_err(|sentence| (place, sentence))?;
            }
        }
        let text = |changed: Option<Table>, document: Option<&Document>| {
            changed.map(|table| table.to_string()).or_else(|| document.map(|document| document.text.clone()))
        };
        Ok(ExpandedExperiment {
            stem,
            experiment: experiment.to_string(),
            head: text(changed_head, head).unwrap_or_default(),
            models: text(changed_models, models),
        })
    }

    /// The hash of a run: of its files, of what is done with it and read for that, and of the
    /// version that does it.
    pub fn hash(&self, file: &SweepFile, run: &ExpandedRun) -> String {
        let mut hasher = XxHash3_128::new();
        let mut add = |part: &str| {
            hasher.write(&(part.len() as u64).to_le_bytes());
            hasher.write(part.as_bytes());
        };
        add(concat!("anemo ", env!("CARGO_PKG_VERSION")));
        for ExpandedExperiment { stem, experiment, head, models } in &run.experiments {
            [stem, experiment, head, models.as_ref().unwrap_or(&String::new())].into_iter().for_each(|part| add(part));
        }
        run.recording.iter().filter_map(|path| self.recordings.get(path)).for_each(|hash| add(hash));
        file.then.iter().for_each(|step| add(&step.words.join("\0")));
        self.read_by_steps.iter().for_each(|hash| add(hash));
        format!("{:032x}", hasher.finish_128())
    }
}

fn content_hash(path: &Path) -> Result<String, FileError> {
    use std::io::Read as _;
    let unreadable = |error: std::io::Error| FileError {
        path: path.to_owned(),
        line: None,
        sentence: format!("cannot be read: {error}"),
    };
    let mut file = recording::regular::open(path).map_err(unreadable)?;
    let mut hasher = XxHash3_128::new();
    let mut piece = vec![0; 1 << 20];
    loop {
        match file.read(&mut piece).map_err(unreadable)? {
            0 => return Ok(format!("{:032x}", hasher.finish_128())),
            read => hasher.write(&piece[..read]),
        }
    }
}

/// The folder of a file, from which its paths count.
pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// The file that an experiment names under a key.
fn named_in(experiment: &Path, table: &Table, key: &str) -> Option<PathBuf> {
    Some(folder_of(experiment).join(table.get(key)?.as_str()?))
}

/// A file that is not there is the mistake of the file that names it; one that is wrong is its own.
fn named_by(source: &TomlSource, key: &str, error: FileError) -> FileError {
    match error.line {
        None if error.path != source.path => source.refuse(key, format!("cannot be used: {error}")),
        _ => error,
    }
}
