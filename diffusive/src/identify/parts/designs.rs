//! What is summed of every part of a record: the designs that identification tries, with the
//! columns that residuals need besides, and with what later segments may begin with.
//!
//! | segment | designs |
//! |---|---|
//! | the first | as they are tried, opened |
//! | a later one | the same with the decays D (`identify::segment`); behind them one of all signals beside all decays that its own start, or a drift's filter of it, may have |

use std::ops::Range;

use crate::identify::design::{BankDrive, RegressionDesign, RelaxationBank, Role};
use crate::identify::segment::with_starts;

/// A record as sums see it.
#[derive(Debug, Clone, Default)]
pub struct RecordFrame {
    pub sample_period_s: f64,
    pub rows: u64,
    /// First row of every segment.
    pub segments: Vec<u64>,
    /// Rates of the decays D; none of a record of one segment.
    pub starts_rad_s: Vec<f64>,
    /// Subtracted from every output.
    pub output_shift: Vec<f64>,
    /// Gas temperature of the first row, °C.
    pub first_gas_c: Option<f64>,
}

/// A segment of a record, by its number and its first row.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct SegmentPlace {
    /// From 0.
    pub number: usize,
    pub first_row: u64,
}

/// What is summed of every part of a record.
pub struct SummedDesigns {
    /// As they are tried.
    pub tried: Vec<RegressionDesign>,
    /// Opened: of the first segment.
    pub opened: Vec<RegressionDesign>,
    later: Vec<RegressionDesign>,
    /// Every signal as a column.
    pub signals: RegressionDesign,
    /// Rows at the beginning of a segment that say nothing.
    pub lead: u64,
    pub record: RecordFrame,
}

impl SummedDesigns {
    /// `tried` have the same banks, but for rates.
    pub fn of(tried: Vec<RegressionDesign>, record: RecordFrame) -> Self {
        let driven = tried[0].banks.iter().filter(|bank| !is_of_output(bank));
        let signal =
            |bank: &RelaxationBank| RelaxationBank { rates_rad_s: Vec::new(), feed_through: true, ..bank.clone() };
        let signals = RegressionDesign {
            banks: driven.map(signal).collect(),
            initial_rad_s: Vec::new(),
            outputs: tried[0].outputs,
        };
        let opened: Vec<RegressionDesign> = tried.iter().map(opened).collect();
        let mut poles: Vec<f64> = tried.iter().flat_map(poles).collect();
        poles.sort_by(f64::total_cmp);
        poles.dedup();
        let beside = with_starts(&signals, &[&record.starts_rad_s[..], &poles].concat());
        let later = opened.iter().map(|opened| with_starts(opened, &record.starts_rad_s)).chain([beside]);
        Self { later: later.collect(), opened, lead: signals.longest_delay() as u64, signals, tried, record }
    }

    /// What is summed of a segment.
    pub fn of_segment(&self, number: usize) -> &[RegressionDesign] {
        if number == 0 { &self.opened } else { &self.later }
    }

    /// All signals of a later segment, and all decays that its start may have.
    pub fn beside(&self) -> &RegressionDesign {
        &self.later[self.opened.len()]
    }

    /// A design as it is tried, in a segment.
    pub fn tried_in(&self, at: usize, number: usize) -> RegressionDesign {
        with_starts(&self.tried[at], self.starts_in(number))
    }

    /// Rates of the decays D that a segment may begin with.
    pub fn starts_in(&self, number: usize) -> &[f64] {
        if number == 0 { &[] } else { &self.record.starts_rad_s }
    }

    /// The segment of a row.
    pub fn segment_at(&self, row: u64) -> SegmentPlace {
        let segments = &self.record.segments;
        let number = segments.partition_point(|first_row| *first_row <= row).saturating_sub(1);
        SegmentPlace { number, first_row: segments.get(number).copied().unwrap_or(0) }
    }

    /// Its rows.
    pub fn rows_of(&self, segment: SegmentPlace) -> Range<u64> {
        let next = self.record.segments.get(segment.number + 1).copied();
        segment.first_row..next.unwrap_or(self.record.rows)
    }

    /// How many signals there are.
    pub fn signal_count(&self) -> usize {
        self.signals.width() - 1
    }
}

fn is_of_output(bank: &RelaxationBank) -> bool {
    matches!(bank.drive, BankDrive::Output(_))
}

/// Rates of the means that filters are made from.
fn poles(design: &RegressionDesign) -> Vec<f64> {
    design.banks.iter().filter(|bank| is_of_output(bank)).flat_map(|bank| bank.rates_rad_s.clone()).collect()
}

/// A design in which the drive of every bank is a column as well, unless an output drives it:
/// without these, nothing is known of residuals (`left`).
fn opened(design: &RegressionDesign) -> RegressionDesign {
    let mut opened = design.clone();
    for bank in &mut opened.banks {
        bank.feed_through |= !is_of_output(bank);
    }
    opened
}

/// Where an opened design has the columns of the one that it was made of.
pub fn columns_of(design: &RegressionDesign, opened: &RegressionDesign) -> Vec<usize> {
    let roles = opened.roles();
    let place = |role: &Role| roles.iter().position(|own| own == role).unwrap_or_default();
    design.roles().iter().map(place).chain(roles.len()..opened.width()).collect()
}
