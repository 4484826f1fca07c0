//! Commands for another program in its own process, as the Python package calls them: the same
//! words, checks and sentences, with what is printed and warned of handed over.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use recording::interrupt;

use crate::Unparsed;
use crate::output::hear;
pub use crate::output::{Failure, HeardCommand};
use crate::progress::Ended;

/// Outcome of a command.
#[derive(Debug)]
pub struct Performed {
    /// Words of the command.
    pub heard: HeardCommand,
    /// It could be done.
    pub outcome: Result<(), Failure>,
}

/// Carries out a command in this thread; `words` are those behind `anemo`. Nothing is printed. The
/// flag ends what takes long, as Ctrl-C does.
pub fn perform(words: &[String], interrupted: &Arc<AtomicBool>) -> Performed {
    let (outcome, heard) = hear(|| {
        let arguments = crate::parsed(words).map_err(|unparsed| match unparsed {
            Unparsed::Refused(failure) => failure,
            Unparsed::Shown(error) => Failure::usage(crate::one_sentence(&error, words)),
        })?;
        let work = || crate::execute(&arguments.command);
        let done = interrupt::interruptible(interrupted, || catch_unwind(AssertUnwindSafe(work)));
        done.unwrap_or_else(|panic| match panic.downcast::<Ended>() {
            Ok(_) => Err(Failure { code: 4, sentence: "it was interrupted".to_owned() }),
            Err(defect) => resume_unwind(defect),
        })
    });
    Performed { heard, outcome }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::Ordering;

    fn words(line: &str) -> Vec<String> {
        line.split(' ').map(str::to_owned).collect()
    }

    #[test]
    fn what_a_command_says_is_handed_over_and_its_failure_is_the_sentence_of_the_command_line() {
        let flag = Arc::new(AtomicBool::new(false));
        let wrong = perform(&words("identify none.csv --odrer 3"), &flag);
        assert!(wrong.outcome.unwrap_err().sentence.starts_with("unexpected argument '--odrer' found"));
        let missing = perform(&words("identify none.csv"), &flag).outcome.unwrap_err();
        assert_eq!((missing.code, missing.sentence.as_str()), (2, "none.csv: there is no such file"));
        let model = concat!(env!("CARGO_MANIFEST_DIR"), "/../../crates/diffusive/examples/hot_film.json");
        let done = perform(&words(&format!("analyse {model} --target 20 --class calm --json")), &flag);
        assert!(done.outcome.is_ok() && done.heard.printed.starts_with('{'), "{done:?}");
    }

    #[test]
    fn work_ends_at_its_next_look_at_the_flag_and_the_thread_goes_on() {
        let folder = tempfile::tempdir().unwrap();
        let csv = folder.path().join("a.csv");
        let rows: String = (0..200).map(|n| format!("{n},{},{}\n", n % 7 % 2, 20 + n % 7)).collect();
        std::fs::write(&csv, format!("time_s,u,y\n{rows}")).unwrap();
        let flag = Arc::new(AtomicBool::new(true));
        let line = format!("identify {} --json", csv.display());
        let ended = perform(&words(&line), &flag).outcome.unwrap_err();
        assert!(ended.sentence.ends_with("interrupted"), "{ended}");
        flag.store(false, Ordering::Relaxed);
        assert!(perform(&words(&line), &flag).outcome.is_ok());
    }
}
