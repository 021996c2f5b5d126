//! Files that the page loads.

use std::fs;
use std::path::{Path, PathBuf};

use tiny_http::{Header, Request, Response};
use wasm_bindgen_cli_support::Bindgen;

use crate::Error;

/// The page, its code, and the folder of the bundle.
pub struct Files {
    made: tempfile::TempDir,
    bundle: PathBuf,
}

impl Files {
    /// Makes the JavaScript around the code.
    pub fn new(wasm: &Path, bundle: &Path) -> Result<Self, Error> {
        if !wasm.is_file() {
            let build = "cargo build -p gimage-web --release --target wasm32-unknown-unknown";
            return Err(format!("{} is not there: make it by `{build}`, or name it with --wasm", wasm.display()).into());
        }
        // Refuses what is not a bundle before a browser does.
        gimage_bundle::dir::read_dir(bundle)?;
        let made = tempfile::tempdir()?;
        let mut bindgen = Bindgen::new();
        bindgen.input_path(wasm).out_name("gimage_web").typescript(false).omit_default_module_path(false);
        bindgen.web(true).and_then(|b| b.generate(made.path())).map_err(|e| format!("{}: {e:#}", wasm.display()))?;
        fs::write(made.path().join("index.html"), include_str!("../../index.html"))?;
        Ok(Files { made, bundle: bundle.into() })
    }

    /// Answers a request for a file.
    pub fn answer(&self, request: Request) -> Result<(), Error> {
        let url = request.url().split('?').next().unwrap_or_default().trim_start_matches('/').to_string();
        let (folder, name) = match url.strip_prefix("bundle/") {
            Some(name) => (self.bundle.as_path(), name),
            None => (self.made.path(), if url.is_empty() { "index.html" } else { &url }),
        };
        let file = inside(folder, name);
        let kind = match Path::new(name).extension().and_then(|e| e.to_str()) {
            Some("html") => "text/html; charset=utf-8",
            Some("js") => "text/javascript",
            Some("wasm") => "application/wasm",
            Some("json") => "application/json",
            _ => "application/octet-stream",
        };
        let kind = Header::from_bytes("Content-Type", kind).map_err(|()| "a header")?;
        match file.and_then(|f| fs::read(f).ok()) {
            Some(bytes) => request.respond(Response::from_data(bytes).with_header(kind))?,
            None => request.respond(Response::from_string("no such file").with_status_code(404))?,
        }
        Ok(())
    }
}

/// A file in a folder by its plain name: no other folder is served, and no device.
fn inside(folder: &Path, name: &str) -> Option<PathBuf> {
    let plain = Path::new(name).file_name().is_some_and(|n| n == name);
    Some(folder.join(name)).filter(|file| plain && file.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_other_folder_is_served() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("in")).unwrap();
        fs::write(folder.path().join("in/a.exr"), []).unwrap();
        fs::write(folder.path().join("secret"), []).unwrap();
        let secret = folder.path().join("secret");
        let served = |name: &str| inside(&folder.path().join("in"), name).is_some();
        assert!(served("a.exr"));
        for name in ["", ".", "..", "../secret", "x/../../secret", "/dev/zero", secret.to_str().unwrap(), "b.exr"] {
            assert!(!served(name), "{name}");
        }
    }
}
