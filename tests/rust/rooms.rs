//! Module dependencies of the crates: modules of the core form layers, and no crate has cyclic dependencies.
//!
//! Dependencies are read from the `use` lines. Within a module, an item used through `mod.rs` counts as a
//! dependency on the file that defines it, and an item that `mod.rs` itself defines as one on `mod`. The lines with
//! which `mod.rs` only passes an item on are no dependency of `mod`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The modules of the core, from the highest layer to the lowest. Each may use only modules after it.
const LAYERS: [&str; 22] = [
    "reference",
    "simulation",
    "display",
    "clearance",
    "body",
    "error",
    "volume",
    "contact",
    "skin",
    "dynamics",
    "fracture",
    "matching",
    "state",
    "motion",
    "lattice",
    "voxel",
    "mesh",
    "simd",
    "sparse_set",
    "plan",
    "parallel",
    "range",
];

/// The modules or files that each module or file uses.
type Dependencies = BTreeMap<String, BTreeSet<String>>;

fn source(krate: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates").join(krate).join("src")
}

/// Returns the Rust files below a folder, sorted.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                all.push(path);
            }
        }
    }
    all.sort();
    all
}

/// Returns the code of a file without comments and unit tests.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let text = text.split("#[cfg(test)]\nmod ").next().unwrap();
    let lines = text.lines().map(|line| line.split("//").next().unwrap());
    lines.collect::<Vec<_>>().join("\n")
}

/// Returns the paths of all `use` items with braces expanded: `use a::{b, c::d};` gives `a::b` and `a::c::d`.
fn uses(code: &str) -> Vec<Vec<String>> {
    let mut paths = Vec::new();
    let mut rest = code;
    while let Some(at) = rest.find("use ") {
        let line =
            rest[..at].lines().next_back().filter(|_| !rest[..at].ends_with('\n')).unwrap_or("").trim();
        let is_item = line.is_empty() || line.starts_with("pub");
        rest = &rest[at + 4..];
        if let (true, Some(end)) = (is_item, rest.find(';')) {
            expand(Vec::new(), &rest[..end], &mut paths);
        }
    }
    paths
}

/// Appends the paths of a `use` tree below `prefix` to `paths`.
fn expand(mut prefix: Vec<String>, tree: &str, paths: &mut Vec<Vec<String>>) {
    let tree = tree.trim();
    if let Some(at) = tree.find('{') {
        prefix.extend(segments(&tree[..at]));
        let (mut depth, mut first) = (0, at + 1);
        for (i, letter) in tree.char_indices().skip(at) {
            match letter {
                '{' => depth += 1,
                '}' => depth -= 1,
                _ => {}
            }
            if (letter == ',' && depth == 1) || depth == 0 {
                if !tree[first..i].trim().is_empty() {
                    expand(prefix.clone(), &tree[first..i], paths);
                }
                first = i + 1;
            }
            if depth == 0 {
                break;
            }
        }
    } else {
        prefix.extend(segments(tree));
        paths.push(prefix);
    }
}

fn segments(path: &str) -> impl Iterator<Item = String> {
    let path = path.split(" as ").next().unwrap_or_default();
    path.split("::").map(str::trim).filter(|part| !part.is_empty()).map(str::to_owned)
}

