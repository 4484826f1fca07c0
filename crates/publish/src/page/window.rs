//! A fixed window of time in buckets: least, greatest and mean of each channel in each of them, so
//! that a picture of an hour at 1 kHz costs as much as one of ten seconds, and hides no extreme.

use std::collections::VecDeque;

/// Buckets of a window: about as many as a chart has pixels.
pub const BUCKETS: u32 = 600;

/// One stretch of time.
#[derive(Debug, Clone, PartialEq)]
pub struct Bucket {
    /// Number of the stretch since time 0.
    pub id: i64,
    /// Its beginning, s.
    pub time_s: f64,
    channels: Vec<ChannelRange>,
}

/// Range of one channel in a bucket.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ChannelRange {
    low: f32,
    high: f32,
    sum: f64,
    count: u32,
}

impl ChannelRange {
    const NONE: Self = Self { low: f32::INFINITY, high: f32::NEG_INFINITY, sum: 0.0, count: 0 };

    fn add(&mut self, value: f32) {
        if value.is_finite() {
            self.low = self.low.min(value);
            self.high = self.high.max(value);
            self.sum += f64::from(value);
            self.count += 1;
        }
    }

    fn seen(&self, number: f32) -> f32 {
        if self.count == 0 { f32::NAN } else { number }
    }
}

impl Bucket {
    fn new(id: i64, bucket_s: f64, channels: usize) -> Self {
        Self { id, time_s: id as f64 * bucket_s, channels: vec![ChannelRange::NONE; channels] }
    }

    /// Least of each channel; NaN where there was nothing.
    pub fn low(&self) -> Vec<f32> {
        self.channels.iter().map(|span| span.seen(span.low)).collect()
    }

    /// Greatest of each channel.
    pub fn high(&self) -> Vec<f32> {
        self.channels.iter().map(|span| span.seen(span.high)).collect()
    }

    /// Mean of each channel.
    pub fn mean(&self) -> Vec<f32> {
        self.channels.iter().map(|span| span.seen((span.sum / f64::from(span.count)) as f32)).collect()
    }
}

/// The last so many seconds of all channels.
#[derive(Debug, Clone)]
pub struct DecimatedWindow {
    /// Its length, s.
    pub window_s: f64,
    /// Length of a bucket, s.
    pub bucket_s: f64,
    buckets: VecDeque<Bucket>,
}

impl DecimatedWindow {
    /// A window of this length, which is empty.
    pub fn new(window_s: f64) -> Self {
        Self { window_s, bucket_s: window_s / f64::from(BUCKETS), buckets: VecDeque::new() }
    }

    /// Adds a row, later than those before; after a gap, an empty bucket breaks the lines.
    pub fn push(&mut self, time_s: f64, values: &[f32], after_gap: bool) {
        // A time on the edge belongs to the bucket that begins there, however it was rounded.
        let id = (time_s / self.bucket_s + 1e-6).floor() as i64;
        let last = self.buckets.back().map(|bucket| bucket.id);
        if last.is_none_or(|last| id > last) {
            if let Some(last) = last.filter(|last| after_gap && id - 1 > *last) {
                self.buckets.push_back(Bucket::new(last + 1, self.bucket_s, values.len()));
            }
            self.buckets.push_back(Bucket::new(id, self.bucket_s, values.len()));
            while self.buckets.front().is_some_and(|first| first.id < id.saturating_sub(BUCKETS.into())) {
                self.buckets.pop_front();
            }
        }
        if let Some(bucket) = self.buckets.back_mut() {
            bucket.channels.iter_mut().zip(values).for_each(|(span, &value)| span.add(value));
        }
    }

    /// The buckets from this one on: the last may still grow.
    pub fn since(&self, id: i64) -> impl Iterator<Item = &Bucket> {
        let first = self.buckets.partition_point(|bucket| bucket.id < id);
        self.buckets.range(first..)
    }

    /// Forgets everything, as time starts anew.
    pub fn clear(&mut self) {
        self.buckets.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(rows: u32, period_s: f64, value: impl Fn(u32) -> f32) -> DecimatedWindow {
        let mut window = DecimatedWindow::new(60.0);
        for n in 0..rows {
            window.push(f64::from(n) * period_s, &[value(n)], false);
        }
        window
    }

    #[test]
    fn keeps_the_extremes_and_the_mean_of_every_bucket() {
        // A single sample of 60 000 stands out, and one that is no number leaves no trace.
        let window = filled(60_000, 0.001, |n| match n {
            12_345 => 9.0,
            40_000 => -9.0,
            50_000 => f32::NAN,
            _ => (n % 2) as f32,
        });
        let buckets: Vec<&Bucket> = window.since(0).collect();
        assert_eq!(buckets.len(), 600);
        assert_eq!((buckets[123].high()[0], buckets[400].low()[0]), (9.0, -9.0));
        assert!(buckets.iter().filter(|bucket| bucket.id != 123).all(|bucket| bucket.high() == [1.0]));
        assert_eq!(buckets[0].mean(), [0.5]);
        assert!((buckets[500].mean()[0] - 50.0 / 99.0).abs() < 1e-6);
    }

    #[test]
    fn an_hour_at_1_khz_is_no_larger_than_its_buckets() {
        let window = filled(3_600_000, 0.001, |n| n as f32);
        assert_eq!(window.since(0).count(), 601);
        assert_eq!(window.since(35_999).count(), 1);
    }

    #[test]
    fn rows_further_apart_than_buckets_are_no_gap_and_lost_ones_are() {
        let mut window = filled(3, 1.0, |n| n as f32);
        assert!(window.since(0).all(|bucket| bucket.mean()[0].is_finite()));
        window.push(9.0, &[1.0], true);
        let means: Vec<f32> = window.since(20).map(|bucket| bucket.mean()[0]).collect();
        assert!(means.len() == 3 && means[1].is_nan(), "{means:?}");
    }
}
