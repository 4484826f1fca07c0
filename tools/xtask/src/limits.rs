//! How long pages may be, so that they are read, and that the book lists each of them.

use crate::{pages, shell};
use anyhow::{Context, Result, bail};

const MOST_PAGE_WORDS: usize = 2_500;
const MOST_README_WORDS: usize = 1_345;
const MOST_README_LINES: usize = 155;
const SUMMARY: &str = "docs/SUMMARY.md";

pub fn run() -> Result<()> {
    let root = shell::root();
    let read = |name: &str| std::fs::read_to_string(root.join(name)).with_context(|| format!("{name} cannot be read"));
    let mut texts = Vec::new();
    for path in pages::all(&root)? {
        let name = path.strip_prefix(&root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
        let text = read(&name)?;
        texts.push((name, text));
    }
    let faults = faults(&texts, &read(SUMMARY)?);
    if !faults.is_empty() {
        bail!("pages that are too long, or that the book misses:\n{}", faults.join("\n"));
    }
    Ok(())
}

fn faults(pages: &[(String, String)], summary: &str) -> Vec<String> {
    let mut faults = Vec::new();
    let mut check = |what: &str, count: usize, most: usize| {
        if count > most {
            faults.push(format!("{what}: {count}, {most} are allowed"));
        }
    };
    for (name, text) in pages {
        let is_readme = name == "README.md";
        check(
            &format!("{name}, words"),
            text.split_whitespace().count(),
            if is_readme { MOST_README_WORDS } else { MOST_PAGE_WORDS },
        );
        if is_readme {
            check(&format!("{name}, lines"), text.lines().count(), MOST_README_LINES);
        }
    }
    for (name, _) in pages {
        if let Some(page) = name.strip_prefix("docs/").filter(|_| name != SUMMARY)
            && !summary.contains(&format!("]({page})"))
        {
            faults.push(format!("{name} is not listed in {SUMMARY}"));
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_too_long_and_a_page_not_listed_are_named_with_their_numbers() {
        let page = |name: &str, words: usize| (name.to_owned(), "word ".repeat(words));
        let pages = [page("README.md", 1_346), page("docs/a.md", 2_500), page("docs/b.md", 2_501), page(SUMMARY, 1)];
        assert_eq!(
            faults(&pages, "- [A](a.md)"),
            [
                "README.md, words: 1346, 1345 are allowed",
                "docs/b.md, words: 2501, 2500 are allowed",
                "docs/b.md is not listed in docs/SUMMARY.md",
            ]
        );
    }
}
