//! Where to read in a buffer that a DMA stream fills in a circle.
//!
//! ```text
//! written up to = L − NDTR        NDTR counts from L down to 1 and starts anew at L
//! ```
//!
//! L is the buffer's length in bytes, NDTR the stream's register of transfers that remain (RM0090,
//! "DMA stream x number of data register").
//!
//! Limits: if more than L bytes come between two looks, the older ones are overwritten and nothing
//! here can tell; their frames' checksums do.

/// Reading and writing position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Circle {
    length: u16,
    read: u16,
    written: u16,
}

impl Circle {
    /// An empty circle of `length` bytes, the stream at its beginning.
    pub const fn new(length: u16) -> Self {
        Self { length, read: 0, written: 0 }
    }

    /// Takes over how far the stream has come.
    pub const fn look(&mut self, remaining: u16) {
        // 0 is there for a moment only, if at all, before the count starts anew.
        let written = self.length.saturating_sub(remaining);
        self.written = if written == self.length { 0 } else { written };
    }

    /// Index of the next byte to read, if one had come by the last look.
    pub const fn next(&mut self) -> Option<usize> {
        if self.read == self.written {
            return None;
        }
        let index = self.read as usize;
        self.read = if self.read + 1 == self.length { 0 } else { self.read + 1 };
        Some(index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bytes that are read when the stream goes on by these many at a time, as indices of a
    /// circle of 8.
    fn read(bursts: &[u16]) -> Vec<Vec<usize>> {
        let (mut circle, mut total) = (Circle::new(8), 0);
        bursts
            .iter()
            .map(|burst| {
                total += burst;
                circle.look(8 - total % 8);
                core::iter::from_fn(|| circle.next()).collect()
            })
            .collect()
    }

    #[test]
    fn every_byte_is_read_once_and_in_order_over_the_seam() {
        assert_eq!(read(&[3, 0, 4, 3]), [vec![0, 1, 2], vec![], vec![3, 4, 5, 6], vec![7, 0, 1]]);
    }

    #[test]
    fn a_seam_between_two_looks_is_no_stop() {
        assert_eq!(read(&[8 - 1, 1, 2]), [vec![0, 1, 2, 3, 4, 5, 6], vec![7], vec![0, 1]]);
    }

    #[test]
    fn a_count_of_zero_is_the_seam() {
        let mut circle = Circle::new(8);
        circle.look(1);
        while circle.next().is_some() {}
        circle.look(0);
        assert_eq!((circle.next(), circle.next()), (Some(7), None));
    }

    #[test]
    fn any_burst_shorter_than_the_circle_is_read_whole() {
        for burst in 1..8 {
            let indices: Vec<usize> = read(&[burst; 50]).concat();
            let expected: Vec<usize> = (0..50 * usize::from(burst)).map(|n| n % 8).collect();
            assert_eq!(indices, expected);
        }
    }
}
