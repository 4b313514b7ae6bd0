//! The house stands: five floors, imports go down only, and nothing imports in a circle.
//!
//! Every path in `src/` is followed, through re-exports, to the file that defines what it names. What
//! is compiled for tests only is left out.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use syn::visit::{self, Visit};
use syn::{Attribute, File, ImplItemFn, Item, Macro, UseTree};

const FLOORS: [&str; 5] = ["core", "io", "observe", "tools", "cli"];

type Module = Vec<String>;

/// An import: the file that has it, and the file that it leads to.
type Arrow = (Module, Module);

/// One file.
#[derive(Default)]
struct Source {
    /// The paths in it, from the root of the crate.
    paths: Vec<Module>,
    /// The same as they are written, those into other crates among them.
    written: Vec<String>,
    /// Names of the items in it.
    defined: BTreeSet<String>,
    /// Names that it imports, and with that hands on to its children, or to everybody.
    handed_on: BTreeMap<String, Module>,
    /// Modules all of whose names it imports, and hands on.
    globs: Vec<Module>,
}

struct House {
    files: BTreeMap<Module, Source>,
}

/// This crate.
static HOUSE: LazyLock<House> = LazyLock::new(|| {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    House::new(&|path| {
        let path = src.join(path);
        fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    })
});

impl House {
    /// A house of these files.
    fn planted(files: &[(&str, &str)]) -> Self {
        let files: BTreeMap<_, _> = files.iter().copied().collect();
        Self::new(&|path| files.get(path).copied().unwrap_or_default().to_owned())
    }

    fn new(read: &dyn Fn(&str) -> String) -> Self {
        let mut house = Self {
            files: BTreeMap::new(),
        };
        house.add(read, "lib.rs", Vec::new());
        house.add(read, "main.rs", vec!["main".to_owned()]);
        house
    }

    /// Adds a file and the files of its modules.
    fn add(&mut self, read: &dyn Fn(&str) -> String, path: &str, module: Module) {
        let file = syn::parse_file(&read(path)).unwrap_or_else(|e| panic!("{path}: {e}"));
        for item in &file.items {
            if let Item::Mod(child) = item
                && child.content.is_none()
                && !for_tests(&child.attrs)
            {
                let below = at_path(&child.attrs)
                    .unwrap_or_else(|| [module.clone(), vec![child.ident.to_string()]].concat());
                self.add(read, &format!("{}.rs", below.join("/")), below);
            }
        }
        let mut reader = Reader {
            module: module.clone(),
            source: Source::default(),
        };
        reader.visit_file(&file);
        self.files.insert(module, reader.source);
    }

    fn arrows(&self) -> BTreeSet<Arrow> {
        let mut arrows = BTreeSet::new();
        for (module, source) in &self.files {
            // A module that is imported counts by what is then used of it.
            let items = source
                .paths
                .iter()
                .filter(|path| !self.files.contains_key(*path));
            let to = items
                .chain(&source.globs)
                .filter_map(|path| self.definer(path, 0));
            arrows.extend(to.filter(|to| to != module).map(|to| (module.clone(), to)));
        }
        arrows
    }

    /// The file that defines what a path from the root names.
    fn definer(&self, path: &[String], depth: usize) -> Option<Module> {
        let starts = (0..=path.len()).rev().map(|n| path.split_at(n));
        let mut starts = starts.filter_map(|(at, rest)| Some((at, self.files.get(at)?, rest)));
        let (module, source, rest) = starts.next()?;
        let Some((name, after)) = rest.split_first() else {
            return Some(module.to_vec());
        };
        if source.defined.contains(name) {
            return Some(module.to_vec());
        }
        if depth < 8 {
            if let Some(target) = source.handed_on.get(name) {
                return self.definer(&[target, after].concat(), depth + 1);
            }
            let globs = source.globs.iter().map(|glob| [glob, rest].concat());
            if let Some(found) = globs
                .filter_map(|path| self.definer(&path, depth + 1))
                .next()
            {
                return Some(found);
            }
        }
        // A name of another crate, or of the prelude.
        None
    }

    /// The files that name something of another crate.
    fn naming(&self, names: impl Fn(&str) -> bool) -> impl Iterator<Item = &Module> {
        let found = self.files.iter();
        found
            .filter(move |(_, it)| it.written.iter().any(|w| names(w)))
            .map(|(module, _)| module)
    }

    fn upward(&self) -> Vec<String> {
        let arrows = self.arrows().into_iter();
        told(
            arrows
                .filter(|(from, to)| floor(from) < floor(to))
                .collect(),
        )
    }

