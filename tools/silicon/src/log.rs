//! The firmware's log, read as a probe reads it: from a ring in RAM (SEGGER RTT), decoded by defmt.

use crate::image::FlashImage;
use crate::processor::bus::ProcessorBus;
use crate::processor::{Processor, ProcessorError};
use defmt_decoder::{DecodeError, Table};

/// The first channel to the host, behind 16 bytes of name and two counts.
const CHANNEL: u32 = 24;

/// Bytes of the log so far.
#[derive(Clone, Debug, Default)]
pub struct RttLog(Vec<u8>);

impl RttLog {
    /// Takes what the firmware has written since the last time.
    ///
    /// # Errors
    /// If Unicorn fails.
    pub fn collect<B: ProcessorBus>(
        &mut self,
        image: &FlashImage,
        core: &mut Processor<B>,
    ) -> Result<(), ProcessorError> {
        let mut words = [0; 24];
        core.read_memory(image.rtt + CHANNEL, &mut words)?;
        let word = |i: usize| u32::from_le_bytes([words[i], words[i + 1], words[i + 2], words[i + 3]]);
        let (buffer, size, write, read) = (word(4), word(8), word(12), word(16));
        // Before the firmware has begun, anything stands there.
        if size == 0 || size > 0x1_0000 || write >= size || read >= size || write == read {
            return Ok(());
        }
        let mut ring = vec![0; size as usize];
        if core.read_memory(buffer, &mut ring).is_err() {
            return Ok(());
        }
        let (write_index, read_index) = (write as usize, read as usize);
        if read_index < write_index {
            self.0.extend_from_slice(&ring[read_index..write_index]);
        } else {
            self.0.extend_from_slice(&ring[read_index..]);
            self.0.extend_from_slice(&ring[..write_index]);
        }
        core.write_memory(image.rtt + CHANNEL + 16, &write.to_le_bytes())
    }

    /// The lines of the log; one line says so if it cannot be read.
    pub fn lines(&self, image: &FlashImage) -> Vec<String> {
        let Ok(Some(table)) = Table::parse(&image.elf) else {
            return vec!["(the image has no table for its log)".to_owned()];
        };
        let mut decoder = table.new_stream_decoder();
        decoder.received(&self.0);
        let mut lines = Vec::new();
        loop {
            match decoder.decode() {
                Ok(frame) => lines.push(frame.display(false).to_string()),
                Err(DecodeError::Malformed) if table.encoding().can_recover() => {}
                Err(_) => return lines,
            }
        }
    }
}
