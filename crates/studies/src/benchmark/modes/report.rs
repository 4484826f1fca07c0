//! The page of the modes' figures.

use anemometry::head::Head;
use recording::text::short;

use crate::table::ResultTable;

use super::compared::{ModeFigures, WINDS_M_S};

/// Report of `studies benchmark modes`.
#[derive(Debug, Clone, PartialEq)]
pub struct ModesReport {
    /// Head by head.
    pub heads: Vec<HeadModes>,
}

/// The modes on one head.
#[derive(Debug, Clone, PartialEq)]
pub struct HeadModes {
    /// Name of the head.
    pub head: String,
    /// Elements over the gas, K.
    pub overheat_k: f64,
    /// With the numbers of its file.
    pub nominal: Vec<ModeFigures>,
    /// Over the ranges of its unknown numbers: least and greatest.
    pub ranges: Vec<[ModeFigures; 2]>,
    /// Number of others.
    pub draws: usize,
    /// Number of unknowns.
    pub unknown: usize,
}

/// A figure of a mode.
type ModeFigure = fn(&ModeFigures) -> f64;

/// The columns: what they are called, and where they stand.
const COLUMNS: [(&str, ModeFigure); 4] = [
    ("response (s)", |of| of.response_s),
    ("left after 10 x (%)", |of| of.creep_percent),
    ("gas +10 K (%)", |of| of.gas_percent),
    ("support +10 K (%)", |of| of.support_percent),
];

impl HeadModes {
    /// Specimens of one head, and of others within its ranges.
    pub fn new(head: &Head, overheat_k: f64, nominal: Vec<ModeFigures>, others: &[Vec<ModeFigures>]) -> Self {
        let range = |m: usize| {
            let all = || others.iter().map(|of| of[m]).chain([nominal[m]]);
            let end = |of: ModeFigure, pick: fn(f64, f64) -> f64| {
                all().map(|figures| of(&figures)).reduce(pick).unwrap_or(f64::NAN)
            };
            let ends = |pick: fn(f64, f64) -> f64| ModeFigures {
                mode: nominal[m].mode,
                response_s: end(|of| of.response_s, pick),
                creep_percent: end(|of| of.creep_percent, pick),
                gas_percent: end(|of| of.gas_percent, pick),
                support_percent: end(|of| of.support_percent, pick),
            };
            [ends(f64::min), ends(f64::max)]
        };
        Self {
            head: head.name.clone(),
            overheat_k,
            ranges: (0..nominal.len()).map(range).collect(),
            nominal,
            draws: others.len(),
            unknown: head.body.as_ref().map_or(0, |body| body.unknown.len()),
        }
    }

    /// The cells of a mode's row.
    fn row(&self, m: usize) -> Vec<String> {
        let [least, most] = &self.ranges[m];
        let cell = |of: ModeFigure| {
            let value = of(&self.nominal[m]);
            // A gas as warm as the elements takes nothing, which is no wind.
            if value.is_nan() {
                return "none".to_owned();
            }
            let value = short(value, 3);
            match self.draws {
                0 => value,
                _ => format!("{value} ({} … {})", short(of(least), 3), short(of(most), 3)),
            }
        };
        COLUMNS.iter().map(|(_, of)| cell(*of)).collect()
    }

    /// Part of the page.
    fn page(&self) -> String {
        let rows =
            (0..self.nominal.len()).map(|m| [vec![self.nominal[m].mode.name().to_owned()], self.row(m)].concat());
        let head = format!("mode | {}", COLUMNS.map(|(title, _)| title).join(" | "));
        let table = ResultTable::new(&head, rows).markdown();
        format!("\n## {}\n\n{} K over the gas; {}.\n\n{table}", self.head, self.overheat_k, self.basis())
    }

    fn basis(&self) -> String {
        match self.draws {
            0 => "no number of it is free".to_owned(),
            draws => format!("in brackets the range of {draws} draws of its {} unknown numbers", self.unknown),
        }
    }
}

impl ModesReport {
    /// The page of a day.
    pub fn page(&self, day: &str) -> String {
        let parts: String = self.heads.iter().map(HeadModes::page).collect();
        let [from, to] = WINDS_M_S;
        format!(
            "# Operating modes\n\nBy `cargo run --release -p studies -- benchmark modes`, {day}. Constant temperature (CTA, the \
             thermal sigma-delta loop), constant current (CCA) and constant power (CPA) at the same point of {from} m/s. Response: \
             until the sum of P/(T − T_gas) has made nine tenths of its change from {from} to {to} m/s. Left: of that change, ten \
             responses of CTA later. Gas, support: error of the speed where nobody knows that it is 10 K warmer.\n{parts}"
        )
    }
}
