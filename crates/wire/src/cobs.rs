//! Consistent overhead byte stuffing without an index that could be out of range.
//!
//! The states are those of the crate `cobs`. Its own loops over a buffer, and those of `postcard`,
//! index it; they do so rightly, but the compiler cannot see it and leaves panics in the image, of
//! which the firmware must have none. Here a place that is not there is an error.

use cobs::{DecodeResult, DecoderState, EncoderState, PushResult};
use postcard::ser_flavors::Flavor;

/// Stuffs what is serialised into a buffer; the terminator is added at the end.
pub struct Stuffed<'a> {
    buffer: &'a mut [u8],
    length: usize,
    state: EncoderState,
}

impl<'a> Stuffed<'a> {
    /// Begins a frame with the place of the first code.
    pub fn new(buffer: &'a mut [u8]) -> postcard::Result<Self> {
        let mut stuffed = Self { buffer, length: 0, state: EncoderState::default() };
        stuffed.add(0)?;
        Ok(stuffed)
    }

    #[inline(always)]
    fn add(&mut self, byte: u8) -> postcard::Result<()> {
        self.put(self.length, byte)?;
        self.length += 1;
        Ok(())
    }

    #[inline(always)]
    fn put(&mut self, place: usize, byte: u8) -> postcard::Result<()> {
        *self.buffer.get_mut(place).ok_or(postcard::Error::SerializeBufferFull)? = byte;
        Ok(())
    }
}

impl<'a> Flavor for Stuffed<'a> {
    type Output = &'a [u8];

    #[inline(always)]
    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        match self.state.push(byte) {
            PushResult::AddSingle(byte) => self.add(byte),
            PushResult::ModifyFromStartAndSkip((place, code)) => {
                self.put(place, code)?;
                self.add(0)
            }
            PushResult::ModifyFromStartAndPushAndSkip((place, code, byte)) => {
                self.put(place, code)?;
                self.add(byte)?;
                self.add(0)
            }
        }
    }

    fn finalize(mut self) -> postcard::Result<&'a [u8]> {
        let (place, code) = core::mem::take(&mut self.state).finalize();
        self.put(place, code)?;
        self.add(0)?;
        let Self { buffer, length, .. } = self;
        buffer.get(..length).ok_or(postcard::Error::SerializeBufferFull)
    }
}

/// Takes the stuffing out of a frame without its terminator, in place. Gives the content's length,
/// or nothing if it is no such frame.
pub fn unstuff(frame: &mut [u8]) -> Option<usize> {
    let mut state = DecoderState::Idle;
    let mut length = 0;
    for source in 0..frame.len() {
        let byte = *frame.get(source)?;
        // Content is shorter than its frame: no byte is written before it has been read.
        if let DecodeResult::DataContinue(byte) = state.feed(byte).ok()? {
            *frame.get_mut(length)? = byte;
            length += 1;
        }
    }
    matches!(state.feed(0), Ok(DecodeResult::DataComplete)).then_some(length)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    /// Contents with runs of every length around those at which a code is full, zeros between,
    /// before and behind.
    fn contents() -> impl Iterator<Item = Vec<u8>> {
        // Interpreted, only lengths about those at which a code is full.
        let lengths = if cfg!(miri) { 252..257 } else { 0..600_usize };
        lengths.flat_map(|length| {
            [usize::MAX, 1, 2, 7, 253, 254, 255, 256].map(|every| {
                (0..length).map(|i| if i % every == every - 1 { 0 } else { (i % 255) as u8 + 1 }).collect::<Vec<u8>>()
            })
        })
    }

    #[test]
    fn stuffs_and_takes_out_as_the_crate_does() {
        for content in contents() {
            let (mut ours, mut theirs) = ([0; 700], [0; 700]);
            let mut stuffed = Stuffed::new(&mut ours).unwrap();
            content.iter().for_each(|&byte| stuffed.try_push(byte).unwrap());
            let frame = stuffed.finalize().unwrap();
            let length = cobs::encode(&content, &mut theirs);
            // The crate writes one more code behind a run that ends full; both are read alike.
            let (last, body) = frame.split_last().unwrap();
            assert_eq!(*last, 0);
            assert!(body == &theirs[..length] || body == [&theirs[..length], &[1]].concat(), "{content:?}");
            for frame in [body, &theirs[..length]] {
                let mut frame = frame.to_vec();
                let length = unstuff(&mut frame).unwrap();
                assert_eq!(frame[..length], content);
            }
        }
    }

    #[test]
    fn a_buffer_that_is_too_short_is_an_error_at_every_length() {
        for content in contents().filter(|content| content.len() < 300 && content.len() % 9 == 0) {
            let whole = content.len() + 1 + content.len().div_ceil(254).max(1);
            for room in 0..whole {
                let mut buffer = std::vec![0; room];
                let sent = Stuffed::new(&mut buffer).and_then(|mut stuffed| {
                    content.iter().try_for_each(|&byte| stuffed.try_push(byte))?;
                    stuffed.finalize()
                });
                assert!(sent.is_err() || room + 1 >= whole, "{} in {room}", content.len());
            }
        }
    }

    #[test]
    fn a_frame_that_is_cut_short_is_refused() {
        assert_eq!(unstuff(&mut []), None);
        assert_eq!(unstuff(&mut [5, 1, 2, 3]), None);
        assert_eq!(unstuff(&mut [255, 1]), None);
        assert_eq!(unstuff(&mut [1]), Some(0));
    }
}
