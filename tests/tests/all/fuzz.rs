//! The short run of the fuzz targets: each is given its corpus, a fixed number of damaged copies of
//! it, the same every time, and what was once found.
//!
//! Invariants are written in [`anemo_tests::fuzz`]; the long run is `cargo xtask fuzz`. An input at
//! which something does not hold is written to the temporary folder and named, to be repeated by
//! `ANEMO_FUZZ_INPUT=FILE cargo test --release -p anemo-tests --test all fuzz::`.

use anemo_tests::file;
use anemo_tests::fuzz::damage::Damage;
use anemo_tests::fuzz::{TARGETS, Target};
use flate2::read::GzDecoder;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read as _;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

/// Damaged copies for each target: some seconds for all of them together. `ANEMO_FUZZ_DAMAGED`
/// gives another number.
const DAMAGED: usize = 2_000;

fn copies() -> usize {
    let asked = std::env::var("ANEMO_FUZZ_DAMAGED").ok();
    asked.map_or(DAMAGED, |number| number.parse().expect("ANEMO_FUZZ_DAMAGED is a whole number"))
}

/// The inputs of a target that people put together, in the order of their names, so that the damage
/// is the same on every computer.
fn corpus(target: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = file("tools/fuzz/corpus").join(target);
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("the folder can be read").path()).collect();
    paths.sort();
    assert!(paths.len() >= 4, "{}: a corpus of {} inputs is none", folder.display(), paths.len());
    paths.into_iter().map(|path| (path.clone(), std::fs::read(path).expect("a kept input can be read"))).collect()
}

/// Inputs that libFuzzer has found.
fn found(target: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let path = file("tools/fuzz/found").join(format!("{target}.tar.gz"));
    let archive = File::open(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut archive = tar::Archive::new(GzDecoder::new(archive));
    let entries = archive.entries().unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let read = |entry: std::io::Result<tar::Entry<'_, _>>| {
        let mut entry = entry?;
        let mut input = Vec::new();
        entry.read_to_end(&mut input)?;
        Ok((path.join(entry.path()?), input))
    };
    entries
        .map(|entry| read(entry).unwrap_or_else(|error: std::io::Error| panic!("{}: {error}", path.display())))
        .collect()
}

/// Runs a target; where something does not hold, the input is kept and named.
fn run(target: Target, input: &[u8], what: &str) -> bool {
    catch_unwind(AssertUnwindSafe(|| (target.run)(input))).unwrap_or_else(|_| {
        let path = std::env::temp_dir().join(format!("anemo-fuzz-{}", target.name));
        std::fs::write(&path, input).expect("there is room for temporary files");
        panic!("target {} does not hold for {what}, which is {} now", target.name, path.display());
    })
}

/// The corpus, its damaged copies and what was found; of each some are taken, or nothing is tried
/// any more.
fn short_run(name: &str) {
    let target = *TARGETS.iter().find(|target| target.name == name).expect("it is one of the targets");
    if let Some(input) = std::env::var_os("ANEMO_FUZZ_INPUT") {
        run(target, &std::fs::read(&input).expect("the input can be read"), &input.display().to_string());
        return;
    }
    let corpus = corpus(name);
    let kept = |(path, input): &&(PathBuf, Vec<u8>)| run(target, input, &path.display().to_string());
    let taken = corpus.iter().filter(kept).count();
    assert!(taken > 0, "{name}: of {} inputs none is taken: are they of an older format?", corpus.len());

    let mut damage = Damage::new(20_261_122);
    let (copies, mut damaged_taken) = (copies(), 0);
    for number in 0..copies {
        let (_, whole) = &corpus[number % corpus.len()];
        damaged_taken += usize::from(run(target, &damage.of(whole), &format!("damaged copy {number}")));
    }
    assert!((1..copies).contains(&damaged_taken), "{name}: {damaged_taken} of {copies} damaged inputs taken");

    let found = found(name);
    let found_taken = found.iter().filter(kept).count();
    assert!(found_taken > 0, "{name}: of {} found inputs none is taken", found.len());
    println!(
        "{name}: {taken} of {} inputs, {damaged_taken} of {copies} damaged and {found_taken} of {} found ones are taken",
        corpus.len(),
        found.len()
    );
}

/// A test for each, so that they run side by side and each is named.
macro_rules! short_runs {
    ($($target:ident)*) => {
        $(#[test]
        fn $target() {
            short_run(stringify!($target));
        })*

        /// Targets that run here, targets of libFuzzer and existing ones are the same.
        #[test]
        fn every_target_has_its_program_its_corpus_and_its_test() {
            let all: BTreeSet<String> = TARGETS.iter().map(|target| target.name.to_owned()).collect();
            assert_eq!(all, BTreeSet::from([$(stringify!($target).to_owned()),*]));
            let names = |folder: &Path| -> BTreeSet<String> {
                let entries = std::fs::read_dir(folder).expect("the folder is there");
                let stem = |path: PathBuf| path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
                entries.filter_map(|entry| stem(entry.ok()?.path())).collect()
            };
            assert_eq!(all, names(&file("tools/fuzz/fuzz_targets")));
            assert_eq!(all, names(&file("tools/fuzz/corpus")));
            let archives = names(&file("tools/fuzz/found"));
            assert_eq!(all, archives.iter().map(|name| name.trim_end_matches(".tar").to_owned()).collect());
            let manifest: toml::Table =
                std::fs::read_to_string(file("tools/fuzz/Cargo.toml")).expect("it is there").parse().expect("it is TOML");
            let bins = manifest["bin"].as_array().expect("there are programs").iter();
            assert_eq!(all, bins.map(|bin| bin["name"].as_str().expect("a name").to_owned()).collect());
        }
    };
}

short_runs!(command experiment flash frame head model record settings);
