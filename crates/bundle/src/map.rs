//! Images in memory, the kinds of map, and the names of their files.

use std::collections::BTreeSet;

use crate::error::{Error, Result};

/// Largest number of texels per side of an image.
pub const MAX_SIDE: u32 = 16_384;

/// A float image. Row 0 is v = 0; texel (i, j) starts at `data[(j * width + i) * channels]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Floats per texel: 1 (R), 3 (R, G, B) or 4 (R, G, B, A).
    pub channels: u32,
    /// `width * height * channels` floats, texel by texel.
    pub data: Vec<f32>,
}

impl Image {
    /// An image of zeros. The sizes are not checked; [`Image::check`] does that.
    pub fn zeros(width: u32, height: u32, channels: u32) -> Self {
        let len = width as usize * height as usize * channels as usize;
        Image { width, height, channels, data: vec![0.0; len] }
    }

    /// Whether the sizes are within the format's limits and `data` has the length they say. `what` names the image in
    /// the error.
    pub fn check(&self, what: &str) -> Result<()> {
        check_size(what, self.width, self.height)?;
        let expected = u64::from(self.width) * u64::from(self.height) * u64::from(self.channels);
        if !matches!(self.channels, 1 | 3 | 4) || self.data.len() as u64 != expected {
            return Err(Error::Exr {
                file: what.into(),
                problem: format!(
                    "{} floats do not make {} x {} texels of {} channels",
                    self.data.len(),
                    self.width,
                    self.height,
                    self.channels
                ),
                hint: "give 1, 3 or 4 floats for each texel",
            });
        }
        Ok(())
    }

    /// The floats of texel (i, j); empty outside the image.
    pub fn texel(&self, i: u32, j: u32) -> &[f32] {
        if i >= self.width || j >= self.height {
            return &[];
        }
        self.at(j as usize * self.width as usize + i as usize)
    }

    /// The floats of the texel with linear index `j * width + i`; empty outside the image.
    pub fn at(&self, index: usize) -> &[f32] {
        let c = self.channels as usize;
        index.checked_mul(c).and_then(|s| self.data.get(s..s.checked_add(c)?)).unwrap_or(&[])
    }
}

/// Whether an image of `width` x `height` texels is within the format's limits: 2 to [`MAX_SIDE`] on a side, at most
/// [`crate::MAX_PARTICLES`] in all.
pub fn check_size(what: &str, width: u32, height: u32) -> Result<()> {
    let texels = u64::from(width) * u64::from(height);
    let too_large = |need: u64, limit: u32| Error::TooLarge {
        what: format!("{what}: {width} x {height} texels"),
        need,
        limit: u64::from(limit),
        hint: "choose a smaller image",
    };
    if width.max(height) > MAX_SIDE {
        return Err(too_large(u64::from(width.max(height)), MAX_SIDE));
    }
    if texels > u64::from(crate::MAX_PARTICLES) {
        return Err(too_large(texels, crate::MAX_PARTICLES));
    }
    if width < 2 || height < 2 {
        return Err(Error::Exr {
            file: what.into(),
            problem: format!("{width} x {height} texels cannot hold a surface"),
            hint: "use at least 2 x 2",
        });
    }
    Ok(())
}

