//! What self-tests have found, as tables and as JSON.

use std::fmt::Write as _;

use dr_core::control::guard::Cause;
use dr_core::control::{Finding, SelfTestPlan};
use serde_json::{Value, json};
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;
use wire::settings::TestRecord;

/// A self-test that is over.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Who was tested.
    pub firmware: String,
    pub plan: SelfTestPlan,
    /// One entry an element.
    pub findings: Vec<Finding>,
}

impl Report {
    /// Whether nothing is wrong.
    pub fn is_well(&self) -> bool {
        self.findings.iter().all(|finding| finding.faults.is_none())
    }

    /// What is wrong in one clause; nothing if all is well.
    pub fn faults(&self, names: &[String]) -> Option<String> {
        let wrong = self.findings.iter().filter(|finding| !finding.faults.is_none());
        let each: Vec<String> =
            wrong.map(|finding| format!("{}: {}", name(names, finding), verdict(finding))).collect();
        (!each.is_empty()).then(|| format!("{} of {} elements: {}", each.len(), self.findings.len(), each.join("; ")))
    }

    /// For people.
    pub fn table(&self, names: &[String]) -> String {
        let heat = match self.plan.pulse_s {
            Some(pulse_s) => format!("each element heated for {pulse_s} s"),
            None => "nothing heated".to_owned(),
        };
        let when = self.plan.unix_s.map_or_else(String::new, |unix_s| format!(", {}", date(unix_s)));
        let rows = self.findings.iter().map(|finding| row(name(names, finding), finding));
        let verdict = self.faults(names).unwrap_or_else(|| "all is well".to_owned());
        format!("{}{when}: {heat}\n\n{}\n{verdict}\n", self.firmware, table(&HEADER, rows))
    }

    /// For programs.
    pub fn json(&self, names: &[String]) -> Value {
        let findings = self.findings.iter().map(|finding| of_finding(name(names, finding), finding));
        json!({
            "firmware": self.firmware,
            "date": self.plan.unix_s.map(date),
            "pulse_s": self.plan.pulse_s,
            "well": self.is_well(),
            "elements": findings.collect::<Vec<_>>(),
        })
    }
}

/// The tests that a board remembers, for people.
pub fn stored_table(records: &[TestRecord], names: &[String]) -> String {
    let rows = records.iter().map(|record| {
        let mut row = row(name(names, &record.finding), &record.finding);
        row.extend([
            record.unix_s.map_or_else(|| format!("at start {}", record.starts), date),
            record.firmware.to_string(),
        ]);
        row
    });
    let header: Vec<&str> = HEADER.iter().copied().chain(["when", "firmware"]).collect();
    table(&header, rows)
}

/// The same for programs.
pub fn stored_json(records: &[TestRecord], names: &[String]) -> Value {
    let each = records.iter().map(|record| {
        let mut value = of_finding(name(names, &record.finding), &record.finding);
        value["date"] = record.unix_s.map(date).into();
        value["starts"] = record.starts.into();
        value["firmware"] = record.firmware.as_str().into();
        value
    });
    Value::Array(each.collect())
}

const HEADER: [&str; 10] = [
    "element",
    "verdict",
    "offset",
    "reference",
    "temperature",
    "noise",
    "rise",
    "expected",
    "response",
    "levels apart",
];

fn row(name: String, finding: &Finding) -> Vec<String> {
    let none = || "–".to_owned();
    let of = |value: Option<f32>, write: fn(f32) -> String| value.map_or_else(none, write);
    let response = finding.response;
    vec![
        name,
        verdict(finding),
        of(finding.offset_v, |volt| format!("{:.2} µV", 1e6 * volt)),
        of(finding.reference, |ratio| format!("{ratio:.4}")),
        of(finding.temperature_c, |celsius| format!("{celsius:.2} °C")),
        of(finding.noise_k, |kelvin| format!("{:.2} mK", 1e3 * kelvin)),
        of(response.map(|response| response.rise_k), |kelvin| format!("{kelvin:.3} K")),
        of(response.and_then(|response| response.expected_k), |kelvin| format!("{kelvin:.3} K")),
        of(response.and_then(|response| response.ratio), |ratio| format!("{ratio:.3}")),
        of(response.and_then(|response| response.gap_k), |kelvin| format!("{kelvin:.3} K")),
    ]
}

fn of_finding(name: String, finding: &Finding) -> Value {
    let faults: Vec<&str> = finding.faults.iter().map(dr_core::control::Fault::name).collect();
    let response = finding.response.map(|response| {
        json!({
            "rise_k": response.rise_k,
            "expected_k": response.expected_k,
            "ratio": response.ratio,
            "gap_k": response.gap_k,
        })
    });
    json!({
        "element": name,
        "faults": faults,
        "cause": finding.cause.map(Cause::name),
        "offset_v": finding.offset_v,
        "reference": finding.reference,
        "temperature_c": finding.temperature_c,
        "noise_k": finding.noise_k,
        "response": response,
    })
}

/// What is wrong with an element, or that it is well.
pub fn verdict(finding: &Finding) -> String {
    match (finding.faults.is_none(), finding.cause) {
        (true, _) => "well".to_owned(),
        (false, Some(cause)) => format!("{} ({})", finding.faults, cause.name()),
        (false, None) => finding.faults.to_string(),
    }
}

fn name(names: &[String], finding: &Finding) -> String {
    names.get(usize::from(finding.element)).cloned().unwrap_or_else(|| format!("element {}", finding.element))
}

/// A date in words of RFC 3339.
pub fn date(unix_s: u32) -> String {
    let time = OffsetDateTime::from_unix_timestamp(unix_s.into()).unwrap_or(OffsetDateTime::UNIX_EPOCH);
    time.format(&Rfc3339).unwrap_or_else(|_| unix_s.to_string())
}

/// Columns as wide as what stands in them: the first two to the left, the others to the right.
fn table(header: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut lines = vec![header.iter().map(|&title| title.to_owned()).collect::<Vec<String>>()];
    lines.extend(rows);
    let width = |column: usize| {
        lines.iter().filter_map(|line| line.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..header.len()).map(width).collect();
    let mut text = String::new();
    for line in &lines {
        let mut row = String::new();
        for (i, (cell, &width)) in line.iter().zip(&widths).enumerate() {
            let _ = if i < 2 { write!(row, "{cell:<width$}  ") } else { write!(row, "{cell:>width$}  ") };
        }
        let _ = writeln!(text, "{}", row.trim_end());
    }
    text
}
