//! What the checks read: files as syntax.

use crate::sources::RustFile;
use anyhow::{Context, Result};

/// A file without its tests, parsed.
pub struct ParsedFile {
    /// From the workspace's root on.
    pub path: String,
    pub syntax: syn::File,
}

impl ParsedFile {
    pub fn parse(file: &RustFile) -> Result<ParsedFile> {
        let syntax =
            syn::parse_file(&file.without_tests()).with_context(|| format!("{} cannot be parsed", file.path))?;
        Ok(ParsedFile { path: file.path.clone(), syntax })
    }
}

/// The name of a type that an item defines.
pub fn type_name(item: &syn::Item) -> Option<&syn::Ident> {
    match item {
        syn::Item::Enum(item) => Some(&item.ident),
        syn::Item::Struct(item) => Some(&item.ident),
        syn::Item::Trait(item) => Some(&item.ident),
        syn::Item::Type(item) => Some(&item.ident),
        syn::Item::Union(item) => Some(&item.ident),
        _ => None,
    }
}

#[cfg(test)]
pub mod testing {
    use super::ParsedFile;

    pub fn parsed(files: &[(&str, &str)]) -> Vec<ParsedFile> {
        let parse = |&(path, text): &(&str, &str)| {
            let syntax = syn::parse_file(text).expect("the test's own source");
            ParsedFile { path: path.into(), syntax }
        };
        files.iter().map(parse).collect()
    }
}