/// The kind of a map. The number in `Uv`, `Color`, `Joints` and `Weights` is the set, as in glTF's `TEXCOORD_n`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum MapKind {
    /// x, y, z \[m\] and the particle code. 4 channels.
    Position,
    /// Rest lengths \[m\]: right, down, down-right, up-right; 0 = no spring. 4 channels.
    Rest,
    /// Particle mass \[kg\]. 1 channel.
    Mass,
    /// Geodesic distance \[m\] to an anchor and the anchor's particle index (-1 = none); the third is 0. 3 channels.
    Tether,
    /// Largest distance \[m\] from the position at rest: 0 holds the particle there, a negative value means no limit. 1 channel.
    Limit,
    /// How far the particle may go behind its position at rest \[m\], negative for no backstop, and the radius of the sphere that begins there
    /// \[m\]; the third is 0. 3 channels.
    Backstop,
    /// Where the mesh of the source is drawn: 0 on the skin, 1 on the cloth, between them in between. 1 channel.
    Blend,
    /// Index of the piece that the particle is tied to (-1 = none), u and v of the point there, and its distance at rest \[m\]. 4
    /// channels.
    Stitch,
    /// Unit normal of the original surface. 3 channels.
    Normal,
    /// Texture coordinates u, v as in glTF (v down); the third channel is 0. 3 channels.
    Uv(u8),
    /// Linear colour, with alpha in a fourth channel if the source has it. 3 or 4 channels.
    Color(u8),
    /// Four joint indices, whole numbers. 4 channels.
    Joints(u8),
    /// Four joint weights. 4 channels.
    Weights(u8),
    /// An attribute of the source file, by its name there, which starts with an underscore. 1, 3 or 4 channels.
    Custom(String),
}

impl MapKind {
    /// The kind with this name, or `None` for a name that this version of the format does not define.
    pub fn parse(name: &str) -> Option<Self> {
        let set = |base: &str| -> Option<u8> {
            let number = name.strip_prefix(base)?;
            // "uv0", "uv01" and "uv+1" are not names: each set has exactly one.
            match number.parse::<u8>() {
                _ if number.is_empty() => Some(0),
                Ok(n) if n > 0 && n.to_string() == number => Some(n),
                _ => None,
            }
        };
        Some(match name {
            "position" => MapKind::Position,
            "rest" => MapKind::Rest,
            "mass" => MapKind::Mass,
            "tether" => MapKind::Tether,
            "limit" => MapKind::Limit,
            "backstop" => MapKind::Backstop,
            "blend" => MapKind::Blend,
            "stitch" => MapKind::Stitch,
            "normal" => MapKind::Normal,
            _ if name.len() > 1 && name.starts_with('_') => MapKind::Custom(name.into()),
            _ => {
                return None
                    .or_else(|| set("uv").map(MapKind::Uv))
                    .or_else(|| set("color").map(MapKind::Color))
                    .or_else(|| set("joints").map(MapKind::Joints))
                    .or_else(|| set("weights").map(MapKind::Weights));
            }
        })
    }

    /// The name of the map, as the manifest has it: `position`, `uv`, `uv1`, `_THICKNESS`, ...
    pub fn name(&self) -> String {
        let set = |base: &str, n: u8| if n == 0 { base.to_string() } else { format!("{base}{n}") };
        match self {
            MapKind::Position => "position".into(),
            MapKind::Rest => "rest".into(),
            MapKind::Mass => "mass".into(),
            MapKind::Tether => "tether".into(),
            MapKind::Limit => "limit".into(),
            MapKind::Backstop => "backstop".into(),
            MapKind::Blend => "blend".into(),
            MapKind::Stitch => "stitch".into(),
            MapKind::Normal => "normal".into(),
            MapKind::Uv(n) => set("uv", *n),
            MapKind::Color(n) => set("color", *n),
            MapKind::Joints(n) => set("joints", *n),
            MapKind::Weights(n) => set("weights", *n),
            MapKind::Custom(name) => name.clone(),
        }
    }

    /// The numbers of channels that the map may have.
    pub fn channels(&self) -> &'static [u32] {
        match self {
            MapKind::Position | MapKind::Rest | MapKind::Stitch | MapKind::Joints(_) | MapKind::Weights(_) => &[4],
            MapKind::Mass | MapKind::Limit | MapKind::Blend => &[1],
            MapKind::Tether | MapKind::Backstop | MapKind::Normal | MapKind::Uv(_) => &[3],
            MapKind::Color(_) => &[3, 4],
            MapKind::Custom(_) => &[1, 3, 4],
        }
    }

    /// Whether all duplicates of a seam point must hold the same bits. Texture coordinates, colours, normals and custom
    /// attributes may differ on the two sides of a cut, as they may on a UV seam or a hard edge of the source; rest
    /// lengths belong to springs, which each side has for itself.
    pub fn agrees_across_seams(&self) -> bool {
        use MapKind::*;
        matches!(self, Position | Mass | Tether | Limit | Backstop | Blend | Joints(_) | Weights(_))
    }
}

