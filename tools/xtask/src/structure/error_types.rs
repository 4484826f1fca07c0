//! Errors that are texts: `Result<_, String>` and `Result<_, &str>` in the code of libraries.
//! Whoever calls cannot tell them from any other text.

use super::parsed::ParsedFile;
use syn::visit::{self, Visit};

/// Crates that are no libraries: whoever calls them reads the text.
const TOOLS: [&str; 3] = ["xtask/", "image-analysis/", "tests/"];

pub fn find(files: &[ParsedFile]) -> Vec<String> {
    let judged = files.iter().filter(|file| !TOOLS.iter().any(|folder| file.path.starts_with(folder)));
    judged
        .flat_map(|file| {
            let mut lines = ResultsOfText(Vec::new());
            lines.visit_file(&file.syntax);
            lines
                .0
                .into_iter()
                .map(|line| format!("{}:{line}: give the error a type of its own, with thiserror", file.path))
        })
        .collect()
}

/// The lines that they stand in.
struct ResultsOfText(Vec<usize>);

impl<'a> Visit<'a> for ResultsOfText {
    fn visit_path_segment(&mut self, segment: &'a syn::PathSegment) {
        if segment.ident == "Result"
            && let syn::PathArguments::AngleBracketed(arguments) = &segment.arguments
            && let Some(syn::GenericArgument::Type(error)) = arguments.args.iter().nth(1)
            && is_text(error)
        {
            self.0.push(segment.ident.span().start().line);
        }
        visit::visit_path_segment(self, segment);
    }
}

fn is_text(error: &syn::Type) -> bool {
    match error {
        syn::Type::Path(path) => path.path.segments.last().is_some_and(|last| last.ident == "String"),
        syn::Type::Reference(reference) => {
            matches!(&*reference.elem, syn::Type::Path(path) if path.path.is_ident("str"))
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::parsed::testing::parsed;

    #[test]
    fn texts_as_errors_are_found_wherever_they_stand() {
        let text = "fn f() -> Result<u8, String> { g(|x| -> std::result::Result<(), &'static str> { Ok(x) }) }\n\
                    type R<T> = Result<T, std::string::String>;\nfn h() -> Result<String, E> { k::<Result<String, u8>>() }\n\
                    fn m() -> Vec<Result<u8, String>> {}";
        let found = find(&parsed(&[("crates/plot/src/lib.rs", text)]));
        let lines: Vec<_> = found.iter().map(|fault| fault.split(':').nth(1)).collect();
        assert_eq!(lines, [Some("1"), Some("1"), Some("2"), Some("4")]);
    }

    #[test]
    fn tools_may_have_texts_as_errors() {
        assert!(find(&parsed(&[("tools/xtask/src/main.rs", "fn f() -> Result<u8, String> {}")])).is_empty());
    }
}
