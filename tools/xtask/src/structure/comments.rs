//! Comments that are wider than a page: lines of comment alone, indentation included. Rows of
//! tables and lines with an address of the web cannot be broken, and are let through in
//! documentation.

use crate::sources::RustFile;

const WIDEST: usize = 100;

pub fn find(files: &[RustFile]) -> Vec<String> {
    let long = |file: &RustFile| {
        let lines = file.text.lines().enumerate().filter(|(_, line)| is_too_long(line));
        let fault = |(i, line): (usize, &str)| {
            format!("{}:{}: {} columns, {WIDEST} are allowed: wrap it", file.path, i + 1, line.chars().count())
        };
        lines.map(fault).collect::<Vec<_>>()
    };
    files.iter().flat_map(long).collect()
}

fn is_too_long(line: &str) -> bool {
    let comment = line.trim_start();
    let documentation = comment.strip_prefix("///").or(comment.strip_prefix("//!"));
    let unbreakable = |text: &str| text.trim_start().starts_with('|') || text.contains("://");
    comment.starts_with("//") && line.chars().count() > WIDEST && !documentation.is_some_and(unbreakable)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_counted_and_not_bytes_and_code_may_be_wider() {
        let wide = |start: &str| start.to_owned() + &"ä".repeat(WIDEST - start.len());
        for start in ["// ", "    /// ", "//! "] {
            assert!(!is_too_long(&wide(start)), "{start}");
            assert!(is_too_long(&(wide(start) + "ä")), "{start}");
        }
        assert!(!is_too_long(&(wide("let x = 1; // ") + "ä")));
    }

    #[test]
    fn tables_and_addresses_are_let_through_in_documentation_only() {
        let rest = "x".repeat(WIDEST);
        assert!(!is_too_long(&format!("/// | {rest} |")));
        assert!(!is_too_long(&format!("//! see https://example.org/{rest}")));
        assert!(is_too_long(&format!("// | {rest} |")));
        let text = format!("fn f() {{}}\n// {rest}\n");
        let file = RustFile {
            path: "a/src/lib.rs".into(),
            crate_folder: "a".into(),
            text,
            in_tests: Vec::new(),
            kinds: Vec::new(),
        };
        assert_eq!(find(&[file]), ["a/src/lib.rs:2: 103 columns, 100 are allowed: wrap it"]);
    }
}
