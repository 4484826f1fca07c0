//! The modules of one crate: what each defines, imports and mentions, and which module a path leads
//! to in the end.
//!
//! A path is followed as the compiler does, through `use` and `pub use`, to the module that defines
//! the name. What only the compiler knows is not followed: methods, names that a macro makes up,
//! paths in texts (of serde). Imports inside of a function count as if they stood at the top of its
//! module.

use super::parsed::{ParsedFile, type_name};
use proc_macro2::{TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use syn::parse::discouraged::Speculative;
use syn::parse::{ParseStream, Parser};
use syn::visit::{self, Visit};

pub struct ModuleTree {
    /// The first one is the root.
    pub modules: Vec<ModuleContent>,
}

#[derive(Default)]
pub struct ModuleContent {
    /// The file that it stands in.
    pub file: String,
    parent: usize,
    children: BTreeMap<String, usize>,
    defined: BTreeSet<String>,
    pub imports: Vec<Import>,
    /// Paths that its code mentions.
    pub mentioned: BTreeSet<Vec<String>>,
}

pub struct Import {
    pub path: Vec<String>,
    /// What it is called here; `None` for all names of the path.
    pub name: Option<String>,
    pub is_reexport: bool,
}

/// Where a path leads.
#[derive(Clone, Debug, PartialEq)]
pub enum Destination {
    Module(usize),
    /// Anything else, and the module that defines it.
    Definition(usize, String),
}

impl ModuleTree {
    /// Reads the modules of the crate with this root file.
    pub fn read(root: &str, files: &BTreeMap<&str, &ParsedFile>) -> ModuleTree {
        let mut tree = ModuleTree { modules: Vec::new() };
        if let Some(file) = files.get(root) {
            tree.add(0, root, folder_of(root), &file.syntax.items, files);
        }
        tree
    }

    /// Adds a module of `items`, whose children lie in `folder`.
    fn add(
        &mut self,
        parent: usize,
        file: &str,
        folder: &str,
        items: &[syn::Item],
        files: &BTreeMap<&str, &ParsedFile>,
    ) -> usize {
        let index = self.modules.len();
        self.modules.push(ModuleContent { file: file.to_owned(), parent, ..ModuleContent::default() });
        for item in items {
            let syn::Item::Mod(module) = item else {
                self.modules[index].defined.extend(defined_name(item));
                self.modules[index].visit_item(item);
                continue;
            };
            let name = module.ident.to_string();
            let below = format!("{folder}/{name}");
            let child = match &module.content {
                Some((_, items)) => self.add(index, file, &below, items, files),
                None => {
                    let candidates = match path_attribute(&module.attrs) {
                        Some(path) => vec![joined(folder_of(file), &path)],
                        None => vec![format!("{below}.rs"), format!("{below}/mod.rs")],
                    };
                    let Some(found) = candidates.iter().find_map(|path| files.get(path.as_str())) else { continue };
                    self.add(index, &found.path, &below, &found.syntax.items, files)
                }
            };
            self.modules[index].children.insert(name, child);
        }
        index
    }

    /// Where a path leads that stands in module `from`. It may be several things of one name (a
    /// module and a function), or of another crate: nothing.
    pub fn resolve(&self, from: usize, path: &[String]) -> Vec<Destination> {
        self.follow(from, path, &mut BTreeSet::new())
    }

    fn follow(&self, from: usize, path: &[String], under_way: &mut BTreeSet<(usize, String)>) -> Vec<Destination> {
        let mut reached = vec![Destination::Module(from)];
        for (i, segment) in path.iter().enumerate() {
            let step = |at: &Destination| match (at, segment.as_str()) {
                (Destination::Definition(..), _) => vec![at.clone()],
                (Destination::Module(_), "crate") => vec![Destination::Module(0)],
                (Destination::Module(_), "self") => vec![at.clone()],
                (Destination::Module(module), "super") => vec![Destination::Module(self.modules[*module].parent)],
                (Destination::Module(module), name) => self.look_up(*module, name, under_way),
            };
            reached = reached.iter().flat_map(step).collect();
            // With more to come, a function or a constant is not meant.
            let modules: Vec<_> = reached.iter().filter(|at| matches!(at, Destination::Module(_))).cloned().collect();
            if i + 1 < path.len() && !modules.is_empty() {
                reached = modules;
            }
        }
        reached
    }

    fn look_up(&self, module: usize, name: &str, under_way: &mut BTreeSet<(usize, String)>) -> Vec<Destination> {
        let content = &self.modules[module];
        let mut found: Vec<_> =
            content.children.get(name).map(|&child| Destination::Module(child)).into_iter().collect();
        if content.defined.contains(name) {
            found.push(Destination::Definition(module, name.to_owned()));
        }
        // Imports may lead back to where they are asked for.
        if !under_way.insert((module, name.to_owned())) {
            return found;
        }
        for import in content.imports.iter().filter(|import| import.name.as_deref() == Some(name)) {
            found.extend(self.follow(module, &import.path, under_way));
        }
        if found.is_empty() {
            for import in content.imports.iter().filter(|import| import.name.is_none()) {
                for target in self.follow(module, &import.path, under_way) {
                    if let Destination::Module(target) = target {
                        found.extend(self.look_up(target, name, under_way));
                    }
                }
            }
        }
        under_way.remove(&(module, name.to_owned()));
        found
    }
}

impl<'a> Visit<'a> for ModuleContent {
    fn visit_item_use(&mut self, item: &'a syn::ItemUse) {
        if item.leading_colon.is_none() {
            self.add_imports(&[], &item.tree, !matches!(item.vis, syn::Visibility::Inherited));
        }
    }

    fn visit_path(&mut self, path: &'a syn::Path) {
        if path.leading_colon.is_none() {
            self.mentioned.insert(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        }
        visit::visit_path(self, path);
    }

    /// What a macro is given is no syntax yet: whatever can be read as a path is taken for one.
    fn visit_token_stream(&mut self, tokens: &'a TokenStream) {
        let mut found = Vec::new();
        // Tokens can always be read on, so this cannot fail.
        let _ = (|input: ParseStream| paths(input, &mut found)).parse2(tokens.clone());
        found.iter().for_each(|path| self.visit_expr_path(path));
    }
}

fn paths(input: ParseStream, found: &mut Vec<syn::ExprPath>) -> syn::Result<()> {
    while !input.is_empty() {
        let ahead = input.fork();
        if let Ok(path) = ahead.parse() {
            input.advance_to(&ahead);
            found.push(path);
        } else if let TokenTree::Group(group) = input.parse()? {
            (|input: ParseStream| paths(input, found)).parse2(group.stream())?;
        }
    }
    Ok(())
}

impl ModuleContent {
    fn add_imports(&mut self, path: &[String], tree: &syn::UseTree, is_reexport: bool) {
        let with = |name: &syn::Ident| [path, &[name.to_string()]].concat();
        let (path, name) = match tree {
            syn::UseTree::Path(inner) => return self.add_imports(&with(&inner.ident), &inner.tree, is_reexport),
            syn::UseTree::Group(group) => {
                return group.items.iter().for_each(|tree| self.add_imports(path, tree, is_reexport));
            }
            // `use a::{self}` is called `a`.
            syn::UseTree::Name(leaf) if leaf.ident == "self" => (path.to_vec(), path.last().cloned()),
            syn::UseTree::Name(leaf) => (with(&leaf.ident), Some(leaf.ident.to_string())),
            syn::UseTree::Rename(leaf) => (with(&leaf.ident), Some(leaf.rename.to_string())),
            syn::UseTree::Glob(_) => (path.to_vec(), None),
        };
        self.imports.push(Import { path, name, is_reexport });
    }
}

fn defined_name(item: &syn::Item) -> Option<String> {
    let name = match item {
        syn::Item::Const(item) => &item.ident,
        syn::Item::Fn(item) => &item.sig.ident,
        syn::Item::Macro(item) => item.ident.as_ref()?,
        syn::Item::Static(item) => &item.ident,
        _ => type_name(item)?,
    };
    Some(name.to_string())
}

/// The value of `#[path = "…"]`.
fn path_attribute(attributes: &[syn::Attribute]) -> Option<String> {
    let attribute = attributes.iter().find(|attribute| attribute.path().is_ident("path"))?;
    match &attribute.meta.require_name_value().ok()?.value {
        syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(text), .. }) => Some(text.value()),
        _ => None,
    }
}

