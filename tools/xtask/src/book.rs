//! The book: the pages of `docs` as one searchable web site in `target/book`, which needs no server
//! and no network.
//!
//! `mdbook` makes the pages, `mathcore` turns equations (blocks ```` ```math ```` and `` $`…`$ ``,
//! which GitHub shows, too) into MathML. Links to files outside of `docs` lead somewhere in the
//! repository only; in the book they are text.

use crate::install::{self, MATHCORE, MDBOOK};
use crate::{links, shell, sources};
use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};

#[derive(clap::Args, Default)]
pub struct BookOptions {
    /// Open it in a web browser
    #[arg(long)]
    open: bool,
}

pub fn run(options: &BookOptions) -> Result<()> {
    links::run()?;
    let folder = build()?;
    let index = folder.join("index.html");
    println!("book  {}", index.display());
    if options.open {
        shell::run(shell::program(if cfg!(target_os = "macos") { "open" } else { "xdg-open" }).arg(index))?;
    }
    Ok(())
}

fn build() -> Result<PathBuf> {
    let (mdbook, mathcore) = (install::tool(&MDBOOK)?, install::tool(&MATHCORE)?);
    let folder = shell::target_directory()?.join("book");
    shell::run(shell::program(mdbook).args(["build", "docs"]).arg("--dest-dir").arg(&folder))?;
    let mut equations = shell::program(mathcore);
    equations.arg("--recursive").arg(&folder);
    equations.args(["--block-open", "<pre><code class=\"language-math\">", "--block-close", "</code></pre>"]);
    equations.args(["--inline-open", "$<code>", "--inline-close", "</code>$"]);
    shell::run(&mut equations).context("an equation cannot be read")?;
    let mut faults = Vec::new();
    for page in sources::files_with_extension(&folder, "html")? {
        let html = std::fs::read_to_string(&page).with_context(|| format!("{} cannot be read", page.display()))?;
        // The first page of a folder is its index, which mdbook's links do not know.
        let html = without_links_out(&html, &page, &folder).replace("README.html", "index.html");
        std::fs::write(&page, &html).with_context(|| format!("{} cannot be written", page.display()))?;
        let name = page.strip_prefix(&folder).unwrap_or(&page).display().to_string();
        faults.extend(page_faults(&html, &page).into_iter().map(|fault| format!("{name}: {fault}")));
    }
    faults.extend(
        ["index.html", "404.html", "print.html"]
            .map(String::from)
            .into_iter()
            .filter(|name| !folder.join(name).is_file()),
    );
    if !faults.is_empty() {
        bail!("the book is not whole:\n{}", faults.join("\n"));
    }
    Ok(folder)
}

/// A page whose links to files outside of the book are text.
fn without_links_out(html: &str, page: &Path, folder: &Path) -> String {
    let mut parts = html.split("<a href=\"");
    let mut kept = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let text = part.split_once("\">").and_then(|(target, rest)| {
            let (text, after) = rest.split_once("</a>")?;
            leads_out(target, page, folder).then(|| format!("{text}{after}"))
        });
        kept += &text.unwrap_or_else(|| format!("<a href=\"{part}"));
    }
    kept
}

/// Tells whether a relative link climbs out of the book's folder.
fn leads_out(target: &str, page: &Path, folder: &Path) -> bool {
    let depth = page.strip_prefix(folder).map_or(0, |page| page.components().count() - 1);
    let climbs = target.split('/').take_while(|part| *part == "..").count();
    climbs > depth
}

/// Faults of a page: what it fetches from the web, and what it shows or leads to that is not there.
fn page_faults(html: &str, page: &Path) -> Vec<String> {
    let mut faults = Vec::new();
    for tag in html.split('<').filter_map(|rest| rest.split_once('>').map(|(tag, _)| tag)) {
        let fetches = ["script", "link", "img", "iframe"].iter().any(|name| tag.starts_with(&format!("{name} ")));
        for target in ["href=\"", "src=\""].iter().filter_map(|name| tag.split_once(name)?.1.split('"').next()) {
            let from_web = target.contains("://") || target.starts_with("//");
            if from_web && fetches {
                faults.push(format!("fetches {target}"));
            }
            let file = target.split(['#', '?']).next().unwrap_or_default();
            let is_file = !from_web && !file.is_empty() && !file.starts_with('/') && !file.contains(':');
            if is_file && page.parent().is_none_or(|folder| !folder.join(file).exists()) {
                faults.push(format!("leads to {target}, which is not there"));
            }
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_out_of_the_book_is_text_and_any_other_stays() {
        let (page, folder) = (Path::new("/b/how-to/x.html"), Path::new("/b"));
        let html = "<p><a href=\"../index.html\">in</a>, <a href=\"../../src/lib.rs\"><code>lib.rs</code></a>.</p>";
        assert_eq!(
            without_links_out(html, page, folder),
            "<p><a href=\"../index.html\">in</a>, <code>lib.rs</code>.</p>"
        );
    }

    #[test]
    fn what_is_fetched_from_the_web_and_what_is_missing_is_found() {
        let html = "<script src=\"https://a.b/c.js\"></script><a href=\"https://a.b\">x</a><img src=\"gone.svg\">";
        let faults = page_faults(html, Path::new("/nowhere/x.html"));
        assert_eq!(faults, ["fetches https://a.b/c.js", "leads to gone.svg, which is not there"]);
    }
}
