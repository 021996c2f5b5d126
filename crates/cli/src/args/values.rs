//! Readers of the values of arguments.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use gimage::colliders::{ColliderSource, Kind};
use gimage::options::{Choice, range};
use gimage_runtime::Material;

/// Reads a number in the range of an option of the library.
pub fn number(name: &'static str) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| {
        let number = text.parse::<f64>().map_err(|_| format!("`{text}` is not a number"))?;
        let range = range(name);
        if range.holds(&[number]) { Ok(number) } else { Err(format!("give {}", range.words())) }
    }
}

/// Reads one of the words of an option of the library.
pub fn choice<T: Choice + Send + Sync>() -> impl TypedValueParser<Value = T> {
    let words = PossibleValuesParser::new(T::ALL.iter().map(|(name, _)| *name));
    words.try_map(|word| T::ALL.iter().find(|(name, _)| *name == word).map(|(_, value)| *value).ok_or("not a choice"))
}

/// Reads the name of a shape.
pub fn shape() -> impl TypedValueParser<Value = Kind> {
    let words = PossibleValuesParser::new(Kind::ALL.map(Kind::name));
    words.try_map(|word| Kind::ALL.into_iter().find(|k| k.name() == word).ok_or("not a shape"))
}

/// Reads where colliders come from.
pub fn collider_source() -> impl TypedValueParser<Value = ColliderSource> {
    let words = PossibleValuesParser::new(ColliderSource::ALL.map(ColliderSource::name));
    words.try_map(|word| ColliderSource::ALL.into_iter().find(|s| s.name() == word).ok_or("not a source"))
}

/// Reads a number of seconds.
pub fn seconds(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().map_err(|_| format!("`{text}` is not a number"))?;
    if number.is_finite() && number >= 0.0 { Ok(number) } else { Err("give at least 0 seconds, as in 0.5".into()) }
}

/// Reads a number of frames per second.
pub fn rate(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().map_err(|_| format!("`{text}` is not a number"))?;
    if number > 0.0 && number <= 1000.0 { Ok(number) } else { Err("give above 0 and at most 1000, as in 24".into()) }
}

/// Reads a material: a fabric, numbers, or both.
pub fn material(text: &str) -> Result<Material, String> {
    let first = text.split(',').next().unwrap_or("").trim();
    let fabric = Material::named(first);
    let skipped = usize::from(fabric.is_some());
    if fabric.is_none() && !first.contains('=') {
        let names: Vec<_> = Material::names().collect();
        return Err(format!("`{first}` is neither NAME=NUMBER nor one of {}", names.join(", ")));
    }
    let mut material = fabric.unwrap_or_default();
    for part in text.split(',').skip(skipped) {
        let (name, number) = part.split_once('=').ok_or_else(|| format!("`{part}` is not NAME=NUMBER"))?;
        let field = match name.trim() {
            "warp" => &mut material.warp,
            "weft" => &mut material.weft,
            "shear" => &mut material.shear,
            "bend" => &mut material.bend,
            "density" => &mut material.density,
            "damping" => &mut material.damping,
            "friction" => &mut material.friction,
            "thickness" => material.thickness.insert(0.0),
            other => {
                let names = "warp, weft, shear, bend, density, damping, friction, thickness";
                return Err(format!("`{other}` is not one of {names}"));
            }
        };
        *field = number.trim().parse().map_err(|_| format!("`{number}` is not a number"))?;
    }
    material.check().map(|()| material).map_err(|e| e.to_string())
}

/// Reads a camera: eye and target.
pub fn camera(text: &str) -> Result<[f32; 6], String> {
    let numbers: Option<Vec<f32>> = text.split(',').map(|x| x.trim().parse().ok()).collect();
    let six = numbers.and_then(|n| n.try_into().ok());
    six.ok_or_else(|| "give eye and target as six numbers, as in 0,1,3,0,1,0".into())
}

/// Reads a colour.
pub fn color(text: &str) -> Result<[f32; 3], String> {
    let code = u32::from_str_radix(text, 16).ok().filter(|_| text.len() == 6);
    let code = code.ok_or("give six hexadecimal digits, as in ffffff")?;
    Ok([16, 8, 0].map(|shift| (code >> shift & 255) as f32 / 255.0))
}

/// Reads width and height.
pub fn size(text: &str) -> Result<(u32, u32), String> {
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    sides.ok_or_else(|| "give width and height as in 128x96".into())
}
