//! The pages name only files that exist, and modules depend on one another one way.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Folders that a page may leave out of a path, as a table's heading names them.
const FOLDERS: [&str; 4] = ["", "crates/gimage/src", "crates/runtime/src", "crates/bundle/src"];
/// Beginnings of a path from the root of the repository.
const ROOTS: [&str; 6] = ["crates/", "tests/", "assets", "docs/", "shaders", "bench"];

/// All pages of the root, of `docs` and of `bench`.
fn pages(root: &Path) -> Vec<PathBuf> {
    let entries = ["", "docs", "bench", "assets"].into_iter().flat_map(|folder| {
        let entries = std::fs::read_dir(root.join(folder)).unwrap();
        entries.map(|entry| entry.unwrap().path())
    });
    entries.filter(|path| path.extension().is_some_and(|e| e == "md")).collect()
}

#[test]
fn every_path_in_the_pages_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut checked = 0;
    for page in pages(root) {
        let text = std::fs::read_to_string(&page).unwrap();
        let links = text.split("](").skip(1).filter_map(|t| t.split(')').next());
        for link in links.filter(|link| !link.contains(':')) {
            let file = link.split('#').next().unwrap_or_default();
            let target = page.parent().unwrap().join(file);
            assert!(target.exists(), "{} links to {link}", page.display());
            checked += 1;
        }
        if !["ARCHITECTURE.md", "README.md", "CONTRIBUTING.md"].iter().any(|name| page == root.join(name)) {
            continue;
        }
        let code = text.split('`').skip(1).step_by(2);
        for path in code.filter(|p| !p.contains([' ', '\n', '<', '*', '"', '(', ':'])) {
            let named = [".rs", ".wgsl", ".md", ".toml", "/"].iter().any(|end| path.ends_with(end));
            if named || ROOTS.iter().any(|k| path.starts_with(k)) {
                let found = FOLDERS.iter().any(|folder| root.join(folder).join(path).exists());
                assert!(found, "{} names {path}", page.display());
                checked += 1;
            }
        }
    }
    assert!(checked > 100, "only {checked} paths found");
}

/// Comments of shaders and of sources name files from the root.
#[test]
fn the_version_of_wgpu_is_stated_where_readers_begin() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let manifest = std::fs::read_to_string(root.join("Cargo.toml")).unwrap();
    let line = manifest.lines().find(|line| line.starts_with("wgpu = ")).unwrap();
    let version = line.split('"').nth(1).and_then(|v| v.split('.').next()).unwrap();
    for page in ["README.md", "docs/screen.md", "crates/runtime/src/lib.rs"] {
        let text = std::fs::read_to_string(root.join(page)).unwrap();
        assert!(text.contains(&format!("wgpu {version}")), "{page} does not name wgpu {version}");
    }
}

#[test]
fn every_path_in_comments_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut checked = 0;
    for file in ["crates", "shaders"].iter().flat_map(|folder| files(&root.join(folder))) {
        let text = std::fs::read_to_string(&file).unwrap_or_default();
        let comments = text.lines().filter_map(|line| line.trim_start().strip_prefix("//"));
        let words = comments.flat_map(|line| line.split([' ', '`', '(', ')', ',', ';', ':', '[', ']']));
        let path = |word: &str| -> Option<String> {
            let word = word.trim_end_matches('.');
            let named = (word.starts_with("crates/") && word.ends_with(".rs"))
                || (word.starts_with("shaders/") && word.ends_with(".wgsl"));
            named.then(|| word.to_owned())
        };
        for path in words.filter_map(path) {
            assert!(root.join(&path).exists(), "{} names {path}", file.display());
            checked += 1;
        }
    }
    assert!(checked > 50, "only {checked} paths found");
}

