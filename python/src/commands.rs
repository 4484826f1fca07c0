//! Commands of the command line in this process, on a thread of their own.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, mpsc};
use std::time::Duration;

use anemo::in_process::{Failure, Performed};
use pyo3::prelude::*;
use recording::in_memory::InMemory;

use crate::arrow_table::ArrowTable;
use crate::error::error;
use crate::model::PyModel;
use crate::table::PyTable;

/// Interval at which Python is asked for signals.
const LOOK: Duration = Duration::from_millis(50);
/// Stack of the main thread of a command.
const STACK_BYTES: usize = 8 << 20;

/// Commands that are at work.
static AT_WORK: AtomicUsize = AtomicUsize::new(0);
/// This process was forked from one in which a command was at work.
static FORKED_AT_WORK: AtomicBool = AtomicBool::new(false);

/// A text that commands read like a file; what it names is sought from its folder.
#[pyclass(module = "anemo", frozen)]
pub struct Text {
    folder: PathBuf,
    extension: String,
    text: String,
}

#[pymethods]
impl Text {
    #[new]
    fn new(folder: PathBuf, extension: String, text: String) -> Self {
        Self { folder, extension, text }
    }

    /// Writes the file, in whole or not at all.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let failed = |reason| error(py, 1, &format!("{}: cannot be written: {reason}", path.display()));
        recording::Temporary::write(&path, self.text.as_bytes()).map_err(failed)
    }
}

/// A word of a command line, or what stands for one.
#[derive(FromPyObject)]
pub enum Argument<'py> {
    Word(String),
    Table(PyRef<'py, PyTable>),
    Model(PyRef<'py, PyModel>),
    Text(PyRef<'py, Text>),
}

/// Words as the command has them, names that last as long as it works, and what these stand for.
#[derive(Default)]
struct Words {
    words: Vec<String>,
    named: Vec<InMemory>,
    called: Vec<(String, &'static str)>,
}

impl Words {
    fn push(&mut self, option: &str, word: &Argument<'_>) {
        let (named, what) = match word {
            Argument::Word(word) => return self.words.push(format!("{option}{word}")),
            Argument::Table(table) => (InMemory::table(Arc::clone(&table.inner) as _), "the table"),
            Argument::Model(model) => (InMemory::text("".as_ref(), "json", &model.inner.to_json()), "the model"),
            Argument::Text(text) => (InMemory::text(&text.folder, &text.extension, &text.text), "the text"),
        };
        self.name(option, &named, what);
        self.named.push(named);
    }

    fn name(&mut self, option: &str, named: &InMemory, what: &'static str) {
        let path = named.path().display().to_string();
        self.words.push(format!("{option}{path}"));
        self.called.push((path, what));
    }

    /// A sentence in which what has a name for the moment only is called what it is.
    fn readable(&self, sentence: &str) -> String {
        self.called.iter().fold(sentence.to_owned(), |sentence, (path, what)| sentence.replace(path, what))
    }
}

/// Outcome of a command: its JSON and text, its warnings, exit code and sentence, the recording if
/// one was wanted, and the signal that came meanwhile.
type Done = (Option<String>, String, Vec<String>, u8, Option<String>, Option<PyTable>, Option<PyErr>);

/// Carries out a command, whose words stand each behind its option ("--head=") or nothing. `place`
/// is the option for a recording that comes back as a table. A first KeyboardInterrupt ends the
/// work, and what it has done comes back with it; a second one leaves the work alone.
#[pyfunction]
#[pyo3(signature = (words, place = None))]
pub fn perform(py: Python<'_>, words: Vec<(String, Argument<'_>)>, place: Option<&str>) -> PyResult<Done> {
    let mut all = Words::default();
    words.iter().for_each(|(option, word)| all.push(option, word));
    let wanted = place.map(|option| {
        let wanted = InMemory::place();
        all.name(&format!("{option}="), &wanted, "the table");
        wanted
    });
    let words = all.words.clone();
    let (performed, signal) = waited_for(py, move |interrupted| anemo::in_process::perform(&words, interrupted))?;
    let Performed { heard, outcome } = performed;
    let readable = |text: &str| all.readable(text);
    let table = wanted.and_then(InMemory::take).map(|written| PyTable::of(ArrowTable::of_columns(written)));
    let (code, sentence) = match outcome {
        Ok(()) => (0, None),
        Err(Failure { code, sentence }) => (code, Some(readable(&sentence))),
    };
    let warnings = heard.warnings.iter().map(|warning| readable(warning)).collect();
    Ok((heard.json.map(|json| readable(&json)), readable(&heard.printed), warnings, code, sentence, table, signal))
}

/// Does work on a thread, with a pool of its own, so that no thread is left once it is done. The
/// flag that the work is given says that it shall end.
fn waited_for<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Arc<AtomicBool>) -> T + Send + 'static,
) -> PyResult<(T, Option<PyErr>)> {
    if FORKED_AT_WORK.load(Ordering::Relaxed) {
        let sentence = "this process was forked while another thread was at work in anemo, whose locks it has kept: \
                        start processes by multiprocessing.get_context(\"spawn\")";
        return Err(error(py, 1, &sentence));
    }
    let (sender, mut receiver) = mpsc::channel();
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    AT_WORK.fetch_add(1, Ordering::SeqCst);
    std::thread::spawn(move || {
        let pool = rayon::ThreadPoolBuilder::new().stack_size(STACK_BYTES).build();
        let done = pool.map(|pool| pool.install(|| work(&flag)));
        AT_WORK.fetch_sub(1, Ordering::SeqCst);
        // Nobody listens where the work was left alone.
        let _ = sender.send(done);
    });
    let mut signal = None;
    loop {
        let listening = &mut receiver;
        match py.detach(move || listening.recv_timeout(LOOK)) {
            Ok(done) => {
                let done = done.map_err(|reason| error(py, 1, &format!("no threads can be started: {reason}")));
                return Ok((done?, signal));
            }
            Err(mpsc::RecvTimeoutError::Timeout) => {
                let Err(raised) = py.check_signals() else { continue };
                interrupted.store(true, Ordering::Relaxed);
                if signal.is_some() {
                    return Err(raised);
                }
                signal = Some(raised);
            }
            Err(mpsc::RecvTimeoutError::Disconnected) => {
                AT_WORK.fetch_sub(1, Ordering::SeqCst);
                return Err(error(py, 1, &"the work has ended by a defect, which stands on stderr: please report it"));
            }
        }
    }
}

/// Called in a child process after a fork.
#[pyfunction]
pub fn forked() {
    FORKED_AT_WORK.store(AT_WORK.load(Ordering::SeqCst) > 0, Ordering::Relaxed);
}

/// The command line itself, with the words of this process; gives its exit code.
#[pyfunction]
pub fn main(py: Python<'_>, words: Vec<String>) -> u8 {
    py.detach(|| anemo::main_of(&words))
}
