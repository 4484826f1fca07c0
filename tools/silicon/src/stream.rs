//! The line to the machine as a host has it: the ordinary instrument and its experiments run on it.
//!
//! Time passes for the machine only while the host waits for it.

use crate::machine::{Machine, MachineError};
use crate::time::CYCLES_PER_SECOND;
use host_sim::instrument::link::BoardStream;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::io::{self, ErrorKind};
use std::rc::Rc;
use std::time::Duration;

/// The host's end of a machine's line. Others may do something to the machine meanwhile.
pub struct MachineStream {
    machine: Rc<RefCell<Machine>>,
    unread: VecDeque<u8>,
}

impl MachineStream {
    /// The end of this machine's line.
    pub const fn new(machine: Rc<RefCell<Machine>>) -> Self {
        Self { machine, unread: VecDeque::new() }
    }
}

impl BoardStream for MachineStream {
    fn now(&self) -> Duration {
        duration(self.machine.borrow().now())
    }

    fn true_wind_m_s(&self) -> Option<[f64; 3]> {
        Some(self.machine.borrow().board().plant.wind_m_s())
    }

    fn read_within(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        if self.unread.is_empty() {
            let mut machine = self.machine.borrow_mut();
            let until = machine.now() + cycles(timeout);
            machine.run_until_frame(until).map_err(broken)?;
            for (_, bytes) in machine.board_mut().host.frames() {
                self.unread.extend(bytes);
            }
        }
        let read = buffer.len().min(self.unread.len());
        if read == 0 {
            return Err(ErrorKind::TimedOut.into());
        }
        for (place, byte) in buffer.iter_mut().zip(self.unread.drain(..read)) {
            *place = byte;
        }
        Ok(read)
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.machine.borrow_mut().board_mut().receive(bytes);
        Ok(())
    }
}

fn broken(error: MachineError) -> io::Error {
    io::Error::other(error)
}

/// A time of the machine.
pub fn duration(cycles: u64) -> Duration {
    let (seconds, rest) = (cycles / CYCLES_PER_SECOND, cycles % CYCLES_PER_SECOND);
    Duration::new(seconds, (rest * 1_000_000_000 / CYCLES_PER_SECOND) as u32)
}

/// The same the other way, rounded up so that waiting for it is waiting long enough.
pub fn cycles(duration: Duration) -> u64 {
    let nanoseconds = u128::from(duration.subsec_nanos()) * u128::from(CYCLES_PER_SECOND);
    duration.as_secs().saturating_mul(CYCLES_PER_SECOND).saturating_add(nanoseconds.div_ceil(1_000_000_000) as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waiting_for_a_time_reaches_it() {
        for nanoseconds in [1, 999, 5_952, 1_000_000_007] {
            let wanted = Duration::from_nanos(nanoseconds);
            assert!(duration(cycles(wanted)) + Duration::from_nanos(1) >= wanted);
        }
        assert_eq!(duration(CYCLES_PER_SECOND), Duration::from_secs(1));
    }
}
