//! Checks that relative links between the project's Markdown pages lead somewhere: the file exists,
//! and so does the heading behind a `#`. The book lists every page of `docs`.
//!
//! Understood are `[text](target)`, `![text](target)`, `[name]: target` and `src="…"`, `href="…"`;
//! code is skipped, addresses of the web are not followed.

use crate::{markdown, shell, sources};
use anyhow::{Context, Result, bail};
use std::collections::BTreeMap;
use std::path::Path;

/// Templates: their links are those of the pages in `docs/results` that are made from them, which
/// are checked there.
const TEMPLATES: &str = "crates/studies/src";
/// Pages of the book, in the folder `docs`.
const SUMMARY: &str = "SUMMARY.md";

pub fn run() -> Result<()> {
    let mut broken = Vec::new();
    let templates = shell::root().join(TEMPLATES);
    let pages = sources::files_with_extension(&shell::root(), "md")?;
    for page in pages.iter().filter(|page| !page.starts_with(&templates)) {
        let text = std::fs::read_to_string(page).with_context(|| format!("{} cannot be read", page.display()))?;
        for (line, target) in targets(&text) {
            if let Some(fault) = fault(page, &text, &target) {
                let shown = page.strip_prefix(shell::root()).unwrap_or(page).display();
                broken.push(format!("{shown}:{line}: {target}: {fault}"));
            }
        }
    }
    let book = shell::root().join("docs");
    let listed = std::fs::read_to_string(book.join(SUMMARY))?;
    for page in pages.iter().filter_map(|page| page.strip_prefix(&book).ok()).filter(|page| *page != Path::new(SUMMARY))
    {
        if !listed.contains(&format!("]({})", page.display())) {
            broken.push(format!("docs/{}: is not listed in docs/{SUMMARY}", page.display()));
        }
    }
    if !broken.is_empty() {
        bail!("links that lead nowhere:\n{}", broken.join("\n"));
    }
    Ok(())
}

/// Fault of a link of a page, if anything.
fn fault(page: &Path, text: &str, target: &str) -> Option<String> {
    if target.contains("://") || target.starts_with("mailto:") {
        return None;
    }
    let (file, anchor) = target.split_once('#').map_or((target, None), |(file, anchor)| (file, Some(anchor)));
    let path = if file.is_empty() { page.to_path_buf() } else { page.parent()?.join(file) };
    if !file.is_empty() && !path.exists() {
        return Some("there is no such file".into());
    }
    let anchor = anchor?;
    if path.extension().is_none_or(|extension| extension != "md") {
        return None;
    }
    let other = if file.is_empty() { text.to_owned() } else { std::fs::read_to_string(&path).ok()? };
    (!anchors(&other).iter().any(|known| known == anchor)).then(|| "there is no such heading".into())
}

fn without_code(line: &str) -> String {
    line.split('`').enumerate().map(|(part, text)| if part % 2 == 0 { text } else { "" }).collect::<Vec<_>>().join("`")
}

/// Link targets of a page and the lines that they stand in.
fn targets(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (number, line) in markdown::prose(text) {
        let line = without_code(line);
        let mut add = |target: &str| {
            // A title may follow the target: [text](target "title").
            let target = target.split_whitespace().next().unwrap_or_default().trim_matches(['<', '>']);
            if !target.is_empty() {
                found.push((number, target.to_owned()));
            }
        };
        for (open, close) in [("](", ')'), ("src=\"", '"'), ("href=\"", '"')] {
            for after in line.split(open).skip(1) {
                if let Some((target, _)) = after.split_once(close) {
                    add(target);
                }
            }
        }
        if line.starts_with('[')
            && let Some((_, target)) = line.split_once("]: ")
        {
            add(target);
        }
    }
    found
}

/// The names by which a page's headings are linked to, made as GitHub makes them.
fn anchors(text: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    let mut twins: BTreeMap<String, usize> = BTreeMap::new();
    for (_, line) in markdown::prose(text) {
        let heading = line.trim_start_matches('#');
        if heading.len() == line.len() || !heading.starts_with(' ') {
            continue;
        }
        let kept = |c: &char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
        let name = heading.trim().to_lowercase().chars().filter(kept).collect::<String>().replace(' ', "-");
        let before = twins.entry(name.clone()).or_default();
        found.push(if *before == 0 { name } else { format!("{name}-{before}") });
        *before += 1;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_are_found_in_prose_but_not_in_code() {
        let text = "see [a](a.md#x) and ![b](b.svg \"title\"), `[no](no.md)`\n```\n[no](no.md)\n```\n[c]: c.md\n<img src=\"d.svg\">\n";
        let found: Vec<_> = targets(text).into_iter().map(|(line, target)| format!("{line} {target}")).collect();
        assert_eq!(found, ["1 a.md#x", "1 b.svg", "5 c.md", "6 d.svg"]);
    }

    #[test]
    fn headings_are_named_as_github_names_them() {
        let text = "# The `anemo run` command\n## Cost, at 168 MHz\n## Twice\n## Twice\n```\n# not me\n```\n#nor-me\n";
        assert_eq!(anchors(text), ["the-anemo-run-command", "cost-at-168-mhz", "twice", "twice-1"]);
    }

    #[test]
    fn a_missing_file_and_a_missing_heading_are_told_apart() {
        let page = shell::root().join("README.md");
        let fault = |target| fault(&page, "# Here\n", target);
        assert_eq!(fault("#here"), None);
        assert_eq!(fault("Cargo.toml"), None);
        assert_eq!(fault("https://example.org/x#y"), None);
        assert_eq!(fault("#there").as_deref(), Some("there is no such heading"));
        assert_eq!(fault("nowhere.md").as_deref(), Some("there is no such file"));
    }
}
