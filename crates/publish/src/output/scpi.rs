//! SCPI by TCP: a thread a connection, since the answer to a command may take seconds.

use super::scpi_session::{ScpiInstrument, ScpiLatest, ScpiSession};
use super::{Output, PublishContext, text};
use crate::feed::{FeedLayout, FeedRow, lock};
use crate::listen::Listener;
use crate::target::{PublishTarget, PublishWay};
use anyhow::bail;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, Weak};
use std::time::Duration;

/// Who connects beyond them is disconnected.
const MOST_SESSIONS: usize = 8;
/// A longer line is nobody's command.
const LONGEST_LINE: u64 = 4_096;
/// From one look at the end of the run to the next.
const WAIT: Duration = Duration::from_millis(200);

struct ScpiOutput {
    listener: Listener,
    instrument: Arc<ScpiInstrument>,
    sessions: Arc<AtomicUsize>,
}

/// Listens.
pub(super) fn open(
    target: &PublishTarget,
    layout: &FeedLayout,
    context: &PublishContext,
) -> anyhow::Result<Box<dyn Output>> {
    let PublishWay::Listener(at) = &target.way else {
        bail!("SCPI needs a listener");
    };
    let listener = context.listening.bind(text::resolved(at)?)?;
    let instrument = Arc::new(ScpiInstrument {
        layout: layout.clone(),
        latest: Mutex::new(ScpiLatest::default()),
        token: context.listening.token().clone(),
        commands: context.commands.clone(),
    });
    Ok(Box::new(ScpiOutput { listener, instrument, sessions: Arc::default() }))
}

impl Output for ScpiOutput {
    fn row(&mut self, row: &Arc<FeedRow>) -> anyhow::Result<()> {
        let mut latest = lock(&self.instrument.latest);
        if row.wind.is_some() {
            latest.wind.clone_from(&row.wind);
        }
        latest.row = Some(row.clone());
        Ok(())
    }

    fn turn(&mut self) -> anyhow::Result<()> {
        while let Some(stream) = self.listener.accept()? {
            if self.sessions.load(Ordering::Relaxed) >= MOST_SESSIONS {
                continue;
            }
            // It goes with the output: a session keeps nothing alive.
            let (instrument, sessions) = (Arc::downgrade(&self.instrument), self.sessions.clone());
            sessions.fetch_add(1, Ordering::Relaxed);
            let thread = std::thread::Builder::new().name("scpi".to_owned());
            thread.spawn(move || {
                // Whoever left has no use for an error.
                serve(stream, &instrument).ok();
                sessions.fetch_sub(1, Ordering::Relaxed);
            })?;
        }
        Ok(())
    }
}

/// Answers line by line, until the other side leaves or the run is over.
fn serve(mut stream: TcpStream, instrument: &Weak<ScpiInstrument>) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(WAIT))?;
    stream.set_write_timeout(Some(text::TIMEOUT))?;
    let (mut session, mut reader, mut line) = (ScpiSession::default(), BufReader::new(stream.try_clone()?), Vec::new());
    loop {
        let room = LONGEST_LINE.saturating_sub(line.len() as u64);
        let read = (&mut reader).take(room).read_until(b'\n', &mut line);
        let Some(instrument) = instrument.upgrade() else { return Ok(()) };
        match read {
            Ok(_) if line.ends_with(b"\n") => {
                if let Some(answer) = session.answer(String::from_utf8_lossy(&line).trim(), &instrument) {
                    stream.write_all(format!("{answer}\n").as_bytes())?;
                }
                line.clear();
            }
            // The end, or a line without one.
            Ok(_) => return Ok(()),
            Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => {}
            Err(error) => return Err(error),
        }
    }
}
