//! The live page: a web page of what an instrument measures, for any browser of this computer, that
//! needs no internet.
//!
//! ```text
//! feed ──► state: windows of min, max, mean; samples; events ──► a thread a listener, 10 times/s
//! ```
//!
//! | address | what |
//! |---|---|
//! | `GET /TOKEN/` | the page, whole in one file |
//! | `GET /TOKEN/events?window_s=60&spectrum=3` | server-sent events: `layout`, `rows`, `event`, `spectrum`, `ended` |
//! | `POST /TOKEN/command` | a command as JSON; the answer is `{"done": …}` or `{"refused": …}` |
//!
//! A listener that is slow gets fewer pictures and holds nobody up. Whoever lacks the token, or
//! asks by another name of this computer, or from another page, is refused.

mod connection;
mod http;
mod message;
mod spectrum;
mod state;
mod window;

use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::commands::FeedCommands;
use crate::feed::{Feed, FeedReader, lock};
use crate::listen::{ListenError, Listener, Listening};
use connection::Served;
use state::PageState;

/// Rows that may wait to be shown: a minute of them, at 1 kHz.
const QUEUE: usize = 1 << 16;
/// Listeners at one time.
const MOST_LISTENERS: usize = 16;
/// Interval at which threads look whether they shall end.
const WAIT: Duration = Duration::from_millis(100);
/// Between two looks whether somebody has come.
const LOOK: Duration = Duration::from_millis(20);
/// Time that the last pictures may take to reach their pages.
const FAREWELL: Duration = Duration::from_secs(1);

/// A page that is being served, until it is dropped.
pub struct LivePage {
    address: String,
    stopping: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
    listeners: Arc<Mutex<usize>>,
}

impl LivePage {
    /// Serves what the feed has from now on; without `commands`, as for a recording, people can
    /// only look.
    ///
    /// # Errors
    /// If nothing may or can listen at this address.
    pub fn serve(
        feed: &Feed,
        commands: Option<FeedCommands>,
        listening: &Listening,
        address: SocketAddr,
    ) -> Result<Self, ListenError> {
        let listener = listening.bind(address)?;
        let state = Arc::new(Mutex::new(PageState::new(feed.layout().clone())));
        let stopping = Arc::new(AtomicBool::new(false));
        let listeners = Arc::new(Mutex::new(0));
        let (token, bound) = (listening.token().clone(), listener.address());
        let address = format!("http://{bound}/{}/", token.text());
        let served = Served { state: Arc::clone(&state), commands, address: bound, token };
        let reader = feed.subscribe(QUEUE);
        let fills = {
            let stopping = Arc::clone(&stopping);
            std::thread::spawn(move || fill(&state, &reader, &stopping))
        };
        let accepts = {
            let (stopping, listeners) = (Arc::clone(&stopping), Arc::clone(&listeners));
            std::thread::spawn(move || accept(&listener, &served, &stopping, &listeners))
        };
        Ok(Self { address, stopping, threads: vec![fills, accepts], listeners })
    }

    /// Where it is, with its token: for a browser of this computer.
    pub fn address(&self) -> &str {
        &self.address
    }
}

impl Drop for LivePage {
    /// Pages get what is left, and that it is the last; then their connections end.
    fn drop(&mut self) {
        self.stopping.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            // The message of a thread is gone with its page.
            let _ = thread.join();
        }
        let begun = Instant::now();
        while *lock(&self.listeners) > 0 && begun.elapsed() < FAREWELL {
            std::thread::sleep(WAIT / 10);
        }
    }
}

/// Keeps what the feed brings, until it ends or the page does.
fn fill(state: &Mutex<PageState>, reader: &FeedReader, stopping: &AtomicBool) {
    loop {
        // Before the last look, so that nothing is left.
        let is_last = stopping.load(Ordering::Relaxed);
        match reader.recv_timeout(if is_last { Duration::ZERO } else { WAIT }) {
            Ok(item) => {
                let mut state = lock(state);
                state.push(item, reader.lost());
                // All that waits is taken at once: looking is cheap, locking is not.
                while let Ok(item) = reader.recv_timeout(Duration::ZERO) {
                    state.push(item, reader.lost());
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        if is_last {
            break;
        }
    }
    lock(state).end();
}

fn accept(listener: &Listener, served: &Served, stopping: &AtomicBool, listeners: &Arc<Mutex<usize>>) {
    while !stopping.load(Ordering::Relaxed) {
        let Ok(Some(stream)) = listener.accept() else {
            std::thread::sleep(LOOK);
            continue;
        };
        if *lock(listeners) >= MOST_LISTENERS {
            continue;
        }
        *lock(listeners) += 1;
        let (served, listeners) = (served.clone(), Arc::clone(listeners));
        std::thread::spawn(move || {
            // A listener that goes away in the middle is no failure of ours.
            let _ = served.answer(stream);
            *lock(&listeners) -= 1;
        });
    }
}

#[cfg(test)]
mod tests;
