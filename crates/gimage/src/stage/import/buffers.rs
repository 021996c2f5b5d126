//! Buffers and buffer views, loaded when they are first used: a file whose images are missing still gives its mesh.

use std::borrow::Cow;
use std::cell::{Cell, OnceCell, RefCell};

use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use serde_json::{Map, Value};

use super::document::Document;
use super::source::{OutsideFile, sha256};
use super::{Resolver, malformed, meshopt};
use crate::error::{Error, Result};

/// The bytes behind a document.
pub(crate) struct Buffers<'a> {
    doc: &'a Document<'a>,
    bin: Option<&'a [u8]>,
    resolver: &'a Resolver<'a>,
    max_bytes: u64,
    spent: Cell<u64>,
    passed: Cell<u64>,
    loaded: Vec<OnceCell<Cow<'a, [u8]>>>,
    decompressed: Vec<OnceCell<Vec<u8>>>,
    outside: RefCell<Vec<OutsideFile>>,
}

/// A run of bytes and how far apart its elements are, if the view states it.
pub(crate) struct View<'a> {
    pub bytes: &'a [u8],
    pub stride: Option<usize>,
}

impl<'a> Buffers<'a> {
    pub fn new(doc: &'a Document<'a>, bin: Option<&'a [u8]>, resolver: &'a Resolver<'a>, max_bytes: u64) -> Self {
        let cells = |n| std::iter::repeat_with(OnceCell::new).take(n).collect();
        let decompressed = std::iter::repeat_with(OnceCell::new).take(doc.root.buffer_views.len()).collect();
        let (spent, passed, outside) = Default::default();
        Self {
            doc,
            bin,
            resolver,
            max_bytes,
            spent,
            passed,
            loaded: cells(doc.root.buffers.len()),
            decompressed,
            outside,
        }
    }

    /// The files that were read, in the order of their buffers.
    pub fn outside(&self) -> Vec<OutsideFile> {
        self.outside.take()
    }

    /// The bytes of a view, decompressed if need be.
    pub fn view(&self, index: usize) -> Result<View<'_>> {
        let element = || format!("buffer view {index}");
        let Some(view) = self.doc.root.buffer_views.get(index) else {
            return Err(self.doc.bad(element(), "there is no such view"));
        };
        let extensions = view.extensions.as_ref().map(|e| &e.others);
        let names = ["EXT_meshopt_compression", "KHR_meshopt_compression"];
        let packed = extensions.and_then(|e| names.iter().find_map(|n| e.get(*n))).and_then(Value::as_object);
        if let Some(header) = packed {
            let stride = Some(self.field(header, "byteStride", &element())? as usize);
            let cell = &self.decompressed[index];
            if cell.get().is_none() {
                let bytes = self.decompress(header, &element())?;
                // A second value cannot be there: nothing else runs in between.
                let _ = cell.set(bytes);
            }
            return Ok(View { bytes: cell.get().map_or(&[], |b| b), stride });
        }
        let (offset, length) = (view.byte_offset.map_or(0, |o| o.0), view.byte_length.0);
        let bytes = self.range(view.buffer.value(), offset, length, &element())?;
        Ok(View { bytes, stride: view.byte_stride.map(|s| s.0) })
    }

    fn field(&self, header: &Map<String, Value>, key: &str, element: &str) -> Result<u64> {
        let value = header.get(key).and_then(Value::as_u64);
        value.ok_or_else(|| self.doc.bad(element, format!("its compression has no {key}")))
    }

    fn decompress(&self, header: &Map<String, Value>, element: &str) -> Result<Vec<u8>> {
        let [buffer, length, stride, count] =
            ["buffer", "byteLength", "byteStride", "count"].map(|key| self.field(header, key, element));
        let (stride, count) = (stride?, count?);
        let offset = header.get("byteOffset").and_then(Value::as_u64).unwrap_or(0);
        let data = self.range(buffer? as usize, offset, length?, element)?;
        self.spend(stride.saturating_mul(count), element)?;
        let text = |key: &str| header.get(key).and_then(Value::as_str);
        let (mode, filter) = (text("mode").unwrap_or_default(), text("filter").unwrap_or("NONE"));
        let header = meshopt::Header { mode, filter, count: count as usize, stride: stride as usize };
        meshopt::decode(&header, data).map_err(|problem| {
            let hint = "compress it again, or decompress it with `npx @gltf-transform/cli copy in.glb out.glb`";
            malformed(self.doc.path, element, format!("meshopt compression: {problem}"), hint)
        })
    }

    /// A range of a buffer as the file has it.
    pub fn range(&self, buffer: usize, offset: u64, length: u64, element: &str) -> Result<&[u8]> {
        let bytes = self.buffer(buffer)?;
        let end = offset.checked_add(length).filter(|&end| end <= bytes.len() as u64);
        let Some(end) = end else {
            let problem = format!(
                "it takes {length} bytes from byte {offset} of buffer {buffer}, which has {} bytes",
                bytes.len()
            );
            return Err(self.doc.bad(element, problem));
        };
        Ok(&bytes[offset as usize..end as usize])
    }

    fn buffer(&self, index: usize) -> Result<&[u8]> {
        let Some(cell) = self.loaded.get(index) else {
            return Err(self.doc.bad(format!("buffer {index}"), "there is no such buffer"));
        };
        if cell.get().is_none() {
            let _ = cell.set(self.load(index)?);
        }
        Ok(cell.get().map_or(&[], |b| b))
    }

    fn load(&self, index: usize) -> Result<Cow<'a, [u8]>> {
        let element = format!("buffer {index}");
        let Some(uri) = self.doc.root.buffers[index].uri.as_deref() else {
            let bin = self.bin.filter(|_| index == 0);
            let problem = "it names no file, and there is no binary chunk for it";
            return bin.map(Cow::Borrowed).ok_or_else(|| self.doc.bad(element, problem));
        };
        self.file(uri, &element).map(Cow::Owned)
    }

    /// The bytes of a data URI, or of a file beside the document.
    pub fn file(&self, uri: &str, element: &str) -> Result<Vec<u8>> {
        if let Some(rest) = uri.strip_prefix("data:") {
            let bytes = data_uri(rest).map_err(|problem| self.doc.bad(element, problem))?;
            self.spend(bytes.len() as u64, element)?;
            return Ok(bytes);
        }
        let name = relative_path(uri).map_err(|problem| {
            let hint = "put the file beside the glTF file and name it by a relative path";
            malformed(self.doc.path, element, format!("`{uri}` {problem}"), hint)
        })?;
        let bytes = (self.resolver)(&name).map_err(|source| {
            let path = self.doc.path.parent().unwrap_or(self.doc.path).join(&name);
            Error::Io { path, source: std::io::Error::new(source.kind(), format!("{element}: {source}")) }
        })?;
        self.spend(bytes.len() as u64, element)?;
        self.outside.borrow_mut().push(OutsideFile { name, sha256: sha256(&bytes) });
        Ok(bytes)
    }

    /// Counts bytes against the cap before they are made.
    pub fn spend(&self, bytes: u64, what: &str) -> Result<()> {
        self.count(&self.spent, bytes, self.max_bytes, what)
    }

    /// Counts bytes that are read once more and not kept: primitives may share a long accessor, but not without end.
    pub fn pass(&self, bytes: u64) -> Result<()> {
        self.count(&self.passed, bytes, self.max_bytes.saturating_mul(16), "reading shared accessors")
    }

    fn count(&self, counter: &Cell<u64>, bytes: u64, limit: u64, what: &str) -> Result<()> {
        let total = counter.get().saturating_add(bytes);
        counter.set(total);
        if total <= limit {
            return Ok(());
        }
        Err(Error::TooLarge {
            what: format!("{}: {what}", self.doc.path.display()),
            need: format!("{total} bytes"),
            limit: format!("{limit} bytes"),
            hint: "raise max_bytes, or reduce the file".into(),
        })
    }
}

