//! Memory limits for reading a bundle, checked before memory is allocated.
//!
//! A file of a few megabytes can describe gigabytes: an image of zeros is packed a thousand times, and each `{}` of a list
//! becomes a whole record. Images are counted from the manifest and the headers of the files, lists and values of the
//! manifest by a pass over its text that keeps nothing.

use std::cell::{Cell, RefCell};
use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, MapAccess, SeqAccess, Visitor};

use crate::body;
use crate::error::{Error, Result};
use crate::exr_header::read_header;
use crate::manifest::{Manifest, unreadable, within_cap};
use crate::map::MapKind;

/// Largest size of all images of a bundle in memory: 4 GiB. Sixty-four floats per texel at the largest number of texels that the format
/// allows.
pub const MAX_IMAGE_BYTES: u64 = 4 << 30;
/// Largest number of objects in a manifest; each takes up to 700 bytes in memory.
pub const MAX_MANIFEST_OBJECTS: u64 = 1 << 19;
/// Largest number of values in a manifest: objects, lists, numbers, texts, ...
pub const MAX_MANIFEST_VALUES: u64 = 1 << 22;

/// The most entries of a list of the manifest.
pub const MAX_PIECES: u64 = 1 << 16;
/// See [`MAX_PIECES`].
pub const MAX_ACCESSORIES: u64 = 1 << 17;
/// See [`MAX_PIECES`].
pub const MAX_JOINTS: u64 = 1 << 16;
/// See [`MAX_PIECES`].
pub const MAX_REPAIRS: u64 = 1 << 16;
/// See [`MAX_PIECES`].
pub const MAX_COLLIDERS: u64 = 1 << 16;

/// A list of the manifest by name, with its limit.
type List = (&'static str, u64);

const LISTS: [List; 6] = [
    ("pieces", MAX_PIECES),
    ("components", MAX_PIECES),
    ("accessories", MAX_ACCESSORIES),
    ("joints", MAX_JOINTS),
    ("repairs", MAX_REPAIRS),
    ("colliders", MAX_COLLIDERS),
];

/// Refuses a manifest that is larger, or has longer lists or more values, than a bundle may have. One pass over the text,
/// without an allocation for what it holds.
pub(crate) fn check_manifest(bytes: &[u8]) -> Result<()> {
    within_cap(bytes.len() as u64)?;
    let count = Count::default();
    let mut text = serde_json::Deserializer::from_slice(bytes);
    let counted = Item { count: &count, list: None }.deserialize(&mut text).and_then(|()| text.end());
    match (count.fault.take(), counted) {
        (Some(error), _) => Err(error),
        (None, Err(error)) => Err(unreadable(error.to_string())),
        (None, Ok(())) => Ok(()),
    }
}

/// Refuses a manifest in memory whose lists are too long to be read back.
pub(crate) fn check_lists(manifest: &Manifest) -> Result<()> {
    let joints = manifest.skeleton.as_ref().map_or(0, |s| s.joints.len());
    let (pieces, components) = (manifest.pieces.len(), manifest.components.len());
    let lengths =
        [pieces, components, manifest.accessories.len(), joints, manifest.repairs.len(), manifest.colliders.len()];
    match LISTS.iter().zip(lengths).find(|((_, limit), length)| *length as u64 > *limit) {
        Some((list, length)) => Err(too_long(*list, length as u64)),
        None => Ok(()),
    }
}

fn too_long((name, limit): List, need: u64) -> Error {
    let hint = match name {
        "accessories" => "join loose parts with --weld METRES",
        _ => "no valid bundle needs as many",
    };
    Error::TooLarge { what: format!("manifest.json, entries of `{name}`"), need, limit, hint }
}

/// Refuses a bundle whose images take more than [`MAX_IMAGE_BYTES`] in memory. The manifest gives the size of each; where
/// a kind of map leaves the number of channels open, `read` brings the file, and its header says. A file that cannot be
/// read counts as large as it may be.
pub(crate) fn check_images(
    manifest: &Manifest,
    read: &mut impl FnMut(&str, u64) -> Result<Vec<u8>>,
    cap: impl Fn(u32, u32) -> u64,
) -> Result<()> {
    let mut need = 0_u64;
    for piece in &manifest.pieces {
        let texels = u64::from(piece.width) * u64::from(piece.height);
        for (map, file) in &piece.maps {
            let Some(kind) = MapKind::parse(map) else { continue };
            let channels = match kind.channels() {
                [one] => *one,
                several => {
                    let most = several.iter().copied().max().unwrap_or(4);
                    let bytes = read(file, cap(piece.width, piece.height));
                    bytes.and_then(|bytes| read_header(file, &bytes)).map_or(most, |header| header.channels.min(most))
                }
            };
            need = need.saturating_add(texels * u64::from(channels) * 4);
        }
    }
    for file in manifest.body.iter().flat_map(body::files) {
        need = need.saturating_add(u64::from(file.size.0) * u64::from(file.size.1) * 16);
    }
    if need <= MAX_IMAGE_BYTES {
        return Ok(());
    }
    Err(Error::TooLarge {
        what: "all images of the bundle together, in bytes of memory".into(),
        need,
        limit: MAX_IMAGE_BYTES,
        hint: "use fewer texels or fewer maps, or several bundles",
    })
}

#[derive(Default)]
struct Count {
    values: Cell<u64>,
    objects: Cell<u64>,
    fault: RefCell<Option<Error>>,
}

impl Count {
    fn up<E: serde::de::Error>(&self, counter: &Cell<u64>, limit: u64, what: &str) -> std::result::Result<(), E> {
        counter.set(counter.get() + 1);
        if counter.get() <= limit {
            return Ok(());
        }
        let hint = "no valid bundle needs as many; build it again";
        Err(self.fail(Error::TooLarge { what: format!("manifest.json, {what}"), need: counter.get(), limit, hint }))
    }

    fn fail<E: serde::de::Error>(&self, error: Error) -> E {
        let short = E::custom(&error);
        self.fault.replace(Some(error));
        short
    }
}

/// A value, counted and dropped; `list` is its limit if it is one of [`LISTS`].
#[derive(Clone, Copy)]
struct Item<'a> {
    count: &'a Count,
    list: Option<List>,
}

