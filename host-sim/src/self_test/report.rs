//! What self-tests have found, as tables and as JSON.

use dr_core::control::guard::Cause;
use dr_core::control::{Finding, SelfTestPlan};
use serde_json::{Value, json};
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;
use wire::settings::TestRecord;

use crate::table::columns;

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
    /// What is wrong in one clause; nothing if all is well.
    pub fn faults(&self) -> Option<String> {
        faults(self.findings.iter())
    }

    /// For people.
    pub fn table(&self, names: &[String]) -> String {
        let heat = match self.plan.pulse_s.filter(|_| self.findings.iter().any(|finding| finding.response.is_some())) {
            Some(pulse_s) => format!("each element heated for {pulse_s} s"),
            None => "nothing heated".to_owned(),
        };
        let when = self.plan.unix_s.map_or_else(String::new, |unix_s| format!(", {}", date(unix_s)));
        format!("{}{when}: {heat}\n\n{}", self.firmware, table(names, self.findings.iter()))
    }

    /// For programs.
    pub fn json(&self, names: &[String]) -> Value {
        let findings = self.findings.iter().map(|finding| of_finding(name(names, finding), finding));
        json!({
            "firmware": self.firmware,
            "date": self.plan.unix_s.map(date),
            "pulse_s": self.plan.pulse_s,
            "well": self.faults().is_none(),
            "elements": findings.collect::<Vec<_>>(),
        })
    }
}

/// What is wrong with some elements in one clause; nothing if all is well.
pub fn faults<'a>(findings: impl ExactSizeIterator<Item = &'a Finding>) -> Option<String> {
    let all = findings.len();
    let wrong = findings.filter(|finding| !finding.faults.is_none()).count();
    (wrong > 0).then(|| format!("faults in {wrong} of {all} elements"))
}

/// The tests that a board remembers, for people: those of one test together.
pub fn stored_table(records: &[TestRecord], names: &[String]) -> String {
    let tests = records.chunk_by(same_test).map(|test| {
        let heading = test.first().map_or_else(String::new, |record| format!("{}, {}", record.firmware, when(record)));
        format!("{heading}\n\n{}", table(names, test.iter().map(|record| &record.finding)))
    });
    tests.collect::<Vec<_>>().join("\n")
}

/// The same for programs.
pub fn stored_json(records: &[TestRecord], names: &[String]) -> Value {
    let tests = records.chunk_by(same_test).map(|test| {
        let elements = test.iter().map(|record| of_finding(name(names, &record.finding), &record.finding));
        let first = test.first();
        json!({
            "firmware": first.map(|record| record.firmware.as_str()),
            "date": first.and_then(|record| record.unix_s).map(date),
            "starts": first.map(|record| record.starts),
            "well": faults(test.iter().map(|record| &record.finding)).is_none(),
            "elements": elements.collect::<Vec<_>>(),
        })
    });
    json!({ "tests": tests.collect::<Vec<_>>() })
}

fn same_test(a: &TestRecord, b: &TestRecord) -> bool {
    (a.unix_s, a.starts, &a.firmware) == (b.unix_s, b.starts, &b.firmware)
}

/// When a board was tested, as far as it knows.
pub fn when(record: &TestRecord) -> String {
    record.unix_s.map_or_else(|| format!("at start {} since its supply came up", record.starts), date)
}

const HEADER: [&str; 10] =
    ["element", "verdict", "offset", "reference", "at rest", "noise", "rise", "expected", "response", "levels"];

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

/// An element a line. The last line says whether all is well.
fn table<'a>(names: &[String], findings: impl ExactSizeIterator<Item = &'a Finding> + Clone) -> String {
    let mut lines = vec![HEADER.map(str::to_owned).to_vec()];
    lines.extend(findings.clone().map(|finding| row(name(names, finding), finding)));
    // Two words, the rest are numbers.
    let right: Vec<usize> = (2..HEADER.len()).collect();
    let verdict = faults(findings).unwrap_or_else(|| "all is well".to_owned());
    format!("{}\n{verdict}\n", columns(&lines, &right))
}