    /// The arrows on circles between files.
    fn circles(&self) -> Vec<String> {
        told(circular(&self.arrows()))
    }

    /// The arrows on circles between rooms, the folders of a floor.
    fn circles_of_rooms(&self) -> Vec<String> {
        let room = |module: Module| module.into_iter().take(2).collect::<Module>();
        let arrows = self
            .arrows()
            .into_iter()
            .map(|(from, to)| (room(from), room(to)));
        told(circular(
            &arrows
                .filter(|(a, b)| a != b && a.len() == 2 && b.len() == 2)
                .collect(),
        ))
    }
}

struct Reader {
    module: Module,
    source: Source,
}

impl Reader {
    /// A path as it is written, from the root of the crate.
    fn absolute(&self, written: &[String]) -> Module {
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

    fn take(&mut self, written: &[String]) {
        self.source.paths.push(self.absolute(written));
        self.source.written.push(written.join("::"));
    }

    fn take_use(&mut self, tree: &UseTree, before: &[String]) {
        let (name, known_as) = match tree {
            UseTree::Path(path) => {
                let before = [before, &[path.ident.to_string()]].concat();
                return self.take_use(&path.tree, &before);
            }
            UseTree::Group(group) => {
                return group
                    .items
                    .iter()
                    .for_each(|tree| self.take_use(tree, before));
            }
            UseTree::Glob(_) => {
                self.source.written.push(before.join("::"));
                return self.source.globs.push(self.absolute(before));
            }
            UseTree::Name(name) => (&name.ident, &name.ident),
            UseTree::Rename(name) => (&name.ident, &name.rename),
        };
        let (path, known_as) = match before.last() {
            Some(last) if name == "self" => (
                before.to_vec(),
                if known_as == "self" {
                    last.clone()
                } else {
                    known_as.to_string()
                },
            ),
            _ => ([before, &[name.to_string()]].concat(), known_as.to_string()),
        };
        let target = self.absolute(&path);
        // `use serde_json;` would lead back to itself.
        if target != [self.module.as_slice(), std::slice::from_ref(&known_as)].concat() {
            self.source.handed_on.insert(known_as, target);
        }
        self.take(&path);
    }
}

impl<'a> Visit<'a> for Reader {
    fn visit_file(&mut self, file: &'a File) {
        file.items.iter().for_each(|item| self.visit_item(item));
    }

    fn visit_item(&mut self, item: &'a Item) {
        let (attributes, name) = match item {
            Item::Const(it) => (&it.attrs, Some(&it.ident)),
            Item::Enum(it) => (&it.attrs, Some(&it.ident)),
            Item::Fn(it) => (&it.attrs, Some(&it.sig.ident)),
            Item::Impl(it) => (&it.attrs, None),
            Item::Macro(it) => (&it.attrs, it.ident.as_ref()),
            Item::Mod(it) => (&it.attrs, it.content.as_ref().map(|_| &it.ident)),
            Item::Static(it) => (&it.attrs, Some(&it.ident)),
            Item::Struct(it) => (&it.attrs, Some(&it.ident)),
            Item::Trait(it) => (&it.attrs, Some(&it.ident)),
            Item::Type(it) => (&it.attrs, Some(&it.ident)),
            Item::Use(it) => (&it.attrs, None),
            _ => return visit::visit_item(self, item),
        };
        if for_tests(attributes) {
            return;
        }
        self.source.defined.extend(name.map(ToString::to_string));
        match item {
            Item::Use(it) => self.take_use(&it.tree, &[]),
            Item::Mod(it) => {
                self.module.push(it.ident.to_string());
                visit::visit_item(self, item);
                self.module.pop();
            }
            _ => visit::visit_item(self, item),
        }
    }

    fn visit_impl_item_fn(&mut self, method: &'a ImplItemFn) {
        if !for_tests(&method.attrs) {
            visit::visit_impl_item_fn(self, method);
        }
    }

    fn visit_path(&mut self, path: &'a syn::Path) {
        let written: Vec<String> = path.segments.iter().map(|s| s.ident.to_string()).collect();
        if written.len() > 1 {
            self.take(&written);
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, it: &'a Macro) {
        let text = it.tokens.to_string().replace(" :: ", "::");
        let words = text.split(|c: char| !c.is_alphanumeric() && c != '_' && c != ':');
        for word in words.filter(|word| word.contains("::")) {
            let segments = word.split("::").filter(|segment| !segment.is_empty());
            self.take(
                &segments
                    .map(|s| s.trim_matches(':').to_owned())
                    .collect::<Vec<_>>(),
            );
        }
        visit::visit_macro(self, it);
    }
}

fn for_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let list = attribute.meta.require_list();
        attribute.path().is_ident("cfg") && list.is_ok_and(|l| l.tokens.to_string() == "test")
    })
}

