//! Rust files of a workspace: their crates, and which of their lines are code, documentation, tests.
//!
//! Tests are: files in a crate's folders `tests`, `benches` and `examples`, in any folder `tests` of
//! its sources, and files called `tests.rs`; modules and items whose `cfg` names `test` or the
//! feature `testing`, outside of `not`.

use anyhow::{Context, Result, anyhow};
use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::path::{Path, PathBuf};
use std::str::FromStr;

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
    mark(&mut files)?;
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

fn mark(files: &mut [RustFile]) -> Result<()> {
    let mut test_modules = Vec::new();
    for file in &mut *files {
        let mut marks = Marks::new(&file.text);
        let tokens = TokenStream::from_str(&file.text);
        marks.read(tokens.map_err(|error| anyhow!("{} cannot be read: {error}", file.path))?);
        let path = file.path.trim_end_matches(".rs");
        let folder = ["/mod", "/lib", "/main"].iter().find_map(|root| path.strip_suffix(root)).unwrap_or(path);
        test_modules.extend(marks.test_modules.iter().map(|name| format!("{folder}/{name}")));
        (file.in_tests, file.kinds) = (marks.in_tests, marks.kinds);
    }
    for file in files {
        let is_below =
            |module: &String| file.path.strip_prefix(module).is_some_and(|rest| rest.starts_with(['.', '/']));
        let in_test_folder = file.inner_path().split('/').any(|part| part == "tests" || part == "tests.rs");
        if in_test_folder || file.is_example() || test_modules.iter().any(is_below) {
            file.in_tests.fill(true);
        }
    }
    Ok(())
}

/// What is found out about the lines of a file.
struct Marks<'a> {
    lines: Vec<&'a str>,
    in_tests: Vec<bool>,
    kinds: Vec<LineKind>,
    /// Names of modules in files of their own that are there for tests only.
    test_modules: Vec<String>,
}

impl Marks<'_> {
    fn new(text: &str) -> Marks<'_> {
        let lines: Vec<&str> = text.lines().collect();
        let (in_tests, kinds) = (vec![false; lines.len()], vec![LineKind::Empty; lines.len()]);
        Marks { lines, in_tests, kinds, test_modules: Vec::new() }
    }

    /// Marks the lines of these tokens and of those in the brackets among them.
    fn read(&mut self, tokens: TokenStream) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let is_inner = |tokens: &[TokenTree]| is_mark(&tokens[1], '!') && is_for_tests(&tokens[0], &tokens[2]);
        if tokens.windows(3).any(is_inner) {
            self.mark_tests(&tokens);
        }
        let mut end_of_tests = 0;
        for (at, token) in tokens.iter().enumerate() {
            let attributes = tokens[at..].chunks_exact(2).take_while(|pair| is_attribute(&pair[0], &pair[1]));
            if at >= end_of_tests && attributes.clone().any(|pair| is_for_tests(&pair[0], &pair[1])) {
                let attributes = 2 * attributes.count();
                end_of_tests = at + attributes + item_length(&tokens[at + attributes..]);
                self.mark_tests(&tokens[at..end_of_tests]);
                if let [.., word, TokenTree::Ident(name), end] = &tokens[at..end_of_tests]
                    && is_word(word, "mod")
                    && is_mark(end, ';')
                {
                    self.test_modules.push(name.to_string());
                }
            }
            self.mark_kind(token);
        }
    }

    fn mark_tests(&mut self, tokens: &[TokenTree]) {
        if let [first, .., last] = tokens {
            self.in_tests[first.span().start().line - 1..last.span().end().line].fill(true);
        }
    }

    fn mark_kind(&mut self, token: &TokenTree) {
        let (start, end) = (token.span().start(), token.span().end());
        // A comment of documentation is read as an attribute that stands in its place.
        let source: String = self.lines[start.line - 1].chars().skip(start.column).take(2).collect();
        let kind = if ["//", "/*"].contains(&source.as_str()) { LineKind::Documentation } else { LineKind::Code };
        match token {
            TokenTree::Group(group) if kind == LineKind::Code => {
                self.kinds[start.line - 1] = kind;
                self.kinds[end.line - 1] = kind;
                self.read(group.stream());
            }
            _ => {
                for line in start.line - 1..end.line {
                    if self.kinds[line] != LineKind::Code && !self.lines[line].trim().is_empty() {
                        self.kinds[line] = kind;
                    }
                }
            }
        }
    }
}

