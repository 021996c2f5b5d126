//! The files that the manifest of a bundle speaks of, whatever its version, read without building the rest of it.

use std::collections::BTreeSet;
use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, IgnoredAny, MapAccess, Visitor};

use crate::budget;
use crate::manifest::{FORMAT, MANIFEST_FILE};
use crate::map::check_file_name;

/// Names of files that a writer may replace.
pub(super) struct Listed(BTreeSet<String>);

impl Listed {
    /// Those of a manifest; `None` if it is not one of a gimage bundle.
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        #[derive(Deserialize)]
        struct Head {
            format: String,
            #[serde(default)]
            files: Names,
            #[serde(default)]
            pieces: Vec<Piece>,
        }
        #[derive(Deserialize)]
        struct Piece {
            #[serde(default)]
            maps: Values,
        }
        budget::check_manifest(bytes).ok()?;
        let head: Head = serde_json::from_slice(bytes).ok()?;
        let maps = head.pieces.into_iter().flat_map(|piece| piece.maps.0);
        // Images alone: a crafted manifest must not have other files removed.
        let images = head.files.0.into_iter().chain(maps).filter(|name| check_file_name(name).is_ok());
        let own = [MANIFEST_FILE, "render.glb"].map(String::from);
        (head.format == FORMAT).then(|| Listed(images.chain(own).collect()))
    }

    pub fn has(&self, name: &str) -> bool {
        self.0.contains(name)
    }
}

/// The keys of an object.
#[derive(Default)]
struct Names(Vec<String>);

/// The texts among the values of an object.
#[derive(Default)]
struct Values(Vec<String>);

impl<'de> Deserialize<'de> for Names {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Keys;
        impl<'de> Visitor<'de> for Keys {
            type Value = Names;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("an object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Names, A::Error> {
                let mut names = Vec::new();
                while let Some((name, IgnoredAny)) = map.next_entry()? {
                    names.push(name);
                }
                Ok(Names(names))
            }
        }
        from.deserialize_map(Keys)
    }
}

impl<'de> Deserialize<'de> for Values {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Texts;
        impl<'de> Visitor<'de> for Texts {
            type Value = Values;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("an object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Values, A::Error> {
                let mut values = Vec::new();
                while let Some((IgnoredAny, value)) = map.next_entry()? {
                    values.push(value);
                }
                Ok(Values(values))
            }
        }
        from.deserialize_map(Texts)
    }
}
