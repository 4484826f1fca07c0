//! Names of types (structs, enums, unions, traits, aliases) that stand in more than one file of the
//! workspace: whoever searches for one finds two things. Tests are left out, and so are types that
//! belong to a trait's implementation.

use super::parsed::{ParsedFile, type_name};
use std::collections::{BTreeMap, BTreeSet};
use syn::visit::{self, Visit};

/// Names that may stand in several files, and why.
const ALLOWED: [(&str, &str); 1] =
    [("Arguments", "what clap reads of a subcommand's command line; each subcommand has its own, in its own file")];

pub fn find(files: &[ParsedFile]) -> Vec<String> {
    find_but(files, &ALLOWED)
}

fn find_but(files: &[ParsedFile], allowed: &[(&str, &str)]) -> Vec<String> {
    let mut places: BTreeMap<String, BTreeSet<&str>> = BTreeMap::new();
    for file in files.iter().filter(|file| !file.path.starts_with("tests/")) {
        let mut names = TypeNames::default();
        names.visit_file(&file.syntax);
        for name in names.0 {
            places.entry(name).or_default().insert(&file.path);
        }
    }
    places.retain(|_, files| files.len() > 1);
    let mut faults = Vec::new();
    for (name, why) in allowed {
        if places.remove(*name).is_none() {
            faults.push(format!(
                "{name} does not stand twice any more; take it off `ALLOWED` in tools/xtask/src/structure/type_names.rs ({why})"
            ));
        }
    }
    for (name, files) in places {
        let files: Vec<&str> = files.into_iter().collect();
        faults.push(format!("{name}: give each its own name: {}", files.join(", ")));
    }
    faults
}

#[derive(Default)]
struct TypeNames(BTreeSet<String>);

impl<'a> Visit<'a> for TypeNames {
    fn visit_item(&mut self, item: &'a syn::Item) {
        self.0.extend(type_name(item).map(ToString::to_string));
        visit::visit_item(self, item);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::parsed::testing::parsed;

    #[test]
    fn a_name_in_two_files_is_named_with_both() {
        let files = parsed(&[
            ("a/src/lib.rs", "struct Part; enum Once {} impl Iterator for Part { type Item = u8; }"),
            (
                "b/src/lib.rs",
                "mod inner { pub trait Part {} } struct Other; impl Iterator for Other { type Item = u8; }",
            ),
        ]);
        assert_eq!(find_but(&files, &[]), ["Part: give each its own name: a/src/lib.rs, b/src/lib.rs"]);
        assert_eq!(find_but(&files, &[("Part", "")]), [""; 0]);
    }

    #[test]
    fn one_file_may_have_a_name_twice_and_tests_have_their_own() {
        let files = parsed(&[
            ("a/src/lib.rs", "#[cfg(x)] type Word = u8; #[cfg(not(x))] type Word = u16;"),
            ("tests/src/lib.rs", "struct Word;"),
        ]);
        assert_eq!(find_but(&files, &[]), [""; 0]);
    }

    #[test]
    fn an_entry_of_the_list_that_is_not_needed_is_named() {
        let found = find_but(&parsed(&[("a/src/lib.rs", "struct Part;")]), &[("Part", "there were two")]);
        assert!(found[0].starts_with("Part does not stand twice any more"), "{found:?}");
    }
}
