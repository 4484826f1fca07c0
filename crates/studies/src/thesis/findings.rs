//! Findings of a study: published values, ours, and the bar between them.

use plot::{Chart, Figure};

/// One line of a study's table.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyFinding {
    /// Name of the value.
    pub what: String,
    /// Empty where nothing was published.
    pub published: String,
    /// The value that we found, with its unit.
    pub ours: String,
    /// Bar; empty where the value is only reported.
    pub bar: String,
    /// The bar is reached, where there is one.
    pub met: Option<bool>,
}

impl StudyFinding {
    /// Gives it a bar that the caller has judged.
    pub fn judged(&mut self, bar: impl Into<String>, met: bool) {
        self.bar = bar.into();
        self.met = Some(met);
    }
}

pub(super) fn in_unit(value: f64, unit: &str) -> String {
    in_words(plot::brief(value), unit)
}

/// A hyphen before a digit, and not within a word, is a minus.
fn with_minus(text: &str) -> String {
    let letters: Vec<char> = text.chars().collect();
    let is_minus = |at: usize| {
        let before = at.checked_sub(1).map(|before| letters[before]);
        letters[at] == '-'
            && letters.get(at + 1).is_some_and(char::is_ascii_digit)
            && before.is_none_or(|before| before.is_whitespace() || "([".contains(before))
    };
    (0..letters.len()).map(|at| if is_minus(at) { '−' } else { letters[at] }).collect()
}

fn in_words(words: String, unit: &str) -> String {
    if unit.is_empty() { words } else { format!("{words} {unit}") }
}

/// All of a study.
#[derive(Debug, Clone, Default)]
pub struct StudyFindings {
    /// Values for the placeholders of the page.
    pub values: Vec<(&'static str, String)>,
    /// Lines of the table.
    pub findings: Vec<StudyFinding>,
    /// The picture.
    pub figure: Figure,
}

impl StudyFindings {
    /// Draws rows of charts as the study's picture.
    pub fn picture(&mut self, title: &str, rows: impl IntoIterator<Item = Vec<Chart>>) {
        self.figure = rows.into_iter().fold(Figure::new(title), Figure::row);
    }

    /// Adds a line without a bar: our value beside a published one.
    pub fn compared(
        &mut self,
        what: impl Into<String>,
        published: impl Into<String>,
        ours: impl Into<String>,
    ) -> &mut StudyFinding {
        let (published, ours) = (with_minus(&published.into()), with_minus(&ours.into()));
        self.findings.push_mut(StudyFinding { what: what.into(), published, ours, bar: String::new(), met: None })
    }

    /// Adds a line whose value was never published.
    pub fn reported(&mut self, what: impl Into<String>, ours: impl Into<String>) -> &mut StudyFinding {
        self.compared(what, "", ours)
    }

    /// Adds a value in a unit, which has to lie in a range.
    pub fn between(
        &mut self,
        what: impl Into<String>,
        published: impl Into<String>,
        (ours, unit): (f64, &str),
        (least, most): (f64, f64),
    ) {
        let number = plot::brief;
        let bar = match (least.is_finite(), most.is_finite()) {
            (true, true) => format!("{} to {}", number(least), number(most)),
            (true, false) => format!("at least {}", number(least)),
            _ => format!("at most {}", number(most)),
        };
        let met = (least..=most).contains(&ours);
        self.compared(what, published, in_unit(ours, unit)).judged(in_words(bar, unit), met);
    }

    /// Adds a value that has to lie within some percent of a published one.
    pub fn near(&mut self, what: impl Into<String>, published: f64, (ours, unit): (f64, &str), percent: f64) {
        let off = 100.0 * (ours / published - 1.0);
        let ours = format!("{} ({off:+.1} %)", in_unit(ours, unit));
        self.compared(what, in_unit(published, unit), ours).judged(format!("within {percent} %"), off.abs() <= percent);
    }

    /// Adds a value that has to lie within a factor of a published one, where the figure that it
    /// was read from is logarithmic.
    pub fn within_factor(&mut self, what: impl Into<String>, published: f64, (ours, unit): (f64, &str), factor: f64) {
        let met = (published / factor..=published * factor).contains(&ours);
        self.compared(what, in_unit(published, unit), in_unit(ours, unit))
            .judged(format!("within a factor {factor}"), met);
    }

    /// The value of one of the page's placeholders.
    pub fn fill(&mut self, name: &'static str, value: impl Into<String>) {
        self.values.push((name, value.into()));
    }

    /// Number of bars, and of those that are met.
    pub fn score(&self) -> (usize, usize) {
        let judged = || self.findings.iter().filter_map(|finding| finding.met);
        (judged().count(), judged().filter(|met| *met).count())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_below_zero_have_a_minus_and_words_keep_their_hyphens() {
        let mut findings = StudyFindings::default();
        let found = findings.compared("", "-1 to 2 Hz", "0.202 Hz (-1.1 %) of card1-die1, 2-D");
        assert_eq!(
            (found.published.as_str(), found.ours.as_str()),
            ("−1 to 2 Hz", "0.202 Hz (−1.1 %) of card1-die1, 2-D")
        );
    }

    /// The only line of findings.
    fn found(add: impl Fn(&mut StudyFindings)) -> StudyFinding {
        let mut findings = StudyFindings::default();
        add(&mut findings);
        findings.findings.remove(0)
    }

    #[test]
    fn bars_are_met_up_to_their_edges_and_not_beyond() {
        let near = |ours| found(|all| all.near("", 0.2, (ours, "Hz"), 20.0)).met;
        assert_eq!([near(0.161), near(0.239), near(0.159), near(0.241)], [true, true, false, false].map(Some));
        let factor = |ours| found(|all| all.within_factor("", 2e-4, (ours, "Hz"), 1.5)).met;
        assert_eq!(
            [factor(1.34e-4), factor(2.99e-4), factor(1.3e-4), factor(3.1e-4)],
            [true, true, false, false].map(Some)
        );
        let between = |ours| found(|all| all.between("", "", (ours, "%"), (97.0, f64::INFINITY))).met;
        assert_eq!([between(97.0), between(96.9), between(f64::NAN)], [true, false, false].map(Some));
    }

    #[test]
    fn a_finding_says_its_bar_and_what_was_found() {
        let of = found(|all| all.between("", "", (99.5, "%"), (97.0, f64::INFINITY)));
        assert_eq!((of.ours.as_str(), of.bar.as_str()), ("99.5 %", "at least 97 %"));
        let of = found(|all| all.within_factor("", 2e-3, (1e-3, "Hz"), 1.5));
        assert_eq!((of.ours.as_str(), of.bar.as_str(), of.met), ("0.001 Hz", "within a factor 1.5", Some(false)));
        let mut findings = StudyFindings { findings: vec![of], ..StudyFindings::default() };
        findings.reported("", "3 s");
        assert_eq!(findings.score(), (1, 0));
    }
}