/// Top-level modules of the runtime that each one names by `crate::`, in code outside its tests.
fn modules_named(source: &Path) -> BTreeMap<String, BTreeSet<String>> {
    let root = code(&source.join("lib.rs"));
    let mut tokens = words(&root).peekable();
    let (mut modules, mut exports) = (BTreeSet::new(), BTreeMap::new());
    while let Some(token) = tokens.next() {
        let next = tokens.peek().copied().unwrap_or_default();
        if token == "mod" {
            modules.insert(next.to_owned());
        } else if token == "use" {
            let module = next.to_owned();
            // Names that the crate re-exports belong to the module that has them.
            let names = tokens.by_ref().skip(1).take_while(|t| *t != ";");
            exports.extend(names.map(|name| (name.to_owned(), module.clone())));
        }
    }
    let mut named: BTreeMap<String, BTreeSet<String>> = modules.iter().map(|m| (m.clone(), BTreeSet::new())).collect();
    for file in files(source) {
        let top = file.strip_prefix(source).unwrap().components().next().unwrap();
        let top = Path::new(&top).file_stem().unwrap().to_str().unwrap().to_owned();
        let Some(named) = named.get_mut(&top) else { continue };
        let found = names_after_crate(&code(&file));
        let module = |name: String| if modules.contains(&name) { Some(name) } else { exports.get(&name).cloned() };
        named.extend(found.into_iter().filter_map(module).filter(|module| *module != top));
    }
    named
}

/// Names that follow `crate::` in a program: one name, or those of a list in braces without what is nested in it.
fn names_after_crate(code: &str) -> Vec<String> {
    let mut names = Vec::new();
    for path in code.split("crate::").skip(1) {
        let Some(list) = path.strip_prefix('{') else {
            names.extend(words(path).next().map(String::from));
            continue;
        };
        let (mut depth, mut first) = (0, true);
        for token in words(list) {
            match token {
                "{" => depth += 1,
                "}" if depth == 0 => break,
                "}" => depth -= 1,
                "," => first = depth == 0,
                name if depth == 0 && first => {
                    names.push(name.to_owned());
                    first = false;
                }
                _ => {}
            }
        }
    }
    names
}

/// Names and the marks `{`, `}`, `,` and `;` of a program.
fn words(code: &str) -> impl Iterator<Item = &str> {
    let name = |c: char| c.is_alphanumeric() || c == '_';
    code.split_inclusive(move |c| !name(c))
        .flat_map(move |part| {
            let (word, mark) = part.split_at(part.trim_end_matches(|c| !name(c)).len());
            [word, mark]
        })
        .filter(move |token| token.starts_with(name) || ["{", "}", ",", ";"].contains(token))
}

/// A program without comments and without the module of its tests, which ends a file.
fn code(file: &Path) -> String {
    let text = std::fs::read_to_string(file).unwrap();
    let lines = text.lines().map(|line| line.split("//").next().unwrap_or_default());
    let code = lines.collect::<Vec<_>>().join("\n");
    code.split("#[cfg(test)]\nmod tests").next().unwrap_or_default().to_owned()
}

/// Files in a folder and those below.
fn all_files(folder: &Path) -> Vec<PathBuf> {
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    paths.flat_map(|path| if path.is_dir() { all_files(&path) } else { vec![path] }).collect()
}

/// Programs in a folder and those below, without files of tests.
fn files(folder: &Path) -> Vec<PathBuf> {
    let program = |path: &PathBuf| {
        path.extension().is_some_and(|e| e == "rs" || e == "wgsl")
            && !path.file_stem().unwrap().to_str().unwrap().ends_with("tests")
    };
    all_files(folder).into_iter().filter(program).collect()
}

/// A way from a module to itself, if there is one.
fn circle(named: &BTreeMap<String, BTreeSet<String>>) -> Option<Vec<&str>> {
    // A module that names nothing, or only such modules, is part of no circle.
    let mut left: BTreeMap<&str, Vec<&str>> =
        named.iter().map(|(m, names)| (&**m, names.iter().map(|n| &**n).collect())).collect();
    while let Some(done) = left.iter().find(|(_, names)| names.iter().all(|n| !left.contains_key(n))).map(|(m, _)| *m) {
        left.remove(done);
    }
    let mut way = vec![*left.keys().next()?];
    loop {
        let next = *left[way[way.len() - 1]].iter().find(|n| left.contains_key(*n))?;
        let known = way.iter().position(|m| *m == next);
        way.push(next);
        if let Some(start) = known {
            return Some(way.split_off(start));
        }
    }
}

