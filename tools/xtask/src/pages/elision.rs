//! Comparing what a page shows with what a command prints, where `…` stands for anything: alone on
//! a line for any number of lines, within a line for any text.

pub const ELISION: &str = "…";

/// Alignment of shown and printed items.
#[derive(Debug, PartialEq)]
enum AlignedItem {
    Fits(usize, usize),
    /// This item is covered by an elision.
    Elided(usize),
    Differ(usize, usize),
    Missing(usize),
    /// Printed, not shown.
    Extra(usize),
    /// An elision, behind all that it covers.
    Elision(usize),
}

/// Tells whether a printed line is what a shown one stands for.
fn line_fits(shown: &str, printed: &str) -> bool {
    let mut parts = shown.trim_end().split(ELISION);
    let mut rest = printed.trim_end();
    let Some(after) = rest.strip_prefix(parts.next().unwrap_or_default()) else { return false };
    let mut parts: Vec<&str> = parts.collect();
    let Some(last) = parts.pop() else { return after.is_empty() };
    rest = after;
    for part in parts {
        let Some(at) = rest.find(part) else { return false };
        rest = &rest[at + part.len()..];
    }
    rest.ends_with(last)
}

/// The cheapest way to lay the items beside each other; an elision covers any number for nothing.
fn align(shown: &[&str], printed: &[&str]) -> Vec<AlignedItem> {
    let letters = |line: &str| line.chars().filter(|c| c.is_alphabetic()).collect::<String>();
    let differ = |i: usize, j: usize| -> u32 {
        if line_fits(shown[i], printed[j]) {
            0
        } else if letters(shown[i]) == letters(printed[j]) {
            // Other numbers, the same line.
            1
        } else {
            2
        }
    };
    let is_elision = |i: usize| shown[i].trim() == ELISION;
    let (rows, columns) = (shown.len(), printed.len());
    // Cost of everything from these two items on.
    let mut cost = vec![vec![0; columns + 1]; rows + 1];
    for i in (0..=rows).rev() {
        for j in (0..=columns).rev() {
            let elision = i < rows && is_elision(i);
            let skip = if elision { 0 } else { 2 };
            let mut ways = Vec::new();
            if i < rows {
                ways.push(cost[i + 1][j] + skip);
            }
            if j < columns {
                ways.push(cost[i][j + 1] + skip);
            }
            if i < rows && j < columns && !elision {
                ways.push(cost[i + 1][j + 1] + differ(i, j));
            }
            cost[i][j] = ways.into_iter().min().unwrap_or(0);
        }
    }
    let mut pairs = Vec::new();
    let (mut i, mut j) = (0, 0);
    while i < rows || j < columns {
        let elision = i < rows && is_elision(i);
        if i < rows && j < columns && !elision && cost[i][j] == cost[i + 1][j + 1] + differ(i, j) {
            pairs.push(if differ(i, j) == 0 { AlignedItem::Fits(i, j) } else { AlignedItem::Differ(i, j) });
            (i, j) = (i + 1, j + 1);
        } else if j < columns && cost[i][j] == cost[i][j + 1] + if elision { 0 } else { 2 } {
            pairs.push(if elision { AlignedItem::Elided(j) } else { AlignedItem::Extra(j) });
            j += 1;
        } else {
            pairs.push(if elision { AlignedItem::Elision(i) } else { AlignedItem::Missing(i) });
            i += 1;
        }
    }
    pairs
}

fn is_fault(pair: &AlignedItem) -> bool {
    matches!(pair, AlignedItem::Differ(..) | AlignedItem::Missing(_) | AlignedItem::Extra(_))
}

/// Where shown and printed lines differ, as a text: `-` is shown, `+` is printed. Nothing where all
/// is as shown.
pub fn difference(shown: &[&str], printed: &[&str]) -> Option<String> {
    let pairs = align(shown, printed);
    if !pairs.iter().any(is_fault) {
        return None;
    }
    let mut text = String::new();
    for (at, pair) in pairs.iter().enumerate() {
        // One line around each difference says where it is.
        let near = pairs[at.saturating_sub(1)..pairs.len().min(at + 2)].iter().any(is_fault);
        match *pair {
            AlignedItem::Fits(i, _) | AlignedItem::Elision(i) if near => text += &format!("      {}\n", shown[i]),
            AlignedItem::Differ(i, j) => text += &format!("    - {}\n    + {}\n", shown[i], printed[j]),
            AlignedItem::Missing(i) => text += &format!("    - {}\n", shown[i]),
            AlignedItem::Extra(j) => text += &format!("    + {}\n", printed[j]),
            _ => {}
        }
    }
    Some(text)
}

