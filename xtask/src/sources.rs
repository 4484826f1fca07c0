//! The workspace's own files, and which of their lines belong to tests.
//!
//! Tests are: what lies in a folder `tests`, `benches` or `examples` or is called `tests.rs`; files
//! that a `#[cfg(test)] mod name;` brings in; and every item below `#[cfg(test)]`.

use crate::shell;
use anyhow::{Context, Result, anyhow};
use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::path::{Path, PathBuf};
use std::str::FromStr;

const TEST_FOLDERS: [&str; 4] = ["tests", "benches", "examples", "fuzz"];

/// A Rust file.
pub struct RustFile {
    /// From the workspace's root on, parted by `/`.
    pub path: String,
    pub text: String,
    /// Of each line, whether it belongs to tests.
    pub in_tests: Vec<bool>,
}

impl RustFile {
    /// Whether it is the source of a library or a binary, and no test from outside.
    pub fn is_in_a_crate(&self) -> bool {
        self.path.split('/').nth(1) == Some("src") && !self.path.starts_with("fuzz/")
    }

    /// Its text with all lines of tests left empty. Of the crate `tests` that is what its own tests
    /// are.
    pub fn without_tests(&self) -> Result<String> {
        let own = if self.path.starts_with("tests/src/") { test_lines(&self.text)? } else { self.in_tests.clone() };
        let line = |(line, is_test)| if is_test { String::from("\n") } else { format!("{line}\n") };
        Ok(self.text.lines().zip(own).map(line).collect())
    }
}

