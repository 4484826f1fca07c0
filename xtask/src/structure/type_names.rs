//! Names of types (structs, enums, unions, traits, aliases) that stand in more than one file of the
//! workspace: whoever searches for one finds two things. Tests are left out, and so are types that
//! belong to a trait's implementation.

use super::parsed::ParsedFile;
use std::collections::{BTreeMap, BTreeSet};
use syn::visit::{self, Visit};

/// Names that may stand in several files of one folder.
struct Alike<'a> {
    folder: &'a str,
    /// None: all.
    names: &'a [&'a str],
    why: &'a str,
}

const ALLOWED: [Alike; 1] = [Alike {
    folder: "",
    names: &["Arguments"],
    why: "what clap reads of a subcommand's command line; each subcommand has its own, in its own file",
}];

impl Alike<'_> {
    fn covers(&self, name: &str, file: &str) -> bool {
        file.starts_with(self.folder) && (self.names.is_empty() || self.names.contains(&name))
    }
}

pub fn find(files: &[ParsedFile]) -> Vec<String> {
    find_but(files, &ALLOWED)
}

/// All files of a folder that may have a name alike count as one.
fn find_but(files: &[ParsedFile], allowed: &[Alike]) -> Vec<String> {
    let mut places: BTreeMap<String, BTreeSet<&str>> = BTreeMap::new();
    for file in files.iter().filter(|file| !file.is_for_tests) {
        let mut names = TypeNames::default();
        names.visit_file(&file.syntax);
        for name in names.0 {
            places.entry(name).or_default().insert(&file.path);
        }
    }
    let mut needed = vec![false; allowed.len()];
    let mut faults = Vec::new();
    for (name, files) in &places {
        let mut left: Vec<&str> = files.iter().copied().collect();
        for (alike, needed) in allowed.iter().zip(&mut needed) {
            let covered: BTreeSet<&str> =
                left.iter().copied().filter(|file| alike.covers(name, file)).skip(1).collect();
            *needed |= !covered.is_empty();
            left.retain(|file| !covered.contains(file));
        }
        if left.len() > 1 {
            faults.push(format!("{name}: give each its own name: {}", left.join(", ")));
        }
    }
    for (alike, _) in allowed.iter().zip(needed).filter(|(_, needed)| !needed) {
        let (names, folder, why) = (alike.names.join(", "), alike.folder, alike.why);
        faults.push(format!(
            "nothing stands twice any more of what `ALLOWED` in xtask/src/structure/type_names.rs lets through ({names} {folder}: {why}): delete the entry"
        ));
    }
    faults
}

#[derive(Default)]
struct TypeNames(BTreeSet<String>);

impl<'a> Visit<'a> for TypeNames {
    fn visit_item(&mut self, item: &'a syn::Item) {
        let name = match item {
            syn::Item::Enum(item) => Some(&item.ident),
            syn::Item::Struct(item) => Some(&item.ident),
            syn::Item::Trait(item) => Some(&item.ident),
            syn::Item::Type(item) => Some(&item.ident),
            syn::Item::Union(item) => Some(&item.ident),
            _ => None,
        };
        self.0.extend(name.map(ToString::to_string));
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
        assert_eq!(find_but(&files, &[Alike { folder: "", names: &["Part"], why: "" }]), [""; 0]);
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
    fn files_of_a_folder_may_be_alike_and_still_differ_from_others() {
        let files = parsed(&[
            ("a/src/x/b.rs", "struct Part;"),
            ("a/src/x/c.rs", "struct Part; struct Other;"),
            ("d/src/lib.rs", "struct Part; struct Other;"),
        ]);
        let found = find_but(&files, &[Alike { folder: "a/src/x/", names: &[], why: "" }]);
        assert_eq!(found[0], "Other: give each its own name: a/src/x/c.rs, d/src/lib.rs");
        assert_eq!(found[1..], ["Part: give each its own name: a/src/x/b.rs, d/src/lib.rs"]);
    }

    #[test]
    fn an_entry_of_the_list_that_is_not_needed_is_named() {
        let allowed = [Alike { folder: "", names: &["Part"], why: "there were two" }];
        let found = find_but(&parsed(&[("a/src/lib.rs", "struct Part;")]), &allowed);
        assert!(found[0].ends_with("(Part : there were two): delete the entry"), "{found:?}");
    }
}
