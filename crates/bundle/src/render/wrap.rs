//! How textures go on beyond their borders.

use serde_json::Value;

/// How a texture goes on beyond 0 to 1, in one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// It repeats.
    #[default]
    Repeat,
    /// Its border goes on.
    Clamp,
    /// It repeats, every second time mirrored.
    Mirror,
}

impl Wrap {
    /// Those of a texture of a glTF document along u and v, by its sampler; both repeat without one.
    pub fn of(document: &Value, texture: &Value) -> [Self; 2] {
        let sampler = texture["sampler"].as_u64().map_or(&Value::Null, |s| &document["samplers"][s as usize]);
        ["wrapS", "wrapT"].map(|name| match sampler[name].as_u64() {
            Some(33_071) => Wrap::Clamp,
            Some(33_648) => Wrap::Mirror,
            _ => Wrap::Repeat,
        })
    }
}

/// The image of a texture of a glTF document: its own, else that of an extension for other formats. `None` without one.
pub fn texture_image(texture: &Value) -> Option<usize> {
    let of = |value: &Value| value["source"].as_u64().map(|index| index as usize);
    let others = ["EXT_texture_webp", "EXT_texture_avif", "KHR_texture_basisu", "MSFT_texture_dds"];
    of(texture).or_else(|| others.iter().find_map(|name| of(&texture["extensions"][*name])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_of_other_formats_have_images() {
        let of = |texture| texture_image(&texture);
        assert_eq!(of(serde_json::json!({"source": 3, "extensions": {"EXT_texture_webp": {"source": 1}}})), Some(3));
        assert_eq!(of(serde_json::json!({"extensions": {"EXT_texture_webp": {"source": 1}}})), Some(1));
        assert_eq!(of(serde_json::json!({"extensions": {}})), None);
        assert_eq!(of(serde_json::json!({})), None);
    }

    #[test]
    fn samplers_are_read_and_textures_without_one_repeat() {
        let document = serde_json::json!({"samplers": [{}, {"wrapS": 33071, "wrapT": 33648}, {"wrapT": 10497}]});
        let of = |texture| Wrap::of(&document, &texture);
        assert_eq!(of(serde_json::json!({"sampler": 1})), [Wrap::Clamp, Wrap::Mirror]);
        for texture in [
            serde_json::json!({}),
            serde_json::json!({"sampler": 0}),
            serde_json::json!({"sampler": 2}),
            serde_json::json!({"sampler": 9}),
        ] {
            assert_eq!(of(texture), [Wrap::Repeat; 2]);
        }
    }
}
