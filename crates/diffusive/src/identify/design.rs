//! Which columns the regression has: relaxations of driven banks, what the record began with, an
//! offset, and the outputs.
//!
//! One row of the matrix, for outputs y at t_n (theory 2 and 3; normalised states x_k, so that all
//! columns have like scales):
//!
//! ```text
//! x_k of bank 1 … | u of bank 1, if it feeds through | x_k of bank 2 …
//!     | e^(−ξ_k (t_n − t_0)) … | 1 | y_1 …
//! ```
//!
//! A bank is driven by an input, by an input gated to one event class (thesis 2.19), or, for wind
//! as feedback (theory 12), by an output gated to a class, by the gate alone, or by the gas; or by
//! an output, for what a drift makes of its past.

/// Where a row takes its gas temperature from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GasSource {
    /// The same all through, °C; 0 where nothing needs one.
    Constant(f64),
    /// The record's gas column.
    Column,
}

/// What drives a bank.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BankDrive {
    /// An input in every interval.
    Input(usize),
    /// An input in the intervals of one class, nothing in the others.
    Gated { input: usize, class: usize },
    /// Output minus gas temperature (0 if it is unknown) in the intervals of one class.
    Loss { output: usize, class: usize },
    /// 1 in the intervals of one class.
    Gate { class: usize },
    /// Gas temperature minus that of the first row.
    Gas,
    /// An output: its means over the past, from which filters are made.
    Output(usize),
}

#[derive(Debug, Clone, PartialEq)]
pub struct RelaxationBank {
    pub drive: BankDrive,
    /// Ascending rates.
    pub rates_rad_s: Vec<f64>,
    /// Whole samples by which the drive comes late.
    pub delay: usize,
    /// Whether the drive itself is a column too.
    pub feed_through: bool,
}

#[derive(Debug, Clone, PartialEq)]
pub struct RegressionDesign {
    pub banks: Vec<RelaxationBank>,
    /// Rates of the decays that the record may have begun with.
    pub initial_rad_s: Vec<f64>,
    pub outputs: usize,
    /// Nothing drove the banks before the record; else its first drives were held before.
    pub from_rest: bool,
}

/// What a column means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Role {
    Relaxation {
        bank: usize,
        k: usize,
        rate_rad_s: f64,
    },
    FeedThrough {
        bank: usize,
    },
    Initial {
        rate_rad_s: f64,
    },
    Offset,
    /// What a drift begins with, and its prior's precision in units of the noise's; it has no
    /// column of its own.
    DriftStart {
        precision: f64,
    },
}

impl Role {
    /// The bank whose resistance it weighs.
    pub fn bank(self) -> Option<usize> {
        match self {
            Self::Relaxation { bank, .. } | Self::FeedThrough { bank } => Some(bank),
            Self::Initial { .. } | Self::Offset | Self::DriftStart { .. } => None,
        }
    }
}

impl RegressionDesign {
    /// The roles of the columns that explain, in order. The outputs stand behind them.
    pub fn roles(&self) -> Vec<Role> {
        let mut roles = Vec::new();
        for (index, bank) in self.banks.iter().enumerate() {
            let relaxations = bank.rates_rad_s.iter().enumerate();
            roles.extend(relaxations.map(|(k, &rate_rad_s)| Role::Relaxation { bank: index, k, rate_rad_s }));
            roles.extend(bank.feed_through.then_some(Role::FeedThrough { bank: index }));
        }
        roles.extend(self.initial_rad_s.iter().map(|&rate_rad_s| Role::Initial { rate_rad_s }));
        roles.push(Role::Offset);
        roles
    }

    /// Columns of the matrix, outputs included.
    pub fn width(&self) -> usize {
        let banks: usize = self.banks.iter().map(|bank| bank.rates_rad_s.len() + usize::from(bank.feed_through)).sum();
        banks + self.initial_rad_s.len() + 1 + self.outputs
    }

    /// The columns of initial decays.
    pub fn decays(&self) -> std::ops::Range<usize> {
        let end = self.width() - self.outputs - 1;
        end - self.initial_rad_s.len()..end
    }

    /// What states of the columns amount to with these weights, one decay a rate: rate in rad/s and
    /// K.
    pub fn decays_of(&self, states: &[f64], weights: &[f64]) -> Vec<(f64, f64)> {
        let mut decays: Vec<(f64, f64)> = Vec::new();
        for ((role, state), weight) in self.roles().iter().zip(states).zip(weights) {
            let (Role::Relaxation { rate_rad_s, .. } | Role::Initial { rate_rad_s }) = *role else { continue };
            match decays.iter_mut().find(|(rate, _)| *rate == rate_rad_s) {
                Some((_, sum)) => *sum += state * weight,
                None => decays.push((rate_rad_s, state * weight)),
            }
        }
        decays
    }

    pub fn longest_delay(&self) -> usize {
        self.banks.iter().map(|bank| bank.delay).max().unwrap_or(0)
    }
}