/// File-name stems for names in order: ASCII letters, digits, `-` and `_` only, at most 64 long, never empty, no two
/// alike even where case does not count. The stem of a name depends only on it and the names before it.
pub fn file_stems<'a>(names: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let mut used = BTreeSet::new();
    names.into_iter().map(|name| unique(sanitise(name), &mut used)).collect()
}

fn sanitise(name: &str) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '_' };
    let stem: String = name.chars().map(safe).take(64).collect();
    if !stem.contains(|c: char| c.is_ascii_alphanumeric()) {
        return "piece".into();
    }
    // Device names that Windows reserves whatever the extension.
    let upper = stem.to_ascii_uppercase();
    let port = |p: &str| upper.strip_prefix(p).is_some_and(|n| n.len() == 1 && n.as_bytes()[0].is_ascii_digit());
    let device = matches!(upper.as_str(), "CON" | "PRN" | "AUX" | "NUL") || port("COM") || port("LPT");
    // A leading dash would read as an option on a command line.
    if device || stem.starts_with('-') { format!("piece_{stem}") } else { stem }
}

fn unique(stem: String, used: &mut BTreeSet<String>) -> String {
    let mut candidate = stem.clone();
    let mut n = 2;
    while !used.insert(candidate.to_ascii_lowercase()) {
        candidate = format!("{stem}_{n}");
        n += 1;
    }
    candidate
}

/// Whether a file name from a manifest is a plain image name inside the bundle. Errors name what is wrong with it.
pub fn check_file_name(name: &str) -> Result<()> {
    let problem = if name.is_empty() || name.len() > 255 {
        "is empty or longer than 255 bytes"
    } else if name.contains(['/', '\\', ':']) || name.contains("..") {
        "points out of the bundle"
    } else if name.chars().any(char::is_control) {
        "holds a control character"
    } else if !name.ends_with(".exr") || name.starts_with('.') {
        "is not the name of an .exr file"
    } else {
        return Ok(());
    };
    Err(Error::FileName { name: name.into(), problem })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        use MapKind::*;
        let custom = Custom("_THICKNESS".into());
        let maps = [Position, Rest, Mass, Tether, Limit, Backstop, Blend, Stitch, Normal];
        for kind in maps.into_iter().chain([Uv(0), Uv(1), Color(12), Joints(0), custom]) {
            assert_eq!(MapKind::parse(&kind.name()), Some(kind));
        }
        for unknown in ["", "_", "uv0", "uv01", "uv+1", "uv256", "bend", "velocity", "colour", "Position"] {
            assert_eq!(MapKind::parse(unknown), None, "{unknown}");
        }
    }

    #[test]
    fn stems_are_safe_and_unique() {
        let names = ["body", "Body", "body", "../etc", "ä ö", "日本", "", "nul", "a.b", "-rf"];
        let stems = file_stems(names);
        let expected =
            ["body", "Body_2", "body_3", "___etc", "piece", "piece_2", "piece_3", "piece_nul", "a_b", "piece_-rf"];
        assert_eq!(stems, expected);
        for stem in stems {
            check_file_name(&format!("{stem}.position.exr")).unwrap();
        }
    }

    #[test]
    fn file_names_that_leave_the_bundle_are_refused() {
        for bad in ["../a.exr", "/a.exr", "a/b.exr", "a\\b.exr", "C:a.exr", "..exr", "a.txt", "", ".exr", "a\0.exr"] {
            assert!(check_file_name(bad).is_err(), "{bad:?}");
        }
        check_file_name("body.position.exr").unwrap();
    }
}
