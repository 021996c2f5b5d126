//! Tells what a file is by its first bytes, and names the usual impostors.

use std::path::Path;

use super::malformed;
use crate::error::{Error, Result};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Glb,
    Gltf,
    Obj,
}

impl Format {
    /// The contradiction between a file's name and its content, if there is one.
    pub fn contradicts(self, name: &Path) -> Option<String> {
        let ext = extension(name);
        let want = match self {
            Format::Glb => "glb",
            Format::Gltf => "gltf",
            Format::Obj => "obj",
        };
        // Avatars are binary glTF by another name.
        let other = want == "glb" && ext == "vrm";
        (ext != want && !other)
            .then(|| format!("{} holds {want}", name.file_name().unwrap_or_default().to_string_lossy()))
    }
}

fn extension(name: &Path) -> String {
    name.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

const CONVERT: &str = "open it in Blender and export it as .glb";

/// First bytes, what they are, and what to do.
const OTHERS: &[(&[u8], &str, &str)] = &[
    (b"PK\x03\x04", "a ZIP archive (also .usdz, .3mf)", "unpack it and give the .glb, .gltf or .obj inside"),
    (b"\x1f\x8b", "gzip data", "unpack it with gunzip"),
    (b"Rar!", "a RAR archive", "unpack it and give the .glb, .gltf or .obj inside"),
    (b"7z\xbc\xaf", "a 7z archive", "unpack it and give the .glb, .gltf or .obj inside"),
    (b"Kaydara FBX", "FBX", CONVERT),
    (b"; FBX", "FBX", CONVERT),
    (b"BLENDER", "a Blender file", CONVERT),
    (b"#usda", "USD", CONVERT),
    (b"PXR-USDC", "USD", CONVERT),
    (b"ply\n", "PLY", CONVERT),
    (b"ply\r", "PLY", CONVERT),
    (b"solid ", "STL", CONVERT),
    (b"DRACO", "a bare Draco stream", "wrap it in a .glb"),
    (b"\x89PNG", "a PNG image", "give the mesh, not its texture"),
    (b"\xff\xd8\xff", "a JPEG image", "give the mesh, not its texture"),
    (b"%PDF", "a PDF document", "give the mesh itself"),
];

/// The format of the file, or a refusal that says what it is instead.
pub(crate) fn sniff(name: &Path, bytes: &[u8]) -> Result<Format> {
    let file = "file";
    if bytes.is_empty() {
        return Err(Error::Empty {
            path: name.to_path_buf(),
            problem: "the file has no bytes".into(),
            hint: "download or export it again".into(),
        });
    }
    if bytes.starts_with(b"version https://git-lfs") {
        let problem = "it is a Git LFS pointer, not the model";
        return Err(malformed(name, file, problem, "run `git lfs pull` in its repository"));
    }
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let starts = |word: &[u8]| text.len() >= word.len() && text[..word.len()].eq_ignore_ascii_case(word);
    if starts(b"<!doctype") || starts(b"<html") {
        let hint = "the download gave a web page: download the file itself";
        return Err(malformed(name, file, "it is an HTML page, not a model", hint));
    }
    if bytes.starts_with(b"glTF") {
        return Ok(Format::Glb);
    }
    if text.first() == Some(&b'{') {
        return Ok(Format::Gltf);
    }
    if let Some((_, what, hint)) = OTHERS.iter().find(|(magic, ..)| bytes.starts_with(magic)) {
        return Err(Error::Unsupported { path: name.to_path_buf(), feature: (*what).into(), hint: (*hint).into() });
    }
    if starts(b"<?xml") || starts(b"<collada") {
        let feature = "XML (COLLADA, X3D, SVG)".into();
        return Err(Error::Unsupported { path: name.to_path_buf(), feature, hint: CONVERT.into() });
    }
    match extension(name).as_str() {
        "obj" if !bytes[..bytes.len().min(1024)].contains(&0) => Ok(Format::Obj),
        "obj" => Err(malformed(name, file, "it holds binary data, not OBJ text", "export it again as Wavefront OBJ")),
        "glb" => Err(malformed(name, file, "it does not start with `glTF`", "download or export it again")),
        "gltf" => Err(malformed(name, file, "it does not start with `{`", "download or export it again")),
        other => Err(Error::Unsupported {
            path: name.to_path_buf(),
            feature: format!("a file of type `.{other}`"),
            hint: "give a .glb, .gltf or .obj file".into(),
        }),
    }
}