/// Returns the dependencies between the top-level modules of a crate, from `use crate::...` and from paths in
/// the code.
fn module_dependencies(krate: &str) -> Dependencies {
    let folder = source(krate);
    let mut dependencies = Dependencies::new();
    for path in files(&folder) {
        let relative = path.strip_prefix(&folder).unwrap();
        let module = relative.components().next().unwrap().as_os_str().to_str().unwrap();
        let module = module.trim_end_matches(".rs").to_owned();
        if ["lib", "main"].contains(&&*module) {
            continue;
        }
        let code = code(&path);
        let mut used: BTreeSet<String> = code
            .match_indices("crate::")
            .filter_map(|(at, _)| {
                let name = code[at + 7..].split(|c: char| !c.is_alphanumeric() && c != '_').next()?;
                name.starts_with(|c: char| c.is_lowercase()).then(|| name.to_owned())
            })
            .collect();
        let paths = uses(&code).into_iter().filter(|path| path.len() > 1 && path[0] == "crate");
        used.extend(
            paths.map(|path| path[1].clone()).filter(|name| name.starts_with(|c: char| c.is_lowercase())),
        );
        used.remove(&module);
        dependencies.entry(module).or_default().extend(used);
    }
    let known: BTreeSet<String> = dependencies.keys().cloned().collect();
    dependencies.values_mut().for_each(|used| used.retain(|name| known.contains(name)));
    dependencies
}

/// Returns the names of the items that code defines at its top level.
fn defined_items(code: &str) -> BTreeSet<String> {
    let kinds = ["struct ", "enum ", "union ", "trait ", "type ", "fn ", "const ", "static "];
    let items = code.lines().filter(|line| !line.starts_with([' ', '}', '#']));
    let names = items.filter_map(|line| {
        let line =
            line.strip_prefix("pub").map_or(line, |rest| rest.split_once(' ').map_or("", |(_, item)| item));
        let name = kinds.iter().find_map(|kind| line.strip_prefix(kind))?;
        Some(name.split(|c: char| !c.is_alphanumeric() && c != '_').next()?.to_owned())
    });
    names.collect()
}

