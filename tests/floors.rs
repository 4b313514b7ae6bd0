//! The house stands: five floors, imports go down only, and nothing imports in a circle.
//!
//! The test reads every path in `src/`, follows re-exports to the file that defines the name, and
//! leaves out what is compiled for tests only.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use syn::visit::{self, Visit};
use syn::{Attribute, File, Item, UseTree};

const FLOORS: [&str; 5] = ["core", "io", "observe", "tools", "cli"];

type Module = Vec<String>;

/// One file of `src/`: the paths that it names, and which of them it hands on.
struct Source {
    paths: Vec<Vec<String>>,
    handed_on: BTreeMap<String, Vec<String>>,
}

struct House {
    files: BTreeMap<Module, Source>,
}

/// An import: the file that has it, and the file that it leads to.
type Arrow = (Module, Module);

impl House {
    fn read() -> Self {
        let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
        let mut house = Self {
            files: BTreeMap::new(),
        };
        house.add(&src.join("lib.rs"), &src, Vec::new());
        house
    }

    /// Adds a file and the files of its modules, which stand in `folder`.
    fn add(&mut self, path: &Path, folder: &Path, module: Module) {
        let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let file = syn::parse_file(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        for item in &file.items {
            if let Item::Mod(child) = item
                && child.content.is_none()
                && !for_tests(&child.attrs)
            {
                let name = child.ident.to_string();
                let below = [module.clone(), vec![name.clone()]].concat();
                self.add(
                    &folder.join(format!("{name}.rs")),
                    &folder.join(&name),
                    below,
                );
            }
        }
        let mut reader = Reader {
            module: &module,
            paths: Vec::new(),
            handed_on: BTreeMap::new(),
        };
        reader.visit_file(&file);
        let Reader {
            paths, handed_on, ..
        } = reader;
        self.files.insert(module, Source { paths, handed_on });
    }

    fn arrows(&self) -> BTreeSet<Arrow> {
        let mut arrows = BTreeSet::new();
        for (module, source) in &self.files {
            for path in &source.paths {
                let to = self.defined_in(path, 0);
                arrows.extend(to.filter(|to| to != module).map(|to| (module.clone(), to)));
            }
        }
        arrows
    }

    /// The file that defines what a path from the root names.
    fn defined_in(&self, path: &[String], depth: usize) -> Option<Module> {
        let modules = (0..=path.len()).rev().map(|n| &path[..n]);
        let module = modules
            .into_iter()
            .find(|start| self.files.contains_key(*start))?;
        let rest = &path[module.len()..];
        let handed_on = rest
            .first()
            .and_then(|name| self.files[module].handed_on.get(name));
        match handed_on {
            Some(target) if depth < 8 => {
                self.defined_in(&[target.as_slice(), &rest[1..]].concat(), depth + 1)
            }
            _ if module.is_empty() && !path.is_empty() => None,
            _ => Some(module.to_vec()),
        }
    }
}

struct Reader<'a> {
    module: &'a Module,
    paths: Vec<Vec<String>>,
    handed_on: BTreeMap<String, Vec<String>>,
}

impl Reader<'_> {
    /// A path as it is written, from the root of the crate.
    fn absolute(&self, written: &[String]) -> Vec<String> {
        let mut from = self.module.clone();
        let mut rest = written;
        while let Some((first, others)) = rest.split_first() {
            match first.as_str() {
                "crate" | "tmam_replay" => from.clear(),
                "self" => {}
                "super" => drop(from.pop()),
                _ => break,
            }
            rest = others;
        }
        [from.as_slice(), rest].concat()
    }

    fn take_use(&mut self, tree: &UseTree, before: &mut Vec<String>, public: bool) {
        let mut take = |before: &[String], name: &str, known_as: &str| {
            let mut written = before.to_vec();
            if name != "self" {
                written.push(name.to_owned());
            }
            let path = self.absolute(&written);
            if public {
                self.handed_on.insert(known_as.to_owned(), path.clone());
            }
            self.paths.push(path);
        };
        match tree {
            UseTree::Path(path) => {
                before.push(path.ident.to_string());
                self.take_use(&path.tree, before, public);
                before.pop();
            }
            UseTree::Name(name) => take(before, &name.ident.to_string(), &name.ident.to_string()),
            UseTree::Rename(name) => {
                take(before, &name.ident.to_string(), &name.rename.to_string());
            }
            UseTree::Glob(_) => self.paths.push(self.absolute(before)),
            UseTree::Group(group) => {
                for tree in &group.items {
                    self.take_use(tree, before, public);
                }
            }
        }
    }
}

