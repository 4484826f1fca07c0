//! Values of options: one of a few words, or a count.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use crate::output::Failure;

/// Reads one of some words as what it stands for; help says what each of them means, unless it says
/// nothing.
pub fn choice<T, const N: usize>(words: [(&'static str, &'static str, T); N]) -> impl TypedValueParser<Value = T>
where
    T: Clone + Send + Sync + 'static,
{
    let named = |(word, help, _): &(&'static str, &'static str, T)| {
        let value = PossibleValue::new(*word);
        if help.is_empty() { value } else { value.help(*help) }
    };
    let parser = PossibleValuesParser::new(words.iter().map(named));
    parser.try_map(move |text| {
        let known = words.iter().find(|(word, ..)| *word == text);
        known.map(|(_, _, value)| value.clone()).ok_or_else(|| Failure::usage("no such word"))
    })
}

/// A count.
pub fn at_least_one(text: &str) -> Result<usize, Failure> {
    let count = text.parse().ok().filter(|&count: &usize| count > 0);
    count.ok_or_else(|| Failure::usage(format!("`{text}` is no whole number of at least 1")))
}
