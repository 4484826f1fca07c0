//! Bytes that come over a link, from either side.
//!
//! The first byte says what the others are: odd, a stream as it comes; even, the message of one
//! frame, which is framed here without the code under test. With a checksum before it a fuzzer
//! would never get to see a message.

use crate::{cobs_of, crc_of};
use serde::{Serialize, de::DeserializeOwned};
use wire::frame::decode;
use wire::{FromBoard, MAX_FRAME, Receiver, ToBoard, VERSION, encode};

/// The target.
///
/// # Panics
/// If something does not hold.
pub fn run(bytes: &[u8]) -> bool {
    match bytes.split_first() {
        None => false,
        Some((mode, stream)) if mode % 2 == 1 => {
            let to_board = received::<ToBoard>(stream);
            received::<FromBoard>(stream) || to_board
        }
        Some((_, message)) => {
            let to_board = framed::<ToBoard>(message);
            framed::<FromBoard>(message) || to_board
        }
    }
}

fn received<T: Serialize + DeserializeOwned>(stream: &[u8]) -> bool {
    let mut receiver = Receiver::new();
    for &byte in stream {
        if let Some(received) = receiver.push::<T>(byte) {
            comes_out_again(received.sequence, &received.message);
        }
    }
    // Behind the last zero is a frame that has not ended.
    let mut frames: Vec<&[u8]> = stream.split(|&byte| byte == 0).collect();
    let unfinished = frames.pop().map_or(0, <[u8]>::len);
    let oversized = frames.iter().filter(|frame| frame.len() > MAX_FRAME).count();
    let counters = receiver.counters();
    let taken = counters.messages;
    assert_eq!(counters.oversized as usize, oversized);
    let frames = frames.iter().filter(|frame| !frame.is_empty()).count();
    assert_eq!((taken + counters.damaged + counters.oversized + counters.foreign) as usize, frames, "{counters:?}");

    // It finds its place again.
    let mut buffer = [0; MAX_FRAME];
    let hello = encode(7, &ToBoard::Hello, &mut buffer).expect("a frame has room for it");
    let end = usize::from(unfinished > 0);
    let heard = [0_u8; 1][..end].iter().chain(hello).filter_map(|&byte| receiver.push::<ToBoard>(byte)).last();
    assert_eq!(heard.map(|heard| heard.message), Some(ToBoard::Hello));
    taken > 0
}

fn framed<T: Serialize + DeserializeOwned>(message: &[u8]) -> bool {
    let sequence = 0x0102_u16;
    let mut content = vec![VERSION];
    content.extend(sequence.to_le_bytes());
    content.extend(message);
    content.extend(crc_of(&content).to_le_bytes());
    let frame = cobs_of(&content);
    let mut receiver = Receiver::new();
    let received = frame.iter().filter_map(|&byte| receiver.push::<T>(byte)).last();
    let counters = receiver.counters();
    match received {
        Some(received) => {
            assert_eq!((received.sequence, received.repeated, counters.messages), (sequence, false, 1));
            // Lengths and tags may be written with more bytes than they need, and come out with
            // fewer.
            assert!(comes_out_again(sequence, &received.message).len() <= frame.len());
            true
        }
        None => {
            let is_long = frame.len() - 1 > MAX_FRAME;
            assert_eq!((counters.messages, counters.oversized), (0, u32::from(is_long)));
            assert_eq!(counters.damaged, u32::from(!is_long));
            false
        }
    }
}

/// Whatever was received fits into a frame, and that frame means the same: its bytes do, since a
/// number may be none.
fn comes_out_again<T: Serialize + DeserializeOwned>(sequence: u16, message: &T) -> Vec<u8> {
    let (mut once, mut twice) = ([0; MAX_FRAME], [0; MAX_FRAME]);
    let frame = encode(sequence, message, &mut once).expect("no message is longer than a frame").to_vec();
    let mut body = frame[..frame.len() - 1].to_vec();
    let (again, message) = decode::<T>(&mut body).expect("what was encoded can be decoded");
    assert_eq!(again, sequence);
    assert_eq!(encode(sequence, &message, &mut twice).expect("as long as before"), frame);
    frame
}