#[test]
fn imports_of_the_runtime_run_one_way() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let named = modules_named(&root.join("crates/runtime/src"));
    assert!(named.len() > 30 && named["stepper"].len() > 10 && named["fold"].contains("passes"), "{named:?}");
    let circle = circle(&named).map(|way| way.join(" -> "));
    assert!(circle.is_none(), "modules of the runtime name one another in a circle: {}", circle.unwrap_or_default());
}

/// A file that no program names would hold tests that never run.
#[test]
fn every_file_of_tests_is_a_module_of_all() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    for folder in ["crates/gimage/tests", "crates/runtime/tests", "crates/cli/tests", "tests/tests"] {
        let all = std::fs::read_to_string(root.join(folder).join("all.rs")).unwrap();
        let entries = std::fs::read_dir(root.join(folder)).unwrap().map(|entry| entry.unwrap().path());
        let is_module = |path: &Path| path.join("mod.rs").exists() || path.extension().is_some_and(|e| e == "rs");
        for path in entries.filter(|path| is_module(path) && !path.ends_with("all.rs")) {
            let module = path.file_stem().unwrap().to_str().unwrap();
            assert!(all.lines().any(|line| line == format!("mod {module};")), "{folder}/all.rs lacks {module}");
        }
    }
}

/// Tests of the GPU that the run without an adapter left out would not be seen to skip.
#[test]
fn tests_that_the_bare_run_leaves_out_ask_for_no_adapter() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let script = std::fs::read_to_string(root.join(".ci/run")).unwrap();
    let list = |name: &str| {
        let list = script.split(&format!("local {name}=(")).nth(1).and_then(|rest| rest.split(')').next()).unwrap();
        list.split_whitespace().collect::<Vec<_>>()
    };
    let (packages, modules) = (list("packages"), list("modules"));
    assert!(packages.len() > 5 && modules.len() > 5, "{packages:?}, {modules:?}");
    let lacks = |path: &Path, words: &[&str]| {
        let text = std::fs::read_to_string(path).unwrap().to_lowercase();
        for word in words {
            assert!(!text.contains(word), "{}: {word}: take it out of the lists in .ci/run", path.display());
        }
    };
    let manifest = std::fs::read_to_string(root.join("Cargo.toml")).unwrap();
    let members = manifest.lines().find_map(|line| line.strip_prefix("members = ")).unwrap();
    let members = members.split('"').filter(|member| member.contains('/'));
    let members: Vec<_> = members.map(|member| root.join(member).join("Cargo.toml")).collect();
    for package in packages {
        let name = format!("name = \"{package}\"");
        let is_own = |path: &&PathBuf| std::fs::read_to_string(path).unwrap().lines().any(|line| line == name);
        let own = members.iter().find(is_own).unwrap_or_else(|| panic!("no package {package}"));
        lacks(own, &["wgpu", "gimage-runtime", "gimage-bench-host", "gimage-tests"]);
    }
    for module in modules {
        let tests = ["crates/runtime/tests", "crates/cli/tests", "tests/tests"]
            .map(|f| root.join(f).join(format!("{module}.rs")));
        let tests: Vec<_> = tests.iter().filter(|file| file.exists()).collect();
        tests.iter().for_each(|file| lacks(file, &["gpu", "adapter", "device", "rig::"]));
        let source = root.join("crates/runtime/src");
        let own =
            |path: &PathBuf| path.starts_with(source.join(module)) || *path == source.join(format!("{module}.rs"));
        let of_source: Vec<_> = all_files(&source).into_iter().filter(own).collect();
        of_source.iter().for_each(|file| lacks(file, &["adapter", "device("]));
        assert!(tests.len() + of_source.len() > 0, "{module}");
    }
}

#[test]
fn a_circle_is_found() {
    let list = |names: &[&str]| names.iter().map(|n| n.to_string()).collect();
    let named = [("a", list(&["b"])), ("b", list(&["c", "d"])), ("c", list(&["b"])), ("d", list(&[]))];
    let named = named.map(|(module, names)| (module.to_owned(), names)).into_iter().collect();
    assert_eq!(circle(&named), Some(vec!["b", "c", "b"]));
    let code = "use crate::{a::{x, y}, b};\nuse crate::c::{d, e}; fn f(_: crate::g::H) {}";
    assert_eq!(names_after_crate(code), ["a", "b", "c", "g"]);
}
