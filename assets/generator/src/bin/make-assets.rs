//! Writes the sample garments into a folder: `make-assets assets`.

use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        eprintln!("usage: make-assets FOLDER");
        return ExitCode::from(2);
    };
    for (name, bytes) in gimage_assets::all().into_iter().chain([("figure.glb", gimage_assets::figure())]) {
        if let Err(e) = std::fs::write(folder.join(name), &bytes) {
            eprintln!("cannot write {}: {e}", folder.join(name).display());
            return ExitCode::FAILURE;
        }
        eprintln!("{name}: {} bytes", bytes.len());
    }
    ExitCode::SUCCESS
}