/// Lines that a page is to show: the printed lines, with those elisions of the shown ones that
/// still stand for something.
pub fn revised(shown: &[&str], printed: &[&str]) -> Vec<String> {
    let lines = align(shown, printed).into_iter().filter_map(|pair| match pair {
        AlignedItem::Fits(i, _) | AlignedItem::Elision(i) => Some(shown[i].to_owned()),
        AlignedItem::Differ(i, j) => Some(revised_line(shown[i], printed[j])),
        AlignedItem::Extra(j) => Some(printed[j].to_owned()),
        AlignedItem::Missing(_) | AlignedItem::Elided(_) => None,
    });
    lines.collect()
}

/// The same within a line, word by word.
fn revised_line(shown: &str, printed: &str) -> String {
    if !shown.contains(ELISION) {
        return printed.to_owned();
    }
    let (shown_words, printed_words) = (words(shown), words(printed));
    let pairs = align(&shown_words, &printed_words);
    let kept = pairs.iter().filter_map(|pair| match *pair {
        AlignedItem::Fits(i, _) | AlignedItem::Elision(i) => Some(shown_words[i]),
        AlignedItem::Differ(_, j) | AlignedItem::Extra(j) => Some(printed_words[j]),
        AlignedItem::Missing(_) | AlignedItem::Elided(_) => None,
    });
    let line: String = kept.collect();
    if line_fits(&line, printed) && line.trim() != ELISION { line } else { printed.to_owned() }
}

/// Words, and the spaces between them.
fn words(line: &str) -> Vec<&str> {
    let mut words = Vec::new();
    let mut rest = line;
    while let Some(first) = rest.chars().next() {
        let end = rest.find(|c: char| (c == ' ') != (first == ' ')).unwrap_or(rest.len());
        let (word, after) = rest.split_at(end);
        words.push(word);
        rest = after;
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<&str> {
        text.lines().collect()
    }

    #[test]
    fn an_elision_stands_for_any_lines_or_any_text_and_for_nothing_else() {
        let same = |shown, printed| difference(&lines(shown), &lines(printed)).is_none();
        assert!(same("a\n…\nd", "a\nb\nc\nd"));
        assert!(same("a\n…", "a"));
        assert!(same("took … s of …", "took 3.5 s of 7 s"));
        assert!(same("", ""));
        assert!(!same("", "a"));
        assert!(!same("a\n…\nd", "a\nb\nc"));
        assert!(!same("took … ms", "took 3.5 s"));
        assert!(!same("a…a", "a"));
    }

    #[test]
    fn a_difference_shows_both_lines_and_what_stands_around_them() {
        let difference = difference(&lines("one\ntwo\nthree 3\nfour\nfive"), &lines("one\ntwo\nthree 4\nfour\nfive"));
        assert_eq!(difference.as_deref(), Some("      two\n    - three 3\n    + three 4\n      four\n"));
    }

    #[test]
    fn a_revision_keeps_the_elisions_that_still_stand_for_something() {
        let revised = |shown, printed| revised(&lines(shown), &lines(printed)).join("\n");
        assert_eq!(revised("a 1\n…\nd 1", "a 2\nb\nc\nd 2"), "a 2\n…\nd 2");
        assert_eq!(
            revised("poles 3\n… s of computing: … times", "poles 4\n0.5 s of computing: 20 times"),
            "poles 4\n… s of computing: … times"
        );
        assert_eq!(revised("3 poles,  … s on one core", "4 poles,  0.5 s on one core"), "4 poles,  … s on one core");
        assert_eq!(revised("gone\nkept", "kept"), "kept");
        assert_eq!(revised("", "new\nlines"), "new\nlines");
    }
}
