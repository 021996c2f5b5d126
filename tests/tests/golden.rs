//! The bytes of one small bundle, so that no change to them goes unnoticed.
//!
//! They may change with: the pipeline itself, the format, the version in `generator`, the EXR and DEFLATE encoders, and the
//! mathematical functions of the platform (`sin`, `ln`, `powf`, ... differ in the last bit between C libraries), so the
//! file holds for Linux on x86-64 with glibc and the test is not run elsewhere. After a change that is meant, remake it with
//!
//!     GIMAGE_BLESS=1 cargo test -p gimage-tests golden::

use std::fmt::Write;
use std::path::Path;

use gimage_bundle::sha256;
use gimage_tests::{asset, build, check, point};

#[test]
fn the_cape_is_the_same_to_the_last_byte() {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64", target_env = "gnu")) {
        return;
    }
    let built = build(&asset("cape.glb"), &point(256)).unwrap();
    check("cape", &built);
    let mut found = String::new();
    for (name, bytes) in built.bundle.encode().unwrap() {
        writeln!(found, "{}  {name}", sha256(&bytes)).unwrap();
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden/cape.sha256");
    if std::env::var_os("GIMAGE_BLESS").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, &found).unwrap();
        return;
    }
    let golden = std::fs::read_to_string(&path).unwrap_or_default().replace("\r\n", "\n");
    assert_eq!(golden, found, "the bundle's bytes have changed; if that is meant, remake the file with GIMAGE_BLESS=1");
}