impl<'a> Visit<'a> for Reader<'_> {
    fn visit_file(&mut self, file: &'a File) {
        file.items.iter().for_each(|item| self.visit_item(item));
    }

    fn visit_item(&mut self, item: &'a Item) {
        if let Item::Use(it) = item
            && !for_tests(&it.attrs)
        {
            let public = !matches!(it.vis, syn::Visibility::Inherited);
            self.take_use(&it.tree, &mut Vec::new(), public);
        }
        let attributes: &[Attribute] = match item {
            Item::Fn(it) => &it.attrs,
            Item::Impl(it) => &it.attrs,
            Item::Mod(it) => &it.attrs,
            Item::Struct(it) => &it.attrs,
            _ => &[],
        };
        if !for_tests(attributes) && !matches!(item, Item::Use(_)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_path(&mut self, path: &'a syn::Path) {
        let written: Vec<String> = path.segments.iter().map(|s| s.ident.to_string()).collect();
        if written.len() > 1 && path.leading_colon.is_none() {
            self.paths.push(self.absolute(&written));
        }
        visit::visit_path(self, path);
    }
}

fn for_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let list = attribute.meta.require_list();
        attribute.path().is_ident("cfg") && list.is_ok_and(|l| l.tokens.to_string() == "test")
    })
}

fn floor(module: &Module) -> usize {
    let name = module.first().map_or("", String::as_str);
    FLOORS
        .iter()
        .position(|floor| *floor == name)
        .unwrap_or(FLOORS.len())
}

fn name(module: &Module) -> String {
    if module.is_empty() {
        "lib".to_owned()
    } else {
        module.join("::")
    }
}

/// The groups of nodes that reach each other.
fn circles<T: Ord + Clone>(arrows: &BTreeSet<(T, T)>) -> Vec<Vec<T>> {
    let mut next: BTreeMap<&T, Vec<&T>> = BTreeMap::new();
    for (from, to) in arrows {
        next.entry(from).or_default().push(to);
    }
    let mut reach: BTreeMap<&T, BTreeSet<&T>> = BTreeMap::new();
    for from in next.keys() {
        let (mut seen, mut open) = (BTreeSet::new(), vec![*from]);
        while let Some(node) = open.pop() {
            let below = next.get(node).into_iter().flatten().copied();
            open.extend(below.filter(|to| seen.insert(*to)));
        }
        reach.insert(from, seen);
    }
    let reaches = |a: &T, b: &T| reach.get(a).is_some_and(|seen| seen.contains(b));
    let tied = reach.keys().filter(|node| reaches(node, node));
    let groups = tied.map(|a| {
        reach[*a]
            .iter()
            .filter(|b| reaches(b, a))
            .map(|b| (*b).clone())
            .collect()
    });
    groups.collect::<BTreeSet<Vec<T>>>().into_iter().collect()
}

#[test]
fn imports_go_down_only() {
    let arrows = House::read().arrows();
    let upward: Vec<String> = (arrows.iter())
        .filter(|(from, to)| floor(from) < floor(to))
        .map(|(from, to)| format!("{} -> {}", name(from), name(to)))
        .collect();
    assert!(arrows.len() > 100, "only {} imports seen", arrows.len());
    assert!(upward.is_empty(), "upward:\n{}", upward.join("\n"));
}

#[test]
fn no_files_import_in_a_circle() {
    let arrows = House::read().arrows();
    let within = arrows
        .iter()
        .filter(|(a, b)| !a.is_empty() && !b.is_empty());
    let ties = circles(&within.clone().cloned().collect());
    let told: Vec<String> = (ties.iter())
        .map(|tie| tie.iter().map(name).collect::<Vec<_>>().join(", "))
        .collect();
    assert!(told.is_empty(), "circles:\n{}", told.join("\n"));
}

#[test]
fn no_rooms_import_in_a_circle() {
    let room = |module: &Module| module.iter().take(2).cloned().collect::<Module>();
    let arrows = House::read().arrows();
    let between: BTreeSet<Arrow> = (arrows.iter())
        .map(|(a, b)| (room(a), room(b)))
        .filter(|(a, b)| a != b && a.len() == 2 && b.len() == 2)
        .collect();
    let ties = circles(&between);
    let told: Vec<String> = (ties.iter())
        .map(|tie| tie.iter().map(name).collect::<Vec<_>>().join(", "))
        .collect();
    assert!(told.is_empty(), "circles:\n{}", told.join("\n"));
}
