//! Circles of imports between the files of a crate.
//!
//! A file depends on another one if it mentions a name that the other one defines. A `mod.rs` that
//! declares its children and hands on their names depends on nothing and nothing on it: names are
//! followed to the file that defines them. A trait counts when it is imported. Files of which each
//! depends on each, by whatever way, are a circle.

use super::modules::{Destination, ModuleTree};
use super::parsed::ParsedFile;
use std::collections::{BTreeMap, BTreeSet};

/// Of each file, those that it depends on and the names that tie it to them.
type FileTies = BTreeMap<String, BTreeMap<String, BTreeSet<String>>>;

pub fn find(files: &[ParsedFile]) -> Vec<String> {
    let by_path: BTreeMap<&str, &ParsedFile> = files.iter().map(|file| (file.path.as_str(), file)).collect();
    let mut ties = FileTies::new();
    for root in by_path.keys().filter(|path| is_root(path)) {
        add_ties(&ModuleTree::read(root, &by_path), &mut ties);
    }
    circles(&ties).iter().map(|circle| describe(circle, &ties)).collect()
}

/// Whether a file is the root of a library or of a binary.
fn is_root(path: &str) -> bool {
    let parts: Vec<&str> = path.split('/').collect();
    matches!(parts[..], [.., "src", "lib.rs" | "main.rs"] | [.., "src", "bin", _])
}

fn add_ties(tree: &ModuleTree, ties: &mut FileTies) {
    for (index, module) in tree.modules.iter().enumerate() {
        let imported = module.imports.iter().filter(|import| !import.is_reexport).map(|import| &import.path);
        for path in imported.chain(&module.mentioned) {
            for destination in tree.resolve(index, path) {
                let Destination::Definition(owner, name) = destination else { continue };
                let owner = &tree.modules[owner].file;
                if *owner != module.file {
                    ties.entry(module.file.clone()).or_default().entry(owner.clone()).or_default().insert(name);
                }
            }
        }
    }
}

/// Of every circle, all files that depend on each other.
fn circles(ties: &FileTies) -> BTreeSet<BTreeSet<&String>> {
    let next = |file: &String| ties.get(file).into_iter().flat_map(BTreeMap::keys);
    let reached_from = |start: &String| {
        let (mut reached, mut left) = (BTreeSet::new(), Vec::from_iter(next(start)));
        while let Some(file) = left.pop() {
            if reached.insert(file) {
                left.extend(next(file));
            }
        }
        reached
    };
    let reached: BTreeMap<&String, BTreeSet<&String>> = ties.keys().map(|from| (from, reached_from(from))).collect();
    let leads_back = |from: &String, to: &String| reached.get(to).is_some_and(|back| back.contains(from));
    let mut circles = BTreeSet::new();
    for (from, to) in &reached {
        let circle: BTreeSet<&String> = to.iter().copied().filter(|to| leads_back(from, to)).collect();
        if !circle.is_empty() {
            circles.insert(circle);
        }
    }
    circles
}

fn describe(circle: &BTreeSet<&String>, ties: &FileTies) -> String {
    let mut text = format!(
        "{} files import each other in a circle; move what both sides need into a file of its own, or hand it over as an argument:",
        circle.len()
    );
    for (from, tos) in ties.iter().filter(|(from, _)| circle.contains(from)) {
        for (to, names) in tos.iter().filter(|(to, _)| circle.contains(to)) {
            let names = names.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
            text.push_str(&format!("\n      {from} → {to}: {names}"));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::parsed::testing::parsed;

    fn found(files: &[(&str, &str)]) -> Vec<String> {
        find(&parsed(files))
    }

    #[test]
    fn two_files_that_import_each_other_are_a_circle_with_the_names_that_tie_them() {
        let circles = found(&[
            ("x/src/lib.rs", "mod a; mod b;"),
            ("x/src/a.rs", "use crate::b::B; pub struct A;"),
            ("x/src/b.rs", "pub struct B; fn f() { let _ = super::a::A; }"),
        ]);
        assert_eq!(circles.len(), 1);
        assert!(circles[0].starts_with("2 files import each other in a circle"), "{circles:?}");
        assert!(circles[0].contains("x/src/a.rs → x/src/b.rs: B\n"), "{circles:?}");
        assert!(circles[0].ends_with("x/src/b.rs → x/src/a.rs: A"), "{circles:?}");
    }

    #[test]
    fn a_mod_rs_that_only_hands_on_names_is_in_no_circle() {
        let files = [
            ("x/src/lib.rs", "mod a;"),
            ("x/src/a/mod.rs", "mod b; mod c; pub use b::B; pub(crate) use c::C;"),
            ("x/src/a/b.rs", "use super::C; pub struct B(C);"),
            ("x/src/a/c.rs", "pub struct C;"),
        ];
        assert_eq!(found(&files), [""; 0]);
    }

    #[test]
    fn a_mod_rs_that_uses_a_child_which_uses_its_definitions_is_in_a_circle() {
        let circles = found(&[
            ("x/src/main.rs", "mod a;"),
            ("x/src/a/mod.rs", "mod b; pub struct Fault; fn f() { b::work() }"),
            ("x/src/a/b.rs", "use super::*; pub fn work() -> Fault { Fault }"),
        ]);
        assert_eq!(circles.len(), 1, "{circles:?}");
        assert!(circles[0].contains("x/src/a/mod.rs → x/src/a/b.rs: work"), "{circles:?}");
        assert!(circles[0].contains("x/src/a/b.rs → x/src/a/mod.rs: Fault"), "{circles:?}");
    }

    #[test]
    fn a_circle_behind_a_facade_and_of_three_is_found() {
        let circles = found(&[
            ("x/src/lib.rs", "mod f; mod c;"),
            ("x/src/f/mod.rs", "mod a; mod b; pub use a::A; pub use b::B;"),
            ("x/src/f/a.rs", "use super::B; pub struct A(B);"),
            ("x/src/f/b.rs", "use crate::c::C; pub struct B(C);"),
            ("x/src/c.rs", "use crate::f; pub struct C; fn g() -> Option<f::A> { None }"),
        ]);
        assert_eq!(circles.len(), 1, "{circles:?}");
        assert!(circles[0].starts_with("3 files"), "{circles:?}");
    }

    #[test]
    fn two_crates_are_two_trees_and_a_binary_may_use_its_library() {
        let files = [
            ("x/src/lib.rs", "pub mod a; pub struct X;"),
            ("x/src/a.rs", "use y::Y; pub struct A;"),
            ("x/src/main.rs", "use x::a::A; struct Y;"),
            ("y/src/lib.rs", "use x::a::A; pub struct Y;"),
        ];
        assert_eq!(found(&files), [""; 0]);
    }
}
