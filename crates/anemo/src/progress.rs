//! Progress bar and Ctrl-C of long work at a terminal.

use std::io::IsTerminal as _;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use recording::interrupt;

/// A bar of so many ticks on a terminal, nothing anywhere else.
pub(super) fn progress(title: &str, ticks: Option<u64>) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(ticks, ProgressDrawTarget::stderr_with_hz(10));
    let style = ProgressStyle::with_template("{msg}  {bar:40}  {percent:>3} %  {eta} left");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.set_message(title.to_owned());
    bar
}

/// Set by the first Ctrl-C (or a request to terminate, or the end of the terminal), so that the run
/// ends tidily and no heater stays on; the second one ends the process at once.
pub(super) fn on_interrupt() -> Arc<AtomicBool> {
    // A program around the command hears of signals itself.
    if let Some(flag) = interrupt::flag() {
        return flag;
    }
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    // Without a handler Ctrl-C still works, only less tidily.
    let _ = ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(1);
        }
    });
    interrupted
}

/// A bar on a terminal, nothing elsewhere.
pub(super) fn progress_bar() -> impl FnMut(&'static str, u64, u64) {
    let bar = ProgressBar::new(1);
    // Choosing cannot tell how far it is, and may take minutes with many event classes: the clock
    // shows that it goes on.
    bar.enable_steady_tick(std::time::Duration::from_millis(500));
    if let Ok(style) = ProgressStyle::with_template("{msg:18} {wide_bar} {percent} % {elapsed}") {
        bar.set_style(style);
    }
    move |what, done, all| {
        end_if_interrupted();
        bar.set_message(what);
        bar.set_length(all.max(1));
        bar.set_position(done);
        if done >= all {
            bar.set_position(0);
        }
    }
}

/// What unwinds from work that shows its progress, once its caller wants its end.
pub(super) struct Ended;

fn end_if_interrupted() {
    if interrupt::is_interrupted() {
        // Unwinding lets go of all that is half done; whoever set the flag catches it.
        std::panic::resume_unwind(Box::new(Ended));
    }
}
