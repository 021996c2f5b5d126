//! A bundle in memory, and its encoding as files in memory.

use std::collections::BTreeMap;
use std::fmt::Write;

use sha2::{Digest, Sha256};

use crate::body::{self, Body};
use crate::budget;
use crate::error::{Error, Result};
use crate::exr_header::max_file_bytes;
use crate::exr_io::{decode_exr_sized, encode_exr};
use crate::manifest::{BodyEntry, FileRecord, MANIFEST_FILE, MAX_MANIFEST_BYTES, Manifest, PieceEntry};
use crate::map::{Image, MapKind, check_size, file_stems};
use crate::render::{MAX_RENDER_BYTES, RENDER_FILE};
use crate::validate::Fault;

/// A bundle in memory: a manifest and the images that it describes.
#[derive(Clone, Debug, PartialEq)]
pub struct Bundle {
    /// The manifest. `files` and the `maps` of the pieces are those of the last reading; encoding rebuilds them
    /// from `images`.
    pub manifest: Manifest,
    /// The images, by index of the piece and kind of map. Each has the size of its piece.
    pub images: BTreeMap<(usize, MapKind), Image>,
    /// The bytes of `render.glb`, the mesh of the source bound to the pieces, if the bundle has one; the manifest then has
    /// [`Manifest::render`].
    pub render: Option<Vec<u8>>,
    /// The surface of the body that the cloth is worn on, if the bundle has one. [`Manifest::body`] is that of the last reading; encoding
    /// rebuilds it.
    pub body: Option<Body>,
}

impl Bundle {
    /// A bundle without pieces. `generator` names the program and its version.
    pub fn new(generator: &str) -> Self {
        Bundle { manifest: Manifest::new(generator), images: BTreeMap::new(), render: None, body: None }
    }

    /// Appends a piece of `width` x `height` texels after the indices already taken, and returns its index. Errors where
    /// the size is not within the limits or the bundle would hold more than [`crate::MAX_PARTICLES`] texels.
    pub fn add_piece(&mut self, name: &str, width: u32, height: u32) -> Result<usize> {
        check_size(&format!("piece {name}"), width, height)?;
        let first_particle = self.manifest.texels();
        let end = u64::from(first_particle) + u64::from(width) * u64::from(height);
        if end > u64::from(crate::MAX_PARTICLES) {
            return Err(Error::TooLarge {
                what: format!("piece {name} and those before it, in texels"),
                need: end,
                limit: u64::from(crate::MAX_PARTICLES),
                hint: "use fewer texels, or several bundles",
            });
        }
        let entry = PieceEntry { name: name.into(), width, height, first_particle, ..PieceEntry::default() };
        self.manifest.pieces.push(entry);
        Ok(self.manifest.pieces.len() - 1)
    }

    /// Inserts an image, and replaces one of the same kind. Errors where the piece does not exist, or the image does not
    /// have its size or a number of channels that the kind allows.
    pub fn insert(&mut self, piece: usize, kind: MapKind, image: Image) -> Result<()> {
        self.check_image(piece, &kind, &image)?;
        self.images.insert((piece, kind), image);
        Ok(())
    }

    /// The image of a kind, if the piece has it.
    pub fn image(&self, piece: usize, kind: &MapKind) -> Option<&Image> {
        self.images.get(&(piece, kind.clone()))
    }

    /// The file of a map: as the manifest names it, else as encoding would if there were no other piece.
    pub fn file_name(&self, piece: usize, kind: &MapKind) -> String {
        let Some(entry) = self.manifest.pieces.get(piece) else { return MANIFEST_FILE.into() };
        let named = entry.maps.get(&kind.name()).cloned();
        named.unwrap_or_else(|| format!("{}.{}.exr", entry.name, kind.name()))
    }