impl<'de> DeserializeSeed<'de> for Item<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, from: D) -> std::result::Result<(), D::Error> {
        self.count.up(&self.count.values, MAX_MANIFEST_VALUES, "values of all kinds")?;
        from.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Item<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_bool<E>(self, _: bool) -> std::result::Result<(), E> {
        Ok(())
    }

    fn visit_i64<E>(self, _: i64) -> std::result::Result<(), E> {
        Ok(())
    }

    fn visit_u64<E>(self, _: u64) -> std::result::Result<(), E> {
        Ok(())
    }

    fn visit_f64<E>(self, _: f64) -> std::result::Result<(), E> {
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> std::result::Result<(), E> {
        Ok(())
    }

    fn visit_unit<E>(self) -> std::result::Result<(), E> {
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> std::result::Result<(), A::Error> {
        let mut length = 0;
        while list.next_element_seed(Item { list: None, ..self })?.is_some() {
            length += 1;
            if let Some(limit) = self.list.filter(|(_, limit)| length > *limit) {
                return Err(self.count.fail(too_long(limit, length)));
            }
        }
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<(), A::Error> {
        self.count.up(&self.count.objects, MAX_MANIFEST_OBJECTS, "objects")?;
        while let Some(list) = map.next_key_seed(Key)? {
            map.next_value_seed(Item { list, ..self })?;
        }
        Ok(())
    }
}

/// The name of a field: whether it is a list with a limit.
struct Key;

impl<'de> DeserializeSeed<'de> for Key {
    type Value = Option<List>;

    fn deserialize<D: Deserializer<'de>>(self, from: D) -> std::result::Result<Self::Value, D::Error> {
        from.deserialize_str(self)
    }
}

impl<'de> Visitor<'de> for Key {
    type Value = Option<List>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a name")
    }

    fn visit_str<E>(self, name: &str) -> std::result::Result<Self::Value, E> {
        Ok(LISTS.into_iter().find(|(list, _)| *list == name))
    }
}

#[cfg(test)]
#[path = "budget_tests.rs"]
mod tests;
