//! Writes the sample garments into a folder: `make-assets assets`; with `--cape` only the figure in a cape, `figure_cape.glb`, which the
//! repository does not hold.

use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut args = std::env::args_os().skip(1);
    let (Some(folder), cape) = (args.next().map(PathBuf::from), args.next()) else {
        eprintln!("usage: make-assets FOLDER [--cape]");
        return ExitCode::from(2);
    };
    let files = match cape {
        Some(flag) if flag == "--cape" => vec![("figure_cape.glb", gimage_assets::figure_in_cape())],
        Some(_) => {
            eprintln!("usage: make-assets FOLDER [--cape]");
            return ExitCode::from(2);
        }
        None => gimage_assets::all().into_iter().chain([("figure.glb", gimage_assets::figure())]).collect(),
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