    /// All files of the bundle by name, manifest.json among them with the SHA-256 of each other file. The same bundle
    /// gives the same bytes. Errors on images that do not fit their piece, on a piece without positions, and where
    /// [`Manifest::to_bytes`] does.
    pub fn encode(&self) -> Result<BTreeMap<String, Vec<u8>>> {
        let mut manifest = self.manifest.clone();
        manifest.files.clear();
        let stems = file_stems(manifest.pieces.iter().map(|p| p.name.as_str()));
        for piece in &mut manifest.pieces {
            piece.maps.clear();
        }
        let mut files = BTreeMap::new();
        for ((piece, kind), image) in &self.images {
            self.check_image(*piece, kind, image)?;
            let entry = &mut manifest.pieces[*piece];
            let name = file_name(&stems[*piece], kind, entry);
            let bytes = encode_exr(image)?;
            manifest.files.insert(name.clone(), FileRecord { sha256: sha256(&bytes), bytes: bytes.len() as u64 });
            entry.maps.insert(kind.name(), name.clone());
            files.insert(name, bytes);
        }
        for piece in &manifest.pieces {
            require_position(piece)?;
        }
        manifest.body = self.body.as_ref().map(Body::entry);
        for (name, image) in self.body.iter().flat_map(Body::images) {
            let bytes = encode_exr(&image)?;
            manifest.files.insert(name.clone(), FileRecord { sha256: sha256(&bytes), bytes: bytes.len() as u64 });
            files.insert(name, bytes);
        }
        if let Some(bytes) = &self.render {
            let record = FileRecord { sha256: sha256(bytes), bytes: bytes.len() as u64 };
            manifest.files.insert(RENDER_FILE.into(), record);
            files.insert(RENDER_FILE.into(), bytes.clone());
        }
        files.insert(MANIFEST_FILE.into(), manifest.to_bytes()?);
        Ok(files)
    }

    /// Reads a bundle. `read` is given a file's name and the most bytes it can have, and returns its bytes; it should
    /// refuse a longer file before reading it. Errors on the first thing that cannot be read: a bad manifest, a missing
    /// or damaged file, a wrong size or checksum, and before the first image is decoded where all together take more than
    /// [`crate::MAX_IMAGE_BYTES`]: to count them, files of colours and custom maps are read twice. [`crate::validate`] checks the contents of the images.
    pub fn decode(read: impl FnMut(&str, u64) -> Result<Vec<u8>>) -> Result<Self> {
        Self::decode_with(read, Err)
    }

    /// As [`Bundle::decode`] from files in memory, by name. A host that does not draw the mesh of the source may leave `render.glb` out:
    /// the bundle then has none.
    pub fn from_files(files: &BTreeMap<String, Vec<u8>>) -> Result<Self> {
        let read = |name: &str, _| files.get(name).cloned().ok_or_else(|| Error::Missing { file: name.into() });
        let mut bundle = Self::decode_with(read, |error| match error {
            Error::Missing { file } if file == RENDER_FILE => Ok(()),
            other => Err(other),
        })?;
        if bundle.render.is_none() {
            bundle.manifest.render = None;
        }
        Ok(bundle)
    }

    /// As [`Bundle::decode`], but leaves out images that cannot be read, keeps those with a wrong checksum, and returns
    /// a fault for each. Errors only where the manifest cannot be read, or the images take too much memory.
    pub fn decode_lenient(read: impl FnMut(&str, u64) -> Result<Vec<u8>>) -> Result<(Self, Vec<Fault>)> {
        let mut faults = Vec::new();
        let bundle = Self::decode_with(read, |error| {
            faults.push(Fault::from_error(&error));
            Ok(())
        })?;
        Ok((bundle, faults))
    }

    fn decode_with(
        mut read: impl FnMut(&str, u64) -> Result<Vec<u8>>,
        mut trouble: impl FnMut(Error) -> Result<()>,
    ) -> Result<Self> {
        let manifest = Manifest::from_bytes(&read(MANIFEST_FILE, MAX_MANIFEST_BYTES)?)?;
        let cap = |width, height| max_file_bytes(width, height, 4);
        budget::check_images(&manifest, &mut read, cap)?;
        let mut images = BTreeMap::new();
        for (index, piece) in manifest.pieces.iter().enumerate() {
            if let Err(error) = require_position(piece) {
                trouble(error)?;
            }
            for (map, file) in &piece.maps {
                // A map that this version does not define is for another reader.
                let Some(kind) = MapKind::parse(map) else { continue };
                match read_image(&mut read, piece, &kind, file, manifest.files.get(file)) {
                    Ok((image, checksum)) => {
                        if let Err(error) = checksum {
                            trouble(error)?;
                        }
                        images.insert((index, kind), image);
                    }
                    Err(error) => trouble(error)?,
                }
            }
        }
        let mut render = None;
        if manifest.render.is_some() {
            match read_render(&mut read, manifest.files.get(RENDER_FILE)) {
                Ok((bytes, checksum)) => {
                    if let Err(error) = checksum {
                        trouble(error)?;
                    }
                    render = Some(bytes);
                }
                Err(error) => trouble(error)?,
            }
        }
        let mut body = None;
        if let Some(entry) = &manifest.body {
            match read_body(&mut read, entry, &manifest) {
                Ok((found, checksum)) => {
                    if let Err(error) = checksum {
                        trouble(error)?;
                    }
                    body = Some(found);
                }
                Err(error) => trouble(error)?,
            }
        }
        Ok(Bundle { manifest, images, render, body })
    }

