//! What the checks read: files as syntax.

use crate::sources::RustFile;
use anyhow::{Context, Result};

/// A file without its tests, parsed.
pub struct ParsedFile {
    /// From the workspace's root on.
    pub path: String,
    pub syntax: syn::File,
    /// Whether it is of the crate `tests`, which is there for tests only.
    pub is_for_tests: bool,
}

impl ParsedFile {
    pub fn parse(file: &RustFile) -> Result<ParsedFile> {
        let syntax =
            syn::parse_file(&file.without_tests()?).with_context(|| format!("{} cannot be parsed", file.path))?;
        Ok(ParsedFile { path: file.path.clone(), syntax, is_for_tests: file.path.starts_with("tests/") })
    }
}

#[cfg(test)]
pub mod testing {
    use super::ParsedFile;

    pub fn parsed(files: &[(&str, &str)]) -> Vec<ParsedFile> {
        let parse = |&(path, text): &(&str, &str)| {
            let syntax = syn::parse_file(text).expect("the test's own source");
            ParsedFile { path: path.into(), syntax, is_for_tests: path.starts_with("tests/") }
        };
        files.iter().map(parse).collect()
    }
}
