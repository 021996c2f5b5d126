//! The pages name only files that exist.

use std::path::{Path, PathBuf};

/// Folders that a page may leave out of a path, as a table's heading names them.
const FOLDERS: [&str; 4] = ["", "crates/gimage/src", "crates/runtime/src", "crates/bundle/src"];
/// What a path from the root of the repository begins with.
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
