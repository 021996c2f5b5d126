//! Writes the sample garments into a folder: `make-assets assets`; with `--cape` only the figure in a cape, `figure_cape.glb`, which the
//! repository does not hold.

use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut args = std::env::args_os().skip(1);
    let folder = args.next().map(PathBuf::from);
    let flag = args.next();
    let files = match (&flag, &folder) {
        (None, Some(_)) => gimage_assets::all().into_iter().chain([("figure.glb", gimage_assets::figure())]).collect(),
        (Some(flag), Some(_)) if flag == "--cape" => vec![("figure_cape.glb", gimage_assets::figure_in_cape())],
        _ => Vec::new(),
    };
    let Some(folder) = folder.filter(|_| !files.is_empty()) else {
        eprintln!("usage: make-assets FOLDER [--cape]");
        return ExitCode::from(2);
    };
    for (name, bytes) in files {
        if let Err(e) = std::fs::write(folder.join(name), &bytes) {
            eprintln!("cannot write {}: {e}", folder.join(name).display());
            return ExitCode::FAILURE;
        }
        eprintln!("{name}: {} bytes", bytes.len());
    }
    ExitCode::SUCCESS
}