/// The module that a file of another name would be.
fn at_path(attributes: &[Attribute]) -> Option<Module> {
    let path = attributes
        .iter()
        .find(|attribute| attribute.path().is_ident("path"))?;
    let syn::Expr::Lit(value) = &path.meta.require_name_value().ok()?.value else {
        return None;
    };
    let syn::Lit::Str(file) = &value.lit else {
        return None;
    };
    Some(
        file.value()
            .trim_end_matches(".rs")
            .split('/')
            .map(str::to_owned)
            .collect(),
    )
}

fn floor(module: &Module) -> usize {
    let name = module.first().map_or("", String::as_str);
    FLOORS
        .iter()
        .position(|floor| *floor == name)
        .unwrap_or(FLOORS.len())
}

fn told(arrows: BTreeSet<Arrow>) -> Vec<String> {
    let name = |it: &Module| {
        if it.is_empty() {
            "lib".to_owned()
        } else {
            it.join("::")
        }
    };
    arrows
        .iter()
        .map(|(from, to)| format!("{} -> {}", name(from), name(to)))
        .collect()
}

/// The arrows that lie on a circle: from their heads there is a way back.
fn circular(arrows: &BTreeSet<Arrow>) -> BTreeSet<Arrow> {
    let nodes: BTreeSet<&Module> = arrows.iter().flat_map(|(from, to)| [from, to]).collect();
    let numbers: BTreeMap<&Module, usize> = nodes.iter().copied().zip(0..).collect();
    let mut next = vec![Vec::new(); nodes.len()];
    for (from, to) in arrows {
        next[numbers[from]].push(numbers[to]);
    }
    let reached: Vec<Vec<bool>> = (0..nodes.len())
        .map(|start| {
            let (mut seen, mut open) = (vec![false; nodes.len()], vec![start]);
            while let Some(node) = open.pop() {
                if !std::mem::replace(&mut seen[node], true) {
                    open.extend(&next[node]);
                }
            }
            seen
        })
        .collect();
    let returns = |(from, to): &&Arrow| reached[numbers[to]][numbers[from]];
    arrows.iter().filter(returns).cloned().collect()
}

fn none(what: &str, found: &[String]) {
    assert!(found.is_empty(), "{what}:\n{}", found.join("\n"));
}

#[test]
fn imports_go_down_only() {
    let seen = HOUSE.arrows().len();
    assert!(seen > 300, "only {seen} imports seen");
    none("upward", &HOUSE.upward());
}

#[test]
fn no_files_import_in_a_circle() {
    none("on a circle", &HOUSE.circles());
}

#[test]
fn no_rooms_import_in_a_circle() {
    none("on a circle", &HOUSE.circles_of_rooms());
}

#[test]
fn other_crates_stay_in_their_rooms() {
    let of_crate = |written: &str, name: &str| written.split("::").next() == Some(name);
    let rerun = |written: &str| {
        let name = written.split("::").next().unwrap_or_default();
        name == "rerun" || name.starts_with("re_") && name != "re_cdr" && name != "re_ros_msg"
    };
    let outside = |files: Vec<&Module>, room: [&str; 2]| -> Vec<String> {
        files
            .into_iter()
            .filter(|it| !it.starts_with(&room.map(str::to_owned)))
            .map(|it| it.join("::"))
            .collect()
    };
    let drawing: Vec<_> = HOUSE.naming(rerun).collect();
    let reading: Vec<_> = HOUSE.naming(|written| of_crate(written, "mcap")).collect();
    assert!(!drawing.is_empty() && !reading.is_empty());
    none(
        "Rerun outside of observe/recording",
        &outside(drawing, ["observe", "recording"]),
    );
    none("MCAP outside of io/log", &outside(reading, ["io", "log"]));
}

#[test]
fn the_core_knows_no_files_clocks_or_threads() {
    let impure = |written: &str| {
        let places = [
            "std::fs",
            "std::thread",
            "std::time::Instant",
            "std::time::SystemTime",
            "rayon",
        ];
        places
            .iter()
            .any(|place| written == *place || written.starts_with(&format!("{place}::")))
    };
    let found = HOUSE.naming(impure).filter(|module| floor(module) == 0);
    none(
        "files, clocks or threads",
        &found.map(|module| module.join("::")).collect::<Vec<_>>(),
    );
}