/// The bytes of a data URI, given what follows `data:`.
pub(super) fn data_uri(rest: &str) -> std::result::Result<Vec<u8>, String> {
    let (kind, data) = rest.split_once(',').ok_or("its data URI has no comma")?;
    if !kind.ends_with(";base64") {
        return Ok(percent_decoded(data));
    }
    let padding = GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    let engine = GeneralPurpose::new(&base64::alphabet::STANDARD, padding);
    engine.decode(data).map_err(|e| format!("its data URI is not base64 ({e})"))
}

fn percent_decoded(text: &str) -> Vec<u8> {
    let bytes = text.as_bytes();
    let hex = |at: usize| bytes.get(at).and_then(|&b| (b as char).to_digit(16));
    let (mut out, mut at) = (Vec::with_capacity(bytes.len()), 0);
    while at < bytes.len() {
        match (bytes[at], hex(at + 1), hex(at + 2)) {
            (b'%', Some(high), Some(low)) => {
                out.push((16 * high + low) as u8);
                at += 3;
            }
            (b, ..) => {
                out.push(b);
                at += 1;
            }
        }
    }
    out
}

/// A URI as a path that stays in the folder of the file: anything else could read what the user did not give.
pub(super) fn relative_path(uri: &str) -> std::result::Result<String, &'static str> {
    let scheme = uri.split_once(':').map_or("", |(s, _)| s);
    if scheme.len() == 1 || uri.starts_with(['/', '\\']) {
        return Err("is an absolute path, which is not read");
    }
    if !scheme.is_empty() && scheme.bytes().all(|b| b.is_ascii_alphanumeric() || b"+-.".contains(&b)) {
        return Err("is not a file beside this one, and nothing is fetched");
    }
    let path = String::from_utf8(percent_decoded(uri)).map_err(|_| "is not UTF-8")?.replace('\\', "/");
    if path.contains(['\0', ':']) || path.starts_with('/') {
        return Err("is not the name of a file");
    }
    let parts: Vec<&str> = path.split('/').filter(|p| !p.is_empty() && *p != ".").collect();
    if parts.contains(&"..") {
        return Err("leads out of the folder of the file");
    }
    if parts.is_empty() { Err("is not the name of a file") } else { Ok(parts.join("/")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_paths_inside_the_folder_are_read() {
        assert_eq!(relative_path("a%20b/./c.bin").unwrap(), "a b/c.bin");
        let outside =
            ["http://x/y.bin", "file:///x", "/etc/x", "../x", "a/..%2f..%2fx", "C:\\x", "%2Fx", "", "a\\..\\..\\b"];
        for uri in outside {
            assert!(relative_path(uri).is_err(), "{uri}");
        }
    }

    #[test]
    fn data_uris_may_lack_padding() {
        assert_eq!(data_uri("application/octet-stream;base64,AQI=").unwrap(), [1, 2]);
        assert_eq!(data_uri(";base64,AQI").unwrap(), [1, 2]);
        assert_eq!(data_uri(",a%20b").unwrap(), b"a b");
        assert!(data_uri(";base64,?").is_err());
    }
}