fn is_mark(token: &TokenTree, mark: char) -> bool {
    matches!(token, TokenTree::Punct(own) if own.as_char() == mark)
}

fn is_word(token: &TokenTree, word: &str) -> bool {
    matches!(token, TokenTree::Ident(own) if own == word)
}

fn is_attribute(mark: &TokenTree, group: &TokenTree) -> bool {
    is_mark(mark, '#') && matches!(group, TokenTree::Group(group) if group.delimiter() == Delimiter::Bracket)
}

/// Whether these are `#` and a `[cfg(…)]` that names tests.
fn is_for_tests(mark: &TokenTree, group: &TokenTree) -> bool {
    let TokenTree::Group(attribute) = group else { return false };
    let tokens: Vec<TokenTree> = attribute.stream().into_iter().collect();
    is_mark(mark, '#') && tokens.first().is_some_and(|name| is_word(name, "cfg")) && names_tests(&tokens)
}

fn names_tests(tokens: &[TokenTree]) -> bool {
    let is_negated = |at: usize| at > 0 && is_word(&tokens[at - 1], "not");
    tokens.iter().enumerate().any(|(at, token)| match token {
        TokenTree::Group(group) => !is_negated(at) && names_tests(&group.stream().into_iter().collect::<Vec<_>>()),
        TokenTree::Literal(literal) => literal.to_string() == "\"testing\"",
        token => is_word(token, "test"),
    })
}

/// Number of tokens of an item, a field, a variant or a branch: up to its semicolon, its comma or
/// the brace of its body.
fn item_length(tokens: &[TokenTree]) -> usize {
    let word = tokens.iter().find_map(|token| match token {
        TokenTree::Ident(word) if word != "pub" => Some(word.to_string()),
        _ => None,
    });
    let is_value = matches!(word.as_deref(), Some("let" | "use" | "const" | "static" | "type"))
        && !tokens.iter().take(4).any(|token| is_word(token, "fn"));
    let is_item = ["fn", "mod", "struct", "enum", "union", "impl", "trait", "unsafe", "async", "extern", "const"];
    let may_have_comma = word.is_some_and(|word| is_item.contains(&word.as_str()));
    let is_brace =
        |token: &TokenTree| matches!(token, TokenTree::Group(group) if group.delimiter() == Delimiter::Brace);
    let ends = |&at: &usize| {
        let is_followed = tokens.get(at + 1).is_some_and(|next| is_mark(next, ';') || is_mark(next, ','));
        is_mark(&tokens[at], ';')
            || !is_value && is_brace(&tokens[at]) && !is_followed
            || !is_value && !may_have_comma && is_mark(&tokens[at], ',')
    };
    (0..tokens.len()).find(ends).map_or(tokens.len(), |at| at + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn test_lines(text: &str) -> Vec<bool> {
        let mut marks = Marks::new(text);
        marks.read(TokenStream::from_str(text).expect("Rust"));
        marks.in_tests
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
        let mut marks = Marks::new(text);
        marks.read(TokenStream::from_str(text).expect("Rust"));
        let start = [Documentation, Empty, Empty, Empty, Documentation, Code, Code, Empty, Code, Code, Empty];
        assert_eq!(marks.kinds, [start.as_slice(), &[Code, Code]].concat());
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
        mark(&mut files).expect("Rust");
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