/// A house whose `core` and `io` have these files.
fn house(core: &str, io: &str, files: &[(&str, &str)]) -> House {
    let frame = [
        ("lib.rs", "mod core; mod io;"),
        ("core.rs", core),
        ("io.rs", io),
    ];
    House::planted(&[&frame, files].concat())
}

#[test]
fn an_upward_import_is_seen_however_it_is_written() {
    let written = [
        "use crate::io::log::Log;",
        "use crate::io::{log::{Log as Other}};",
        "use crate::io::log::*;",
        "fn f() -> crate::io::log::Log { todo!() }",
        "fn f() { println!(\"{}\", crate::io::log::Log::new()) }",
        "use crate::io::log; fn f(_: log::Log) {}",
        "use crate::io; fn f(_: io::log::Log) {}",
        "mod inner { use super::super::super::io::log::Log; }",
        // Through a re-export.
        "use crate::io::Log;",
        "use crate::Log;",
    ];
    for text in written {
        let lib = ("lib.rs", "mod core; mod io; pub use io::Log;");
        let files = [
            ("core/pair.rs", text),
            ("io/log.rs", "pub struct Log;"),
            lib,
        ];
        let found = house("mod pair;", "mod log; pub use log::Log;", &files).upward();
        assert_eq!(found, ["core::pair -> io::log"], "{text}");
    }
    let down = [
        ("io/log.rs", "use crate::core::Pair;"),
        ("core/pair.rs", "pub struct Pair;"),
    ];
    let down = house("mod pair; pub use pair::Pair;", "mod log;", &down);
    assert_eq!(
        down.arrows().len(),
        2,
        "to what is re-exported, and the re-export"
    );
    none("down", &down.upward());
}

#[test]
fn circles_are_seen() {
    let pair = |text| ("core/pair.rs", text);
    let triple = |text| ("core/triple.rs", text);
    let both = ["core::pair -> core::triple", "core::triple -> core::pair"];
    for (pairs, triples) in [
        (
            "use super::triple::Triple; pub struct Pair;",
            "use super::pair::Pair; pub struct Triple;",
        ),
        // Through re-exports of the parent, named and by `*`.
        (
            "use crate::core::Triple; pub struct Pair;",
            "use super::Pair; pub struct Triple;",
        ),
    ] {
        for core in [
            "mod pair; mod triple; pub use pair::Pair; pub use triple::Triple;",
            "mod pair; mod triple; pub use pair::*; pub use triple::*;",
        ] {
            let house = house(core, "", &[pair(pairs), triple(triples)]);
            assert_eq!(house.circles(), both, "{core} {pairs}");
        }
    }

    let of_parent = "mod pair; pub struct Core(pair::Pair);";
    let child = "use super::Core; pub struct Pair;";
    let found = house(of_parent, "", &[pair(child)]).circles();
    assert_eq!(found, ["core -> core::pair", "core::pair -> core"]);
    // What the parent only imports is not the parent's.
    let of_parent = "mod pair; mod triple; use triple::Triple; struct Core(pair::Pair, Triple);";
    let files = [
        pair("use super::Triple; pub struct Pair;"),
        triple("pub struct Triple;"),
    ];
    none("no circle", &house(of_parent, "", &files).circles());
    // Nor is what tests import.
    let tested = "pub struct Pair; #[cfg(test)] mod tests { use super::super::triple::Triple; }";
    let files = [
        pair(tested),
        triple("use super::pair::Pair; pub struct Triple;"),
    ];
    none(
        "no circle",
        &house("mod pair; mod triple;", "", &files).circles(),
    );
}

#[test]
fn circles_of_rooms_are_seen_where_no_files_have_one() {
    let files = [
        ("core/fit.rs", "mod line; mod point;"),
        ("core/fit/line.rs", "use crate::core::map::wall::Wall;"),
        ("core/fit/point.rs", "pub struct Point;"),
        ("core/map.rs", "mod corner; pub mod wall;"),
        ("core/map/corner.rs", "use crate::core::fit::point::Point;"),
        ("core/map/wall.rs", "pub struct Wall;"),
    ];
    let house = house("mod fit; mod map;", "", &files);
    none("no circle of files", &house.circles());
    assert_eq!(
        house.circles_of_rooms(),
        ["core::fit -> core::map", "core::map -> core::fit"]
    );
}
