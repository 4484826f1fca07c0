//! Rust files of a workspace: their crates, and which of their lines are code, documentation, tests.
//!
//! Tests are: files in a crate's folders `tests`, `benches` and `examples`, in any folder `tests` of
//! its sources, and files called `tests.rs`; modules and items whose `cfg` names `test` or the
//! feature `testing`, outside of `not`. Sources are taken as rustfmt writes them.

use anyhow::{Context, Result};
use std::path::{Path, PathBuf};

const EXAMPLE_FOLDERS: [&str; 2] = ["benches", "examples"];

/// A Rust file.
pub struct RustFile {
    /// From the workspace's root on, parted by `/`.
    pub path: String,
    /// Folder of the nearest `Cargo.toml`, in the same form.
    pub crate_folder: String,
    pub text: String,
    /// Lines that belong to tests.
    pub in_tests: Vec<bool>,
    /// Content of each line.
    pub kinds: Vec<LineKind>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LineKind {
    /// Nothing, or a comment that is no documentation.
    Empty,
    Code,
    Documentation,
}

impl RustFile {
    /// Path within its crate.
    fn inner_path(&self) -> &str {
        self.path.strip_prefix(&self.crate_folder).unwrap_or(&self.path).trim_start_matches('/')
    }

    pub fn is_example(&self) -> bool {
        self.inner_path().split_once('/').is_some_and(|(folder, _)| EXAMPLE_FOLDERS.contains(&folder))
    }
}

/// All Rust files below a folder, in the order of their paths.
pub fn rust_files(root: &Path) -> Result<Vec<RustFile>> {
    let mut files = Vec::new();
    for path in files_with_extension(root, "rs")? {
        let text = std::fs::read_to_string(&path).with_context(|| format!("{} cannot be read", path.display()))?;
        let path = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
        let crate_folder = crate_folder(root, &path);
        files.push(RustFile { path, crate_folder, text, in_tests: Vec::new(), kinds: Vec::new() });
    }
    mark(&mut files);
    Ok(files)
}

/// Folder of the nearest `Cargo.toml` below the root, or the first folder where there is no other.
pub fn crate_folder(root: &Path, path: &str) -> String {
    let folders = || path.match_indices('/').map(|(end, _)| &path[..end]);
    let is_crate = |folder: &&str| root.join(folder).join("Cargo.toml").is_file();
    folders().rfind(is_crate).or(folders().next()).unwrap_or_default().to_owned()
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

fn mark(files: &mut [RustFile]) {
    let mut test_modules = Vec::new();
    for file in &mut *files {
        let lines: Vec<&str> = file.text.lines().collect();
        file.kinds = lines.iter().map(|line| kind(line)).collect();
        file.in_tests = in_tests(&lines);
        let path = file.path.trim_end_matches(".rs");
        let folder = ["/mod", "/lib", "/main"].iter().find_map(|root| path.strip_suffix(root)).unwrap_or(path);
        let names = lines.iter().zip(&file.in_tests).filter(|(_, is_test)| **is_test);
        let names = names.filter_map(|(line, _)| line.strip_suffix(';')?.rsplit_once("mod ").map(|(_, name)| name));
        test_modules.extend(names.map(|name| format!("{folder}/{name}")));
    }
    for file in files {
        let is_below =
            |module: &String| file.path.strip_prefix(module).is_some_and(|rest| rest.starts_with(['.', '/']));
        let in_test_folder = file.inner_path().split('/').any(|part| part == "tests" || part == "tests.rs");
        if in_test_folder || file.is_example() || test_modules.iter().any(is_below) {
            file.in_tests.fill(true);
        }
    }
}

fn kind(line: &str) -> LineKind {
    let line = line.trim_start();
    let is_documentation = line.starts_with("//!") || line.starts_with("///") && !line.starts_with("////");
    match line {
        _ if is_documentation => LineKind::Documentation,
        "" => LineKind::Empty,
        _ if line.starts_with("//") => LineKind::Empty,
        _ => LineKind::Code,
    }
}

/// Marks modules, items, fields and branches that are for tests, attributes included. Each ends
/// with the first line of its own indent that closes it.
fn in_tests(lines: &[&str]) -> Vec<bool> {
    let indent = |line: &str| line.len() - line.trim_start().len();
    let is_attribute = |line: &&&str| line.trim_start().starts_with("#[") || kind(line) == LineKind::Documentation;
    let mut marks = vec![false; lines.len()];
    if lines.iter().any(|line| line.starts_with("#![cfg(") && is_for_tests(line)) {
        marks.fill(true);
    }
    for (at, line) in lines.iter().enumerate() {
        if marks[at] || !line.trim_start().starts_with("#[cfg(") || !is_for_tests(line) {
            continue;
        }
        let before = lines[..at].iter().rev().take_while(is_attribute).count();
        let first = at + lines[at..].iter().take_while(is_attribute).count();
        let Some(item) = lines.get(first) else { continue };
        // A value that begins on the next line ends further in.
        let goes_on = item.ends_with(" =");
        let ends = |line: &&str| match indent(line).checked_sub(indent(item)) {
            Some(0 | 4) if goes_on => line.ends_with(';'),
            Some(0) => {
                (line == item || line.trim_start().starts_with(['}', ')', ']'])) && line.ends_with(['}', ';', ','])
            }
            _ => false,
        };
        let length = lines[first..].iter().position(ends).map_or(lines.len() - first, |end| end + 1);
        marks[at - before..first + length].fill(true);
    }
    marks
}

/// Says if a condition names tests outside of `not`.
fn is_for_tests(line: &str) -> bool {
    let condition = line.replace("not(test)", "").replace("\"test\"", "");
    condition.contains("\"testing\"") || condition.split(|c: char| !c.is_alphanumeric()).any(|word| word == "test")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn test_lines(text: &str) -> Vec<bool> {
        in_tests(&text.lines().collect::<Vec<_>>())
    }

    fn file(path: &str, text: &str) -> RustFile {
        let crate_folder = path.split_once("/src/").or(path.split_once("/tests/")).or(path.split_once("/benches/"));
        let crate_folder = crate_folder.expect("a folder of a crate").0.to_owned();
        RustFile { path: path.into(), crate_folder, text: text.into(), in_tests: Vec::new(), kinds: Vec::new() }
    }

    #[test]
    fn an_item_for_tests_ends_with_its_body_or_its_semicolon() {
        let text = "fn f() {}\n#[cfg(test)]\n#[allow(dead_code)]\nmod tests {\n    fn g() {\n    }\n}\nfn h() {}\n";
        assert_eq!(test_lines(text), [false, true, true, true, true, true, true, false]);
        let text = "impl X {\n    #[cfg(test)]\n    fn f(&self) -> u8 {\n        1\n    }\n    fn g() {}\n}\n#[cfg(test)]\nmod tests;\nfn h() {}\n";
        assert_eq!(test_lines(text), [false, true, true, true, true, false, false, true, true, false]);
        let text = "impl X {\n    /// Doc.\n    #[cfg(test)]\n    pub fn f(a: impl I<T = u8>) -> u8 {\n        1\n    }\n    fn g() {}\n}\n";
        assert_eq!(test_lines(text), [false, true, true, true, true, true, false, false]);
        let text = "#[cfg(test)]\nconst A: B =\n    b(|| {\n        x();\n    });\nfn h() {}\n";
        assert_eq!(test_lines(text), [true, true, true, true, true, false]);
    }

    #[test]
    fn a_field_a_variant_and_a_branch_for_tests_end_with_their_comma() {
        let text = "struct X {\n    #[cfg(test)]\n    a: u8,\n    b: u8,\n}\nfn h() {\n    match x {\n        #[cfg(test)]\n        A => 1,\n        B => 2,\n    }\n}\n";
        let marks = test_lines(text);
        assert_eq!(marks.iter().enumerate().filter(|(_, is)| **is).map(|(at, _)| at).collect::<Vec<_>>(), [1, 2, 7, 8]);
    }

    #[test]
    fn conditions_that_name_tests_are_told_from_those_that_do_not() {
        for (condition, is_test) in [
            ("#[cfg(all(test, unix))]", true),
            ("#[cfg(any(test, feature = \"testing\"))]", true),
            ("#[cfg(feature = \"testing\")]", true),
            ("#[cfg(not(test))]", false),
            ("#[cfg(feature = \"test\")]", false),
            ("#[cfg_attr(test, derive(Debug))]", false),
        ] {
            assert_eq!(test_lines(&format!("{condition}\nfn f() {{}}")), [is_test; 2], "{condition}");
        }
        assert_eq!(test_lines("//! Doc.\n#![cfg(test)]\nfn f() {}"), [true; 3]);
    }

    #[test]
    fn a_line_is_code_documentation_or_nothing() {
        use LineKind::{Code, Documentation, Empty};
        let text = "//! Doc.\n    /// Doc.\n//// none\n\n    // why\nm! { /// Doc.\n    a / b }\n";
        let kinds: Vec<_> = text.lines().map(kind).collect();
        assert_eq!(kinds, [Documentation, Documentation, Empty, Empty, Empty, Code, Code]);
    }

    #[test]
    fn test_files_are_told_by_folder_by_name_and_by_who_brings_them_in() {
        let mut files = [
            file("a/src/lib.rs", "#[cfg(test)]\n/// Doc.\npub(crate) mod mock;\nmod real;\n"),
            file("a/src/mock.rs", "x\n"),
            file("a/src/mock/inner.rs", "x\n"),
            file("a/src/mocking.rs", "x\n"),
            file("a/src/real.rs", "x\n"),
            file("a/src/real/tests.rs", "x\n"),
            file("a/src/fuzz/b.rs", "x\n"),
            file("a/tests/b.rs", "x\n"),
            file("tools/a/benches/b.rs", "x\n"),
            file("tests/src/lib.rs", "x\n"),
        ];
        mark(&mut files);
        let marks: Vec<bool> = files[1..].iter().map(|file| file.in_tests[0]).collect();
        assert_eq!(marks, [true, true, false, false, true, false, true, true, false]);
        assert_eq!(files.iter().filter(|file| file.is_example()).count(), 1);
    }

    #[test]
    fn a_crate_is_the_folder_of_the_nearest_manifest() {
        let root = crate::shell::root();
        let own =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).strip_prefix(&root).expect("below").display().to_string();
        assert_eq!(crate_folder(&root, &format!("{own}/src/fuzz/found.rs")), own);
        assert_eq!(crate_folder(&root, "docs/images/live.py"), "docs");
        assert_eq!(crate_folder(&root, "build.rs"), "");
    }
}
