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
    /// Whether each line belongs to tests.
    pub in_tests: Vec<bool>,
    /// What each line holds.
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
        let lines = scan(&file.text);
        file.kinds = lines.iter().map(|line| line.kind).collect();
        file.in_tests = in_tests(&lines);
        let path = file.path.trim_end_matches(".rs");
        let folder = ["/mod", "/lib", "/main"].iter().find_map(|root| path.strip_suffix(root)).unwrap_or(path);
        let names = lines.iter().zip(&file.in_tests).filter(|(_, is_test)| **is_test);
        let names =
            names.filter_map(|(line, _)| line.code.strip_suffix(';')?.rsplit_once("mod ").map(|(_, name)| name));
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

/// A line as far as it matters here.
struct ScannedLine {
    kind: LineKind,
    /// Without comments and what stands within quotes.
    code: String,
    /// Brackets that are open after it.
    depth: i32,
    /// Whether it holds `"testing"`.
    names_testing: bool,
}

/// Reads all lines, with texts and comments that go on over several of them.
fn scan(text: &str) -> Vec<ScannedLine> {
    /// What a line begins within.
    enum Open {
        Code,
        /// A text that ends so.
        Text(String),
        Comment,
    }
    let (mut open, mut depth) = (Open::Code, 0);
    let scanned = |line: &str| {
        let trimmed = line.trim_start();
        let is_documentation = matches!(open, Open::Code)
            && (trimmed.starts_with("//!") || trimmed.starts_with("///") && !trimmed.starts_with("////"));
        let mut has_code = matches!(open, Open::Text(_)) && !trimmed.is_empty();
        let (mut rest, mut code) = (line, String::new());
        while let Some(next) = rest.chars().next() {
            let mut length = next.len_utf8();
            match &open {
                Open::Text(end) if rest.starts_with(&**end) => {
                    length = end.len();
                    code.push('"');
                    open = Open::Code;
                }
                Open::Text(end) if next == '\\' && end == "\"" => length = rest.len().min(2),
                Open::Comment if rest.starts_with("*/") => (open, length) = (Open::Code, 2),
                Open::Text(_) | Open::Comment => {}
                Open::Code if rest.starts_with("//") => break,
                Open::Code if rest.starts_with("/*") => (open, length) = (Open::Comment, 2),
                Open::Code => {
                    let hashes = rest.strip_prefix('r').map_or(0, |raw| raw.len() - raw.trim_start_matches('#').len());
                    let is_word = code.ends_with(|c: char| c.is_alphanumeric() && c != 'b' || c == '_');
                    if !is_word && next == 'r' && rest[1 + hashes..].starts_with('"') {
                        length = 2 + hashes;
                        open = Open::Text(format!("\"{}", "#".repeat(hashes)));
                        code.push('"');
                    } else if next == '"' {
                        open = Open::Text("\"".to_owned());
                        code.push('"');
                    } else if next == '\''
                        && let Some(letter) = letter(rest)
                    {
                        length = letter;
                    } else {
                        depth += i32::from("([{".contains(next)) - i32::from(")]}".contains(next));
                        code.push(next);
                    }
                }
            }
            rest = rest.get(length..).unwrap_or_default();
        }
        has_code |= !code.trim().is_empty();
        let kind = match (is_documentation, has_code) {
            (true, _) => LineKind::Documentation,
            (false, true) => LineKind::Code,
            (false, false) => LineKind::Empty,
        };
        let names_testing = line.contains("\"testing\"");
        ScannedLine { kind, code: code.trim().to_owned(), depth, names_testing }
    };
    text.lines().map(scanned).collect()
}

/// Bytes of a letter between quotes, which begins here; a lifetime has no second one.
fn letter(text: &str) -> Option<usize> {
    let mut letters = text.char_indices().skip(1);
    let (_, first) = letters.next()?;
    let end = if first == '\\' { text[3..].find('\'').map(|at| at + 3) } else { letters.next().map(|(at, _)| at) };
    end.filter(|&at| text[at..].starts_with('\'')).map(|at| at + 1)
}

/// Lines of modules, items, fields and branches that are for tests, attributes included.
fn in_tests(lines: &[ScannedLine]) -> Vec<bool> {
    let is_attribute = |line: &ScannedLine| line.code.starts_with("#[") || line.kind == LineKind::Documentation;
    let mut marks = vec![false; lines.len()];
    if lines.iter().any(|line| line.code.starts_with("#![cfg(") && is_for_tests(line)) {
        marks.fill(true);
    }
    for (at, line) in lines.iter().enumerate() {
        if marks[at] || !line.code.starts_with("#[cfg(") || !is_for_tests(line) {
            continue;
        }
        let before = lines[..at].iter().rev().take_while(|line| is_attribute(line)).count();
        let first = at + lines[at..].iter().take_while(|line| is_attribute(line)).count();
        let is_value = lines.get(first).is_some_and(|line| {
            let word = line.code.trim_start_matches("pub").trim_start_matches("(crate)").trim_start();
            ["let ", "use ", "const ", "static ", "type "].iter().any(|value| word.starts_with(value))
                && !word.starts_with("const fn ")
        });
        let ends = |line: &ScannedLine| {
            line.depth <= lines[at].depth
                && (line.code.ends_with(';') || !is_value && (line.code.ends_with('}') || line.code.ends_with(',')))
        };
        let length = lines[first..].iter().position(ends).map_or(lines.len() - first, |end| end + 1);
        marks[at - before..first + length].fill(true);
    }
    marks
}

/// Whether the condition of a line names tests outside of `not`.
fn is_for_tests(line: &ScannedLine) -> bool {
    let condition = line.code.replace("not(test)", "");
    line.names_testing || condition.split(|c: char| !c.is_alphanumeric()).any(|word| word == "test")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn test_lines(text: &str) -> Vec<bool> {
        in_tests(&scan(text))
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
        let text = "#[cfg(test)]\nconst A: B =\n    B { c: r#\"\n}\n\"# }\n.d();\nfn h() {}\n";
        assert_eq!(test_lines(text), [true, true, true, true, true, true, false]);
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
    fn text_in_quotes_is_code_and_a_comment_is_nothing() {
        use LineKind::{Code, Documentation, Empty};
        let text = "//! Doc.\n/* a\nfn f() {}\n*/\n/// Doc.\nconst A: &str = \"\n// no comment\n\n/// nor this\n\"; // why\n// why\nm! { /// Doc.\n    a / b }\n";
        let kinds: Vec<_> = scan(text).into_iter().map(|line| line.kind).collect();
        let start = [Documentation, Empty, Empty, Empty, Documentation, Code, Code, Empty, Code, Code, Empty];
        assert_eq!(kinds, [start.as_slice(), &[Code, Code]].concat());
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