    fn check_image(&self, piece: usize, kind: &MapKind, image: &Image) -> Result<()> {
        let bad = |piece: &str, problem: String, hint| {
            Err(Error::Map { piece: piece.into(), map: kind.name(), problem, hint })
        };
        let Some(entry) = self.manifest.pieces.get(piece) else {
            return bad(&piece.to_string(), "there is no piece of this index".into(), "add the piece first");
        };
        if (image.width, image.height) != (entry.width, entry.height) {
            let problem =
                format!("{} x {} texels for a piece of {} x {}", image.width, image.height, entry.width, entry.height);
            return bad(&entry.name, problem, "give every map the size of its piece");
        }
        if !kind.channels().contains(&image.channels) {
            return bad(
                &entry.name,
                format!("{} channels", image.channels),
                "see FORMAT.md for the channels of each map",
            );
        }
        if MapKind::parse(&kind.name()).as_ref() != Some(kind) {
            return bad(
                &entry.name,
                "its name is not allowed".into(),
                "start the names of custom attributes with an underscore",
            );
        }
        image.check(&kind.name())
    }
}

/// SHA-256 as 64 lower-case hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::with_capacity(64), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

fn require_position(piece: &PieceEntry) -> Result<()> {
    if piece.maps.contains_key("position") {
        return Ok(());
    }
    Err(Error::Map {
        piece: piece.name.clone(),
        map: "position".into(),
        problem: "is missing".into(),
        hint: "every piece needs one; build the bundle again",
    })
}

/// `<stem>.<map>.exr`; names of custom attributes are made safe and, where two of a piece fall together, numbered.
fn file_name(stem: &str, kind: &MapKind, piece: &PieceEntry) -> String {
    let MapKind::Custom(name) = kind else { return format!("{stem}.{}.exr", kind.name()) };
    let map = file_stems([name.as_str()]).pop().unwrap_or_default();
    let taken = |candidate: &str| piece.maps.values().any(|f| f.eq_ignore_ascii_case(candidate));
    let mut candidate = format!("{stem}.{map}.exr");
    let mut n = 2;
    while taken(&candidate) {
        candidate = format!("{stem}.{map}_{n}.exr");
        n += 1;
    }
    candidate
}

/// The image, and whether its bytes are those that the manifest records.
fn read_image(
    read: &mut impl FnMut(&str, u64) -> Result<Vec<u8>>,
    piece: &PieceEntry,
    kind: &MapKind,
    file: &str,
    record: Option<&FileRecord>,
) -> Result<(Image, Result<()>)> {
    let bytes = read(file, max_file_bytes(piece.width, piece.height, 4))?;
    let sound = record.is_none_or(|r| r.bytes == bytes.len() as u64 && r.sha256 == sha256(&bytes));
    let checksum = if sound { Ok(()) } else { Err(Error::Checksum { file: file.into() }) };
    match decode_exr_sized(file, &bytes, piece.width, piece.height, kind.channels()) {
        Ok(image) => Ok((image, checksum)),
        Err(error) => Err(error),
    }
}

/// The surface of a body, and whether its files are those that the manifest records.
fn read_body(
    read: &mut impl FnMut(&str, u64) -> Result<Vec<u8>>,
    entry: &BodyEntry,
    manifest: &Manifest,
) -> Result<(Body, Result<()>)> {
    let (mut images, mut checksum) = (Vec::new(), Ok(()));
    for file in body::files(entry) {
        let (width, height) = file.size;
        check_size(&file.name, width, height)?;
        let bytes = read(&file.name, max_file_bytes(width, height, 4))?;
        let record = manifest.files.get(&file.name);
        if !record.is_none_or(|r| r.bytes == bytes.len() as u64 && r.sha256 == sha256(&bytes)) {
            checksum = Err(Error::Checksum { file: file.name.clone() });
        }
        images.push(decode_exr_sized(&file.name, &bytes, width, height, &[4])?);
    }
    Ok((Body::from_images(entry, &images)?, checksum))
}

/// The bytes of `render.glb`, and whether they are those that the manifest records.
fn read_render(
    read: &mut impl FnMut(&str, u64) -> Result<Vec<u8>>,
    record: Option<&FileRecord>,
) -> Result<(Vec<u8>, Result<()>)> {
    let bytes = read(RENDER_FILE, record.map_or(MAX_RENDER_BYTES, |r| r.bytes.min(MAX_RENDER_BYTES)))?;
    let sound = record.is_none_or(|r| r.bytes == bytes.len() as u64 && r.sha256 == sha256(&bytes));
    Ok((bytes, if sound { Ok(()) } else { Err(Error::Checksum { file: RENDER_FILE.into() }) }))
}

#[cfg(test)]
#[path = "bundle_tests.rs"]
pub(crate) mod tests;
