//! The rooms of the crates: arrows point one way, and no circles.
//!
//! Read from the `use` lines. In a folder, what a file takes from its `mod.rs` counts as taken from the file that
//! defines it; items that `mod.rs` defines itself are common to the room.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The rooms of the core: each may use those to its right.
const ORDER: [&str; 14] = [
    "simulation",
    "body",
    "volume",
    "contact",
    "skin",
    "dynamics",
    "matching",
    "state",
    "lattice",
    "voxel",
    "mesh",
    "simd",
    "plan",
    "parallel",
];

/// The naive oracle stands beside the rooms, `range` checks the numbers of all, and `error` wraps their errors.
const ELSEWHERE: [&str; 4] = ["reference", "range", "error", "internals"];

type Arrows = BTreeMap<String, BTreeSet<String>>;

fn source(krate: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates").join(krate).join("src")
}

/// The Rust files below a folder, sorted.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                all.push(path);
            }
        }
    }
    all.sort();
    all
}

/// The code of a file, without comments and without its unit tests.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let text = text.split("#[cfg(test)]\nmod ").next().unwrap();
    let lines = text.lines().map(|line| line.split("//").next().unwrap());
    lines.collect::<Vec<_>>().join("\n")
}

/// The paths of all `use` items of a text, braces resolved: `use a::{b, c::d};` gives `a::b` and `a::c::d`.
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

/// The top-level modules of a crate and those that each uses, by `use crate::...` and by paths in its code.
fn rooms(krate: &str) -> Arrows {
    let folder = source(krate);
    let mut arrows = Arrows::new();
    for path in files(&folder) {
        let relative = path.strip_prefix(&folder).unwrap();
        let room = relative.components().next().unwrap().as_os_str().to_str().unwrap();
        let room = room.trim_end_matches(".rs").to_owned();
        if ["lib", "main"].contains(&&*room) {
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
        used.remove(&room);
        arrows.entry(room).or_default().extend(used);
    }
    let known: BTreeSet<String> = arrows.keys().cloned().collect();
    arrows.values_mut().for_each(|used| used.retain(|name| known.contains(name)));
    arrows
}

/// The files of a folder and those beside them that each uses.
fn files_of_a_room(folder: &Path) -> Arrows {
    let door = code(&folder.join("mod.rs"));
    let home: BTreeMap<String, String> = uses(&door)
        .into_iter()
        .map(|path| path.into_iter().filter(|part| part != "self").collect::<Vec<_>>())
        .filter(|path| path.len() > 1)
        .map(|path| (path[path.len() - 1].clone(), path[0].clone()))
        .collect();
    let name = |path: &Path| path.file_stem().unwrap().to_str().unwrap().to_owned();
    let beside: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|p| name(p) != "mod")
        .collect();
    let names: BTreeSet<String> = beside.iter().map(|path| name(path)).collect();
    // The path of the room itself, as `crate::volume::field`.
    let parts = folder.components().map(|part| part.as_os_str().to_str().unwrap().to_owned());
    let mut own: Vec<String> = parts.skip_while(|part| part != "src").collect();
    own[0] = "crate".to_owned();
    let mut arrows = Arrows::new();
    for path in &beside {
        let inside = if path.is_dir() { files(path) } else { vec![path.clone()] };
        for file in inside {
            let depth = file.strip_prefix(folder).unwrap().components().count();
            // `super` of a file in the room, `super::super` of one in a folder of the room.
            let up = if file.file_stem().unwrap() == "mod" { depth - 1 } else { depth };
            let used = uses(&code(&file)).into_iter().filter_map(|path| {
                let supers = path.iter().take_while(|part| *part == "super").count();
                let at = if path.starts_with(&own) { own.len() } else { supers };
                let target = path.get(at).filter(|_| at == own.len() || supers == up)?;
                if names.contains(target) { Some(target.clone()) } else { home.get(target).cloned() }
            });
            arrows.entry(name(path)).or_default().extend(used.filter(|target| *target != name(path)));
        }
    }
    arrows.values_mut().for_each(|used| used.retain(|target| names.contains(target)));
    arrows
}

/// A circle of arrows, if there is one.
fn circle(arrows: &Arrows) -> Option<Vec<String>> {
    fn visit(
        at: &str,
        arrows: &Arrows,
        way: &mut Vec<String>,
        done: &mut BTreeSet<String>,
    ) -> Option<Vec<String>> {
        if let Some(first) = way.iter().position(|step| step == at) {
            return Some(way[first..].to_vec());
        }
        if !done.insert(at.to_owned()) {
            return None;
        }
        way.push(at.to_owned());
        let found = arrows.get(at).into_iter().flatten().find_map(|next| visit(next, arrows, way, done));
        way.pop();
        found
    }
    let mut done = BTreeSet::new();
    arrows.keys().find_map(|start| visit(start, arrows, &mut Vec::new(), &mut done))
}

#[test]
fn rooms_of_the_core_use_only_rooms_below_them() {
    let place = |room: &str| ORDER.iter().position(|known| *known == room);
    for (room, used) in rooms("core") {
        if ELSEWHERE.contains(&&*room) {
            continue;
        }
        let own = place(&room).unwrap_or_else(|| panic!("room `{room}` has no place in the order"));
        for other in used.iter().filter(|other| !ELSEWHERE.contains(&&***other)) {
            let below = place(other).unwrap_or_else(|| panic!("room `{other}` has no place in the order"));
            assert!(own < below, "room `{room}` uses `{other}`, which is not below it");
        }
        assert!(!used.contains("reference"), "room `{room}` uses the naive reference");
    }
}

#[test]
fn rooms_of_no_crate_use_each_other_in_circles() {
    for krate in ["io", "study", "cli", "python"] {
        assert_eq!(circle(&rooms(krate)), None, "crate `{krate}`");
    }
}

#[test]
fn files_of_no_room_use_each_other_in_circles() {
    let mut circles = Vec::new();
    for krate in ["core", "io", "study", "cli", "python"] {
        for door in files(&source(krate)).iter().filter(|path| path.ends_with("mod.rs")) {
            let folder = door.parent().unwrap();
            circles.extend(circle(&files_of_a_room(folder)).map(|circle| (folder.to_owned(), circle)));
        }
    }
    assert!(circles.is_empty(), "{circles:#?}");
}

#[test]
fn use_lines_are_read_and_circles_are_found() {
    let code = "//! x\nuse a::{b, c::{d, E as F}};\npub(crate) use super::g;\nfn h() {}\n";
    let read: Vec<String> = uses(code).iter().map(|path| path.join("::")).collect();
    assert_eq!(read, ["a::b", "a::c::d", "a::c::E", "super::g"]);
    let arrows = |pairs: &[(&str, &str)]| {
        let mut arrows = Arrows::new();
        for (from, to) in pairs {
            arrows.entry((*from).to_owned()).or_default().insert((*to).to_owned());
        }
        arrows
    };
    assert_eq!(circle(&arrows(&[("a", "b"), ("b", "c"), ("a", "c")])), None);
    assert!(circle(&arrows(&[("a", "b"), ("b", "c"), ("c", "b")])).is_some());
    assert!(rooms("core")["simulation"].contains("body"), "arrows are found");
}
