//! The stream to an emulated board: two named pipes.

use crate::instrument::link::BoardStream;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::AsFd;
use std::time::Duration;

/// One link of an emulated board: a pipe each way.
pub struct Pipe {
    pub(super) from_board: File,
    pub(super) to_board: File,
}

impl BoardStream for Pipe {
    fn read_within(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        let timeout = PollTimeout::try_from(timeout).unwrap_or(PollTimeout::MAX);
        if poll(&mut [PollFd::new(self.from_board.as_fd(), PollFlags::POLLIN)], timeout)? == 0 {
            return Err(ErrorKind::TimedOut.into());
        }
        match self.from_board.read(buffer)? {
            0 => Err(ErrorKind::UnexpectedEof.into()),
            read => Ok(read),
        }
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.to_board.write_all(bytes)
    }
}
