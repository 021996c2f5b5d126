//! The pages that name files name files that exist.

use std::path::Path;

#[test]
fn every_path_in_the_pages_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut checked = 0;
    for page in ["ARCHITECTURE.md", "README.md"] {
        let text = std::fs::read_to_string(root.join(page)).unwrap();
        let code = text.split('`').skip(1).step_by(2);
        let links = text.split("](").skip(1).filter_map(|t| t.split(')').next());
        for path in code.chain(links).filter(|p| !p.contains([' ', '\n', '<'])) {
            let known = ["crates/", "tests/", "assets", "docs", "shaders", "bench"].iter().any(|k| path.starts_with(k));
            if known || path.ends_with(".md") || path.starts_with("LICENSE") {
                assert!(root.join(path).exists(), "{page} names {path}");
                checked += 1;
            }
        }
    }
    assert!(checked > 40, "only {checked} paths found");
}
