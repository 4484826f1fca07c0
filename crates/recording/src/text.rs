//! Numbers and tables as text for people.

/// Five digits.
pub fn brief(value: f64) -> String {
    short(value, 5)
}

/// Four digits.
pub fn four_digits(value: f64) -> String {
    short(value, 4)
}

/// So many digits, without idle zeros; very small and very large numbers with a power of ten.
pub fn short(value: f64, digits: u8) -> String {
    let (size, behind_first) = (value.abs(), i32::from(digits) - 1);
    if size != 0.0 && !(1e-3..10_f64.powi(behind_first + 2)).contains(&size) {
        return format!("{value:.*e}", behind_first.max(0) as usize);
    }
    let places = (behind_first - libm::log10(size.max(1e-3)).floor() as i32).clamp(0, 9) as usize;
    let text = format!("{value:.places$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A value to the second digit of its standard error.
pub fn estimate(value: f64, se: f64) -> String {
    if !(se > 0.0 && se.is_finite()) {
        return brief(value);
    }
    let place = libm::log10(se).floor() as i32 - 1;
    // Small quantities keep a common power of ten, so that value and error can be compared.
    if value.abs().max(se) < 1e-3 {
        let exponent = libm::log10(value.abs().max(se)).floor() as i32;
        let (scale, digits) = (10_f64.powi(exponent), (exponent - place).clamp(0, 9) as usize);
        return format!("({:.digits$} ± {:.digits$})e{exponent}", value / scale, se / scale);
    }
    let digits = (-place).clamp(0, 9) as usize;
    let text = format!("{value:.digits$}");
    // There is no −0.00.
    let text =
        if text.bytes().any(|digit| (b'1'..=b'9').contains(&digit)) { &text } else { text.trim_start_matches('-') };
    format!("{text} ± {se:.digits$}")
}

/// A number to six digits, for people.
pub fn tidy(number: f64) -> f64 {
    format!("{number:.5e}").parse().unwrap_or(number)
}

/// Number with the name of what is counted: `1 record`, `2 records`.
pub fn count(number: usize, thing: &str) -> String {
    format!("{number} {thing}{}", if number == 1 { "" } else { "s" })
}

/// With a capital at its beginning.
pub fn capitalised(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// So many names, and the number of the others.
pub fn listed<S: std::borrow::Borrow<str>>(names: &[S], most: usize) -> String {
    match names.len().saturating_sub(most) {
        0 => names.join(", "),
        more => format!("{} and {more} more", names[..most].join(", ")),
    }
}

/// A sentence that quotes a file may hold anything; what is shown is one line.
pub fn one_line(sentence: String) -> String {
    if sentence.contains(char::is_control) { sentence.replace(char::is_control, " ") } else { sentence }
}

/// A text between the tags of a page or a picture: what it holds does not end it.
pub fn markup(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// The candidate nearest to `word`, if one is near enough to have been meant.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let similarity = |candidate: &str| strsim::jaro_winkler(&word.to_lowercase(), &candidate.to_lowercase());
    candidates
        .into_iter()
        .map(|candidate| (similarity(candidate), candidate))
        .filter(|(similarity, _)| *similarity > 0.6)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}

/// `did you mean …?` when something is near, otherwise the list of what is known.
pub fn suggest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str> + Clone) -> String {
    if let Some(candidate) = nearest(word, candidates.clone()) {
        return format!("did you mean `{candidate}`?");
    }
    let all: Vec<String> = candidates.into_iter().map(|candidate| format!("`{candidate}`")).collect();
    format!("known are {}", all.join(", "))
}

/// Lines of cells as columns that are as wide as their widest cell, two blanks apart; columns
/// numbered in `right` are set to the right.
pub fn columns(lines: &[Vec<String>], right: &[usize]) -> String {
    let columns = lines.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        lines.iter().filter_map(|line| line.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let set = |(i, (cell, &width)): (usize, (&String, &usize))| {
        if right.contains(&i) { format!("{cell:>width$}") } else { format!("{cell:<width$}") }
    };
    let line = |cells: &Vec<String>| {
        let cells: Vec<String> = cells.iter().zip(&widths).enumerate().map(set).collect();
        format!("{}\n", cells.join("  ").trim_end())
    };
    lines.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_thing_is_no_plural() {
        assert_eq!([0, 1, 2].map(|number| count(number, "record")), ["0 records", "1 record", "2 records"]);
    }

    #[test]
    fn a_few_names_stand_for_many() {
        assert_eq!(listed(&["a", "b"], 2), "a, b");
        assert_eq!(listed(&["a", "b", "c", "d"], 2), "a, b and 2 more");
    }

    #[test]
    fn values_show_the_digits_that_their_errors_leave() {
        assert_eq!(estimate(843.79231, 0.0113), "843.792 ± 0.011");
        assert_eq!(estimate(-36.2146, 0.43), "-36.21 ± 0.43");
        assert_eq!(estimate(8.0005e-4, 2.6e-8), "(8.00050 ± 0.00026)e-4");
        assert_eq!(estimate(1234.5, 67.0), "1234 ± 67");
        assert_eq!(estimate(20.0, 0.0), "20");
        assert_eq!(
            (estimate(-0.004, 0.12), estimate(0.17184, 1.2e-5)),
            ("0.00 ± 0.12".into(), "0.171840 ± 0.000012".into())
        );
    }

    #[test]
    fn numbers_have_four_digits_and_no_idle_zeros() {
        let written = [0.0, 1.0, 0.02, 1234.5678, 12.345_678, 1.5e-5, -0.5, 2.0e7].map(four_digits);
        assert_eq!(written, ["0", "1", "0.02", "1235", "12.35", "1.500e-5", "-0.5", "2.000e7"]);
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!((brief(0.05), brief(3000.0), brief(1.5708e-4)), ("0.05".into(), "3000".into(), "1.5708e-4".into()));
        assert_eq!(brief(0.0), "0");
    }

    #[test]
    fn columns_are_as_wide_as_their_widest_cell_and_lines_end_with_their_text() {
        let lines = [vec!["key", "°C", "state"], vec!["a longer one", "-12.5", ""], vec!["b"]];
        let lines: Vec<Vec<String>> =
            lines.iter().map(|line| line.iter().map(|&cell| cell.to_owned()).collect()).collect();
        assert_eq!(columns(&lines, &[1]), "key              °C  state\na longer one  -12.5\nb\n");
        assert_eq!(columns(&[], &[]), "");
    }
}