/// Returns code without its `use` items.
fn without_uses(code: &str) -> String {
    let mut is_use = false;
    let lines = code.lines().filter(|line| {
        let item = line.trim_start();
        is_use |= item.starts_with("use ") || (item.starts_with("pub") && item.contains(" use "));
        let skipped = is_use;
        is_use &= !line.contains(';');
        !skipped
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// Returns whether a word occurs in code.
fn mentions(code: &str, word: &str) -> bool {
    code.match_indices(word)
        .any(|(at, _)| !code[..at].ends_with(is_part) && !code[at + word.len()..].starts_with(is_part))
}

/// Returns whether a path into a module occurs in code: its name, followed by `::`.
fn mentions_path(code: &str, module: &str) -> bool {
    code.match_indices(&format!("{module}::")).any(|(at, _)| !code[..at].ends_with(is_part))
}

/// Returns whether a letter can be part of a name.
fn is_part(letter: char) -> bool {
    letter.is_alphanumeric() || letter == '_'
}

/// Returns the dependencies between the files and subfolders of a module's folder, `mod` among them.
fn file_dependencies(folder: &Path) -> Dependencies {
    let mod_file = code(&folder.join("mod.rs"));
    // The file that defines each item that `mod.rs` imports or re-exports.
    let mut defining_file: BTreeMap<String, String> = uses(&mod_file)
        .into_iter()
        .map(|path| path.into_iter().filter(|part| part != "self").collect::<Vec<_>>())
        .filter(|path| path.len() > 1)
        .map(|path| (path[path.len() - 1].clone(), path[0].clone()))
        .collect();
    let name = |path: &Path| path.file_stem().unwrap().to_str().unwrap().to_owned();
    let entries: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|p| name(p) != "mod")
        .collect();
    let names: BTreeSet<String> = entries.iter().map(|path| name(path)).collect();
    defining_file.retain(|_, file| names.contains(file));
    let body = without_uses(&mod_file);
    // What `mod.rs` uses itself: items of its files by their names, and paths into its files.
    let items = defining_file.iter().filter(|(item, _)| mentions(&body, item)).map(|(_, file)| file.clone());
    let paths = names.iter().filter(|name| mentions_path(&body, name)).cloned();
    let mut dependencies = Dependencies::from([("mod".to_owned(), items.chain(paths).collect())]);
    defining_file.extend(defined_items(&body).into_iter().map(|item| (item, "mod".to_owned())));
    // The path of the module itself, such as `crate::volume::field`.
    let parts = folder.components().map(|part| part.as_os_str().to_str().unwrap().to_owned());
    let mut own: Vec<String> = parts.skip_while(|part| part != "src").collect();
    own[0] = "crate".to_owned();
    for path in &entries {
        let sources = if path.is_dir() { files(path) } else { vec![path.clone()] };
        for file in sources {
            let depth = file.strip_prefix(folder).unwrap().components().count();
            // The module is `super` of a file in its folder, `super::super` of a file in a subfolder.
            let levels = if file.file_stem().unwrap() == "mod" { depth - 1 } else { depth };
            let used = uses(&code(&file)).into_iter().filter_map(|path| {
                let supers = path.iter().take_while(|part| *part == "super").count();
                let at = if path.starts_with(&own) { own.len() } else { supers };
                let target = path.get(at).filter(|_| at == own.len() || supers == levels)?;
                if names.contains(target) { Some(target.clone()) } else { defining_file.get(target).cloned() }
            });
            dependencies.entry(name(path)).or_default().extend(used.filter(|target| *target != name(path)));
        }
    }
    dependencies
}

/// Returns a cycle of dependencies, if there is one.
fn cycle(dependencies: &Dependencies) -> Option<Vec<String>> {
    fn visit(
        at: &str,
        dependencies: &Dependencies,
        path: &mut Vec<String>,
        done: &mut BTreeSet<String>,
    ) -> Option<Vec<String>> {
        if let Some(first) = path.iter().position(|step| step == at) {
            return Some(path[first..].to_vec());
        }
        if !done.insert(at.to_owned()) {
            return None;
        }
        path.push(at.to_owned());
        let mut used = dependencies.get(at).into_iter().flatten();
        let found = used.find_map(|next| visit(next, dependencies, path, done));
        path.pop();
        found
    }
    let mut done = BTreeSet::new();
    dependencies.keys().find_map(|start| visit(start, dependencies, &mut Vec::new(), &mut done))
}

#[test]
fn modules_of_the_core_use_only_lower_layers() {
    let layer = |module: &str| LAYERS.iter().position(|known| *known == module);
    for (module, used) in module_dependencies("core") {
        let own = layer(&module).unwrap_or_else(|| panic!("module `{module}` is missing in LAYERS"));
        for other in used {
            let below = layer(&other).unwrap_or_else(|| panic!("module `{other}` is missing in LAYERS"));
            assert!(own < below, "module `{module}` uses `{other}`, which is not in a lower layer");
        }
    }
}

#[test]
fn modules_of_the_other_crates_have_no_cyclic_dependencies() {
    for krate in ["io", "study", "cli", "python", "web"] {
        assert_eq!(cycle(&module_dependencies(krate)), None, "crate `{krate}`");
    }
}

#[test]
fn files_of_a_module_have_no_cyclic_dependencies() {
    let mut cycles: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for krate in ["core", "io", "study", "cli", "python", "web"] {
        for mod_file in files(&source(krate)).iter().filter(|path| path.ends_with("mod.rs")) {
            let folder = mod_file.parent().unwrap();
            let name = format!("{krate}/{}", folder.strip_prefix(source(krate)).unwrap().display());
            cycles.extend(cycle(&file_dependencies(folder)).map(|cycle| (name, cycle)));
        }
    }
    assert!(cycles.is_empty(), "{cycles:#?}");
}

#[test]
fn items_of_mod_files_are_found() {
    let code = "use a::{B, c};\npub(crate) use d::E;\npub struct F {\n    g: B,\n}\npub(super) fn h() {\n    fn i() {}\n}\n";
    assert_eq!(defined_items(code).iter().collect::<Vec<_>>(), ["F", "h"]);
    let body = without_uses(code);
    assert!(mentions(&body, "B") && mentions(&body, "F") && !mentions(&body, "E") && !mentions(&body, "c"));
    assert!(mentions_path("substeps::read()", "substeps") && !mentions_path("substeps::read()", "steps"));
}

/// Returns the names of the modules of a crate as a page gives them: `name/` for a folder, `name.rs` for a file.
fn listed_modules(krate: &str) -> BTreeSet<String> {
    let entries = fs::read_dir(source(krate)).unwrap().map(|entry| entry.unwrap());
    let names = entries.map(|entry| {
        let name = entry.file_name().into_string().unwrap();
        if entry.path().is_dir() { format!("{name}/") } else { name }
    });
    names.filter(|name| !["lib.rs", "main.rs"].contains(&&**name)).collect()
}

#[test]
fn architecture_page_lists_the_modules_of_the_core_by_layers_and_those_of_io_and_the_bridge() {
    let page = fs::read_to_string(source("core").join("../../../ARCHITECTURE.md")).unwrap();
    let rows =
        page.lines().filter_map(|line| line.strip_prefix("| `")?.split_once("` |")).map(|(name, _)| name);
    let rows: Vec<&str> = rows.filter(|name| name.ends_with('/') || name.ends_with(".rs")).collect();
    let (core, others) = rows.split_at(LAYERS.len().min(rows.len()));
    let (io, bridge) = others.split_at(listed_modules("io").len().min(others.len()));
    let layers: Vec<&str> =
        core.iter().map(|row| row.trim_end_matches('/').trim_end_matches(".rs")).collect();
    assert_eq!(layers, LAYERS);
    let named = |rows: &[&str]| rows.iter().map(|row| (*row).to_owned()).collect::<BTreeSet<_>>();
    assert_eq!(named(core), listed_modules("core"));
    assert_eq!(named(io), listed_modules("io"));
    assert_eq!(named(bridge), listed_modules("rapier"));
}

/// The page names the stages of the step in the order of the lists.
#[test]
fn architecture_page_lists_the_stages_of_the_step() {
    let page = fs::read_to_string(source("core").join("../../../ARCHITECTURE.md")).unwrap();
    let code = fs::read_to_string(source("core").join("body/stages/mod.rs")).unwrap();
    for list in ["ADVANCE", "FINISH", "END"] {
        let start = code.find(&format!("const {list}: ")).unwrap();
        let entries = code[start..].lines().skip(1).take_while(|line| *line != "];");
        let stages: Vec<&str> =
            entries.filter_map(|line| line.trim().strip_prefix('&')?.strip_suffix(',')).collect();
        let (_, text) = page.split_once(&format!("\n{list} ")).unwrap();
        let block = text.lines().enumerate().take_while(|(k, line)| *k == 0 || line.starts_with("    "));
        let listed: Vec<&str> = block
            .flat_map(|(_, line)| line.split(','))
            .map(str::trim)
            .filter(|name| !name.is_empty())
            .collect();
        assert!(
            !stages.is_empty() && stages == listed,
            "{list}: {stages:?} in the code, {listed:?} on the page"
        );
    }
}

#[test]
fn use_lines_are_expanded_and_cycles_are_found() {
    let code = "//! x\nuse a::{b, c::{d, E as F}};\npub(crate) use super::g;\nfn h() {}\n";
    let read: Vec<String> = uses(code).iter().map(|path| path.join("::")).collect();
    assert_eq!(read, ["a::b", "a::c::d", "a::c::E", "super::g"]);
    let graph = |pairs: &[(&str, &str)]| {
        let mut dependencies = Dependencies::new();
        for (from, to) in pairs {
            dependencies.entry((*from).to_owned()).or_default().insert((*to).to_owned());
        }
        dependencies
    };
    assert_eq!(cycle(&graph(&[("a", "b"), ("b", "c"), ("a", "c")])), None);
    let found = cycle(&graph(&[("a", "b"), ("b", "c"), ("c", "b")]));
    assert_eq!(found, Some(vec!["b".to_owned(), "c".to_owned()]));
    assert!(module_dependencies("core")["simulation"].contains("body"));
}