fn folder_of(path: &str) -> &str {
    path.rsplit_once('/').map_or("", |(folder, _)| folder)
}

fn joined(folder: &str, path: &str) -> String {
    match path.strip_prefix("../") {
        Some(rest) => joined(folder_of(folder), rest),
        None => format!("{folder}/{path}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::parsed::testing::parsed;

    fn tree(files: &[(&str, &str)]) -> ModuleTree {
        let parsed = parsed(files);
        ModuleTree::read(files[0].0, &parsed.iter().map(|file| (file.path.as_str(), file)).collect())
    }

    fn file_of(tree: &ModuleTree, path: &str) -> Vec<String> {
        let path: Vec<String> = path.split("::").map(str::to_owned).collect();
        let file = |to: &Destination| match to {
            Destination::Module(module) => format!("module {}", tree.modules[*module].file),
            Destination::Definition(module, name) => format!("{name} {}", tree.modules[*module].file),
        };
        tree.resolve(0, &path).iter().map(file).collect()
    }

    #[test]
    fn a_name_is_followed_through_reexports_renames_and_globs_to_where_it_is_defined() {
        let tree = tree(&[
            ("a/src/lib.rs", "mod b; pub use b::*; use b::Deep as Shallow; use self::b::{c as d, Deep};"),
            ("a/src/b/mod.rs", "pub mod c; pub use c::Deep; pub use super::b::c::work; pub fn own() {}"),
            ("a/src/b/c.rs", "pub struct Deep; pub fn work() {} pub enum Kind { One }"),
        ]);
        for path in ["b::Deep", "Shallow", "crate::b::c::Deep", "self::Deep", "d::Deep", "b::Deep::new"] {
            assert_eq!(file_of(&tree, path), ["Deep a/src/b/c.rs"], "{path}");
        }
        assert_eq!(file_of(&tree, "work"), ["work a/src/b/c.rs"]);
        assert_eq!(file_of(&tree, "own"), ["own a/src/b/mod.rs"]);
        assert_eq!(file_of(&tree, "d::Kind::One"), ["Kind a/src/b/c.rs"]);
        assert_eq!(file_of(&tree, "b::c"), ["module a/src/b/c.rs"]);
        assert_eq!(file_of(&tree, "std::fmt::Display"), [""; 0]);
    }

    #[test]
    fn a_module_and_a_function_of_one_name_are_both_found() {
        let tree = tree(&[
            ("a/src/lib.rs", "mod work; pub use work::work;"),
            ("a/src/work.rs", "pub fn work() {} fn help() {}"),
        ]);
        assert_eq!(file_of(&tree, "work"), ["module a/src/work.rs", "work a/src/work.rs"]);
        assert_eq!(file_of(&tree, "work::help"), ["help a/src/work.rs"]);
    }

    #[test]
    fn imports_in_a_ring_lead_nowhere() {
        let tree = tree(&[("a/src/lib.rs", "mod b { pub use super::c::*; } mod c { pub use super::b::*; } use b::X;")]);
        assert_eq!(file_of(&tree, "X"), [""; 0]);
    }

    #[test]
    fn modules_lie_where_the_compiler_looks_for_them() {
        let tree = tree(&[
            ("a/src/bin/b.rs", "#[path = \"../halt.rs\"] mod halt; mod inner { pub mod c; } mod d;"),
            ("a/src/halt.rs", "pub fn halt() {}"),
            ("a/src/bin/inner/c.rs", "pub fn c() {}"),
            ("a/src/bin/d.rs", "pub mod e;"),
            ("a/src/bin/d/e.rs", "pub fn e() {}"),
        ]);
        assert_eq!(file_of(&tree, "halt::halt"), ["halt a/src/halt.rs"]);
        assert_eq!(file_of(&tree, "inner::c::c"), ["c a/src/bin/inner/c.rs"]);
        assert_eq!(file_of(&tree, "d::e::e"), ["e a/src/bin/d/e.rs"]);
    }

    #[test]
    fn what_macros_are_given_is_searched_for_paths() {
        let tree = tree(&[("a/src/lib.rs", "fn f() { print!(\"{}\", [crate::b::c, x::y::<u8>(z)]); }")]);
        let mentioned = &tree.modules[0].mentioned;
        for path in [["crate", "b", "c"].as_slice(), &["x", "y"], &["z"]] {
            assert!(mentioned.contains(&path.iter().map(|&name| name.to_owned()).collect::<Vec<_>>()), "{path:?}");
        }
    }
}
