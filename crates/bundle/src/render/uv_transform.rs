//! The extension `KHR_texture_transform`.

use serde_json::Value;

/// An affine map of texture coordinates: u' = a u + b v + c and v' = d u + e v + f, as rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform(pub [[f32; 3]; 2]);

impl UvTransform {
    /// Leaves coordinates as they are.
    pub const IDENTITY: UvTransform = UvTransform([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);

    /// The map of an object of the extension, which scales, rotates and then offsets; the identity for anything else.
    pub fn of(extension: &Value) -> Self {
        let pair = |name: &str, default: f64| [0, 1].map(|k| extension[name][k].as_f64().unwrap_or(default));
        let ([x, y], [w, h]) = (pair("offset", 0.0), pair("scale", 1.0));
        let (sin, cos) = extension["rotation"].as_f64().unwrap_or(0.0).sin_cos();
        UvTransform([[cos * w, sin * h, x], [-sin * w, cos * h, y]].map(|row| row.map(|x| x as f32)))
    }

    /// A mapped pair of coordinates.
    pub fn apply(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        self.0.map(|[a, b, c]| a * u + b * v + c)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_comes_before_rotation_and_offset() {
        let all = serde_json::json!({"offset": [0.25, 0.5], "rotation": std::f64::consts::FRAC_PI_2, "scale": [2, 3]});
        let [u, v] = UvTransform::of(&all).apply([1.0, 1.0]);
        // (2, 3), turned to (3, -2).
        assert!((u - 3.25).abs() < 1e-5 && (v + 1.5).abs() < 1e-5, "{u} {v}");
        assert_eq!(UvTransform::of(&Value::Null), UvTransform::IDENTITY);
    }
}