/// All Rust files of the workspace, in the order of their paths.
pub fn rust_files() -> Result<Vec<RustFile>> {
    let root = shell::root();
    let mut files = Vec::new();
    for path in files_with_extension(&root, "rs")? {
        let text = std::fs::read_to_string(&path).with_context(|| format!("{} cannot be read", path.display()))?;
        let path = path.strip_prefix(&root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
        files.push(RustFile { path, text, in_tests: Vec::new() });
    }
    mark_tests(&mut files)?;
    Ok(files)
}

/// All files of one kind below a folder, but none of hidden folders, build output and recordings.
pub fn files_with_extension(folder: &Path, extension: &str) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let entries = std::fs::read_dir(folder).with_context(|| format!("{} cannot be listed", folder.display()))?;
    for entry in entries {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() && !name.starts_with('.') && name != "target" && name != "out" {
            found.extend(files_with_extension(&path, extension)?);
        } else if path.extension().is_some_and(|own| own == extension) {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

fn mark_tests(files: &mut [RustFile]) -> Result<()> {
    let brought: Vec<String> = files.iter().flat_map(|file| test_modules(&file.path, &file.text)).collect();
    for file in files {
        let (folders, name) = file.path.rsplit_once('/').unwrap_or(("", &file.path));
        let whole = folders.split('/').any(|folder| TEST_FOLDERS.contains(&folder))
            || name == "tests.rs"
            || brought
                .iter()
                .any(|module| file.path.strip_prefix(module).is_some_and(|rest| rest.starts_with(['.', '/'])));
        file.in_tests = if whole {
            vec![true; file.text.lines().count()]
        } else {
            test_lines(&file.text).with_context(|| format!("{} cannot be read", file.path))?
        };
    }
    Ok(())
}

/// Files, without `.rs`, of modules that are there for tests only.
fn test_modules(path: &str, text: &str) -> Vec<String> {
    let folder = match path.strip_suffix("/mod.rs").or(path.strip_suffix("/lib.rs")).or(path.strip_suffix("/main.rs")) {
        Some(folder) => folder,
        None => path.strip_suffix(".rs").unwrap_or(path),
    };
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let module = |pair: &[&str]| {
        let name = pair[1].strip_suffix(';')?.rsplit_once("mod ")?.1;
        (pair[0] == "#[cfg(test)]").then(|| format!("{folder}/{name}"))
    };
    lines.windows(2).filter_map(module).collect()
}

fn test_lines(text: &str) -> Result<Vec<bool>> {
    let mut marks = vec![false; text.lines().count()];
    let tokens = TokenStream::from_str(text).map_err(|error| anyhow!("no Rust: {error}"))?;
    mark_items(tokens, &mut marks);
    Ok(marks)
}

/// Marks the lines of all items for tests among these tokens and in the braces among them.
fn mark_items(tokens: TokenStream, marks: &mut [bool]) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut at = 0;
    while at < tokens.len() {
        if is_for_tests(&tokens[at..]) {
            let length = item_length(&tokens[at..]);
            let last = &tokens[at + length - 1];
            marks[tokens[at].span().start().line - 1..last.span().end().line].fill(true);
            at += length;
        } else {
            if let TokenTree::Group(group) = &tokens[at] {
                mark_items(group.stream(), marks);
            }
            at += 1;
        }
    }
}

/// Whether these tokens begin with attributes of which one is `#[cfg(test)]`.
fn is_for_tests(tokens: &[TokenTree]) -> bool {
    let attribute = |pair: &[TokenTree]| match pair {
        [TokenTree::Punct(mark), TokenTree::Group(attribute)] if mark.as_char() == '#' => {
            Some(attribute.stream().to_string().replace(' ', ""))
        }
        _ => None,
    };
    tokens.chunks_exact(2).map_while(attribute).any(|attribute| attribute == "cfg(test)")
}

/// How many tokens the item takes: up to a semicolon or the brace of its body. A value may have
/// braces, too; then a semicolon follows.
fn item_length(tokens: &[TokenTree]) -> usize {
    let is_semicolon = |token: &TokenTree| matches!(token, TokenTree::Punct(mark) if mark.as_char() == ';');
    let is_brace =
        |token: &TokenTree| matches!(token, TokenTree::Group(group) if group.delimiter() == Delimiter::Brace);
    let ends = |&at: &usize| {
        is_semicolon(&tokens[at]) || is_brace(&tokens[at]) && !tokens.get(at + 1).is_some_and(is_semicolon)
    };
    (0..tokens.len()).find(ends).map_or(tokens.len(), |at| at + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(path: &str, text: &str) -> RustFile {
        RustFile { path: path.into(), text: text.into(), in_tests: Vec::new() }
    }

    #[test]
    fn an_item_for_tests_ends_with_its_body_or_its_semicolon() {
        let text = "fn f() {}\n#[cfg(test)]\n#[allow(dead_code)]\nmod tests {\n    fn g() {\n    }\n}\nfn h() {}\n";
        assert_eq!(test_lines(text).expect("Rust"), [false, true, true, true, true, true, true, false]);
        let text = "impl X {\n    #[cfg(test)]\n    fn f(&self) -> u8 {\n        1\n    }\n    fn g() {}\n}\n#[cfg(test)]\nmod tests;\nfn h() {}\n";
        assert_eq!(test_lines(text).expect("Rust"), [false, true, true, true, true, false, false, true, true, false]);
        let text = "impl X {\n    /// Doc.\n    #[cfg(test)]\n    pub fn f(a: impl I<T = u8>) -> u8 {\n        1\n    }\n    fn g() {}\n}\n";
        assert_eq!(test_lines(text).expect("Rust"), [false, true, true, true, true, true, false, false]);
        let text =
            "#[cfg(test)]\nconst A: B =\n    B { c: r#\"\n}\n\"# };\nfn h() {}\n#[cfg(any(test, x))]\nfn g() {}\n";
        assert_eq!(test_lines(text).expect("Rust"), [true, true, true, true, true, false, false, false]);
    }

    #[test]
    fn test_files_are_told_by_folder_by_name_and_by_who_brings_them_in() {
        let mut files = [
            file("a/src/lib.rs", "#[cfg(test)]\npub(crate) mod mock;\nmod real;\n"),
            file("a/src/mock.rs", "x\n"),
            file("a/src/mock/inner.rs", "x\n"),
            file("a/src/mocking.rs", "x\n"),
            file("a/src/real.rs", "x\n"),
            file("a/src/real/tests.rs", "x\n"),
            file("a/tests/b.rs", "x\n"),
        ];
        mark_tests(&mut files).expect("Rust");
        let marks: Vec<bool> = files[1..].iter().map(|file| file.in_tests[0]).collect();
        assert_eq!(marks, [true, true, false, false, true, true]);
    }
}
