//! Fits of all parts, and how far a user could have known them.

use std::fmt::{self, Display, Formatter};

use serde::Serialize;

use crate::table::ResultTable;

use super::part::MeasuredPart;

/// Fit below which a prediction is of no use, %.
const POOR_PERCENT: f64 = 50.0;
/// Fit above which it is a good one, %.
const GOOD_PERCENT: f64 = 85.0;
/// An error that was said is right within this factor.
const RIGHT: f64 = 2.0;

/// What was predicted, part by part.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeasuredReport {
    /// Table by table, share by share.
    pub parts: Vec<MeasuredPart>,
}

/// So many of so many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Count {
    /// Those for which it is true.
    pub own: usize,
    /// Of all.
    pub all: usize,
}

impl MeasuredReport {
    /// Mean fit, %; what was refused counts as 0.
    pub fn mean_fit_percent(&self) -> f64 {
        self.parts.iter().map(|part| part.fit_percent).sum::<f64>() / self.parts.len().max(1) as f64
    }

    /// Median of the error that was said over the one that came.
    pub fn median_ratio(&self) -> f64 {
        let mut ratios = self.ratios();
        ratios.sort_by(f64::total_cmp);
        ratios.get(ratios.len() / 2).copied().unwrap_or(f64::NAN)
    }

    /// Errors that were said within a factor of two.
    pub fn said_right(&self) -> Count {
        let ratios = self.ratios();
        Count { own: ratios.iter().filter(|ratio| (1.0 / RIGHT..=RIGHT).contains(*ratio)).count(), all: ratios.len() }
    }

    /// Poor predictions that were warned of.
    pub fn warned_of_poor(&self) -> Count {
        self.warned(&|part| part.fit_percent < POOR_PERCENT)
    }

    /// Good predictions that were warned of.
    pub fn warned_of_good(&self) -> Count {
        self.warned(&|part| part.fit_percent > GOOD_PERCENT)
    }

    fn ratios(&self) -> Vec<f64> {
        self.parts.iter().filter_map(MeasuredPart::ratio).collect()
    }

    fn warned(&self, is_of: &dyn Fn(&MeasuredPart) -> bool) -> Count {
        let of = || self.parts.iter().filter(|part| is_of(part));
        Count { own: of().filter(|part| part.is_warned()).count(), all: of().count() }
    }

    /// As a page of the book. `day` is when it was measured.
    pub fn page(&self, day: &str) -> String {
        format!(
            "# Measured records, predicted\n\n\
             Records of other people's rigs, which are no part of the project: the first 40, 50 and 60 % of their rows are \
             identified without options, the rest is predicted and nothing of its output is used. Measured on {day} by\n\n\
             ```\ncargo run --release -p studies -- benchmark measured --tables FOLDER\n```\n\n{self}"
        )
    }
}

impl Display for Count {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {}", self.own, self.all)
    }
}

impl Display for MeasuredReport {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let row = |of: &[MeasuredPart]| {
            let listed = |text: &dyn Fn(&MeasuredPart) -> String| of.iter().map(text).collect::<Vec<_>>().join(", ");
            let fits = listed(&|part| format!("{:.1}", part.fit_percent));
            let ratios = listed(&|part| part.ratio().map_or("–".to_owned(), |ratio| format!("{ratio:.2}")));
            let warned = listed(&|part| {
                match (part.refused.is_some(), part.is_warned()) {
                    (true, _) => "refused",
                    (false, true) => "yes",
                    (false, false) => "no",
                }
                .to_owned()
            });
            vec![of[0].table.clone(), fits, ratios, warned]
        };
        let rows = self.parts.chunk_by(|one, next| one.table == next.table).map(row);
        let head = "record | fit of the rest, % | error said / error come | warned";
        writeln!(f, "{}", ResultTable::new(head, rows).markdown())?;
        writeln!(f, "- mean fit {:.1} %; what is refused counts as 0", self.mean_fit_percent())?;
        writeln!(
            f,
            "- error said over error come: {:.2} in the median, within a factor of {RIGHT} in {}",
            self.median_ratio(),
            self.said_right()
        )?;
        writeln!(f, "- warned of fits below {POOR_PERCENT} %: {}", self.warned_of_poor())?;
        writeln!(f, "- warned of fits above {GOOD_PERCENT} %: {}", self.warned_of_good())
    }
}
