//! Results of self-tests: one that is just over, and those that a board has kept. Each is a table
//! for people, and JSON.

use std::fmt;

use dr_core::control::guard::Cause;
use dr_core::control::self_test::PulseResponse;
use dr_core::control::{SelfTestFinding, SelfTestPlan};
use serde::{Serialize, Serializer};
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;
use wire::settings::TestRecord;

use recording::text::columns;

/// A self-test that is over.
#[derive(Debug, Clone, PartialEq)]
pub struct SelfTestReport {
    /// Name and version of the firmware that was tested.
    pub firmware: String,
    /// The pulse, and the date.
    pub plan: SelfTestPlan,
    /// One entry an element.
    pub findings: Vec<SelfTestFinding>,
    /// Names of the elements, as far as they are known.
    pub names: Vec<String>,
}

impl SelfTestReport {
    /// Faults in one clause; nothing if the test has passed.
    pub fn faults(&self) -> Option<String> {
        faults(&self.findings)
    }
}

impl fmt::Display for SelfTestReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let heat = match self.plan.pulse_s.filter(|_| self.findings.iter().any(|finding| finding.response.is_some())) {
            Some(pulse_s) => format!("each element heated for {pulse_s} s"),
            None => "nothing heated".to_owned(),
        };
        let when = self.plan.unix_s.map_or_else(String::new, |unix_s| format!(", {}", date(unix_s)));
        write!(f, "{}{when}: {heat}\n\n{}", self.firmware, table(&self.names, &self.findings))
    }
}

impl Serialize for SelfTestReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let json = TestJson {
            firmware: &self.firmware,
            date: self.plan.unix_s.map(date),
            pulse_s: Some(self.plan.pulse_s),
            starts: None,
            pass: self.faults().is_none(),
            elements: self.findings.iter().map(|finding| FindingJson::of(&self.names, finding)).collect(),
        };
        json.serialize(serializer)
    }
}

/// A self-test as JSON has it.
#[derive(Serialize)]
struct TestJson<'a> {
    firmware: &'a str,
    date: Option<String>,
    /// Pulse of one that is just over.
    #[serde(skip_serializing_if = "Option::is_none")]
    pulse_s: Option<Option<f32>>,
    /// Start of one that a board has kept.
    #[serde(skip_serializing_if = "Option::is_none")]
    starts: Option<u32>,
    #[serde(rename = "well")]
    pass: bool,
    elements: Vec<FindingJson>,
}

/// The self-tests that a board has kept.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredSelfTests {
    /// The last that a host requested, and the last after a start.
    pub tests: Vec<TestRecord>,
    /// Names of the elements, as far as they are known.
    pub names: Vec<String>,
}

impl StoredSelfTests {
    /// Faults in one clause; nothing if all tests have passed.
    pub fn faults(&self) -> Option<String> {
        let all: Vec<SelfTestFinding> = self.tests.iter().flat_map(|test| &test.findings).copied().collect();
        faults(&all)
    }
}

impl fmt::Display for StoredSelfTests {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, test) in self.tests.iter().enumerate() {
            let gap = if place > 0 { "\n" } else { "" };
            let at_start = || format!("at start {} since its supply came up", test.starts);
            write!(f, "{gap}{}, {}\n\n", test.firmware, test.unix_s.map_or_else(at_start, date))?;
            write!(f, "{}", table(&self.names, &test.findings))?;
        }
        Ok(())
    }
}

impl Serialize for StoredSelfTests {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct StoredJson<'a> {
            tests: Vec<TestJson<'a>>,
        }
        let tests = self.tests.iter().map(|test| TestJson {
            firmware: &test.firmware,
            date: test.unix_s.map(date),
            pulse_s: None,
            starts: Some(test.starts),
            pass: faults(&test.findings).is_none(),
            elements: test.findings.iter().map(|finding| FindingJson::of(&self.names, finding)).collect(),
        });
        StoredJson { tests: tests.collect() }.serialize(serializer)
    }
}

/// One element's finding as JSON has it.
#[derive(Serialize)]
struct FindingJson {
    element: String,
    faults: Vec<&'static str>,
    cause: Option<&'static str>,
    offset_v: Option<f32>,
    reference: Option<f32>,
    temperature_c: Option<f32>,
    noise_k: Option<f32>,
    response: Option<PulseResponse>,
}

impl FindingJson {
    fn of(names: &[String], finding: &SelfTestFinding) -> Self {
        Self {
            element: name(names, finding),
            faults: finding.faults.iter().map(dr_core::control::SelfTestFault::name).collect(),
            cause: finding.cause.map(Cause::name),
            offset_v: finding.offset_v,
            reference: finding.reference,
            temperature_c: finding.temperature_c,
            noise_k: finding.noise_k,
            response: finding.response,
        }
    }
}

/// Faults of some elements in one clause; nothing if all have passed.
fn faults(findings: &[SelfTestFinding]) -> Option<String> {
    let all = findings.len();
    let wrong = findings.iter().filter(|finding| !finding.faults.is_none()).count();
    (wrong > 0).then(|| format!("faults in {wrong} of {all} elements"))
}

const HEADER: [&str; 10] =
    ["element", "verdict", "offset", "reference", "at rest", "noise", "rise", "expected", "response", "levels"];

fn row(name: String, finding: &SelfTestFinding) -> Vec<String> {
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

/// Verdict on an element, or `pass`.
fn verdict(finding: &SelfTestFinding) -> String {
    match (finding.faults.is_none(), finding.cause) {
        (true, _) => "pass".to_owned(),
        (false, Some(cause)) => format!("{} ({})", finding.faults, cause.name()),
        (false, None) => finding.faults.to_string(),
    }
}

fn name(names: &[String], finding: &SelfTestFinding) -> String {
    names.get(usize::from(finding.element)).cloned().unwrap_or_else(|| format!("element {}", finding.element))
}

/// A date in words of RFC 3339.
fn date(unix_s: u32) -> String {
    let time = OffsetDateTime::from_unix_timestamp(unix_s.into()).unwrap_or(OffsetDateTime::UNIX_EPOCH);
    time.format(&Rfc3339).unwrap_or_else(|_| unix_s.to_string())
}

/// An element a line. The last line is the verdict on all.
fn table(names: &[String], findings: &[SelfTestFinding]) -> String {
    let mut lines = vec![HEADER.map(str::to_owned).to_vec()];
    lines.extend(findings.iter().map(|finding| row(name(names, finding), finding)));
    // Two words, the rest are numbers.
    let right: Vec<usize> = (2..HEADER.len()).collect();
    let verdict = faults(findings).unwrap_or_else(|| "pass".to_owned());
    format!("{}\n{verdict}\n", columns(&lines, &right))
}
