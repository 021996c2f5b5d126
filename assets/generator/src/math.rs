//! Small vector and number helpers.
//!
//! Only `+ - * /` and `sqrt` are used: IEEE 754 fixes their results to the last bit, while `sin` or `hypot` come from
//! the platform's maths library and may differ. This is what lets a test compare files byte for byte.

/// A point of a flat panel, in metres.
pub type V2 = [f64; 2];
/// A point in space, in metres, Y up.
pub type V3 = [f64; 3];

/// Half a turn.
pub const PI: f64 = std::f64::consts::PI;

/// `a + b`.
pub fn add(a: V3, b: V3) -> V3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a - b`.
pub fn sub(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a * s`.
pub fn scale(a: V3, s: f64) -> V3 {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// The dot product.
pub fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The cross product.
pub fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The length of a vector.
pub fn norm(a: V3) -> f64 {
    dot(a, a).sqrt()
}

/// `a` at length one; the zero vector stays as it is.
pub fn unit(a: V3) -> V3 {
    let n = norm(a);
    if n > 0.0 { scale(a, 1.0 / n) } else { a }
}

/// From `a` to `b`.
pub fn lerp(a: V3, b: V3, t: f64) -> V3 {
    add(scale(a, 1.0 - t), scale(b, t))
}

/// The distance between two points of a panel.
pub fn dist2(a: V2, b: V2) -> f64 {
    ((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1])).sqrt()
}

/// Twice the signed area of a flat triangle.
pub fn cross2(a: V2, b: V2, c: V2) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Sine, by range reduction and a Taylor sum, accurate to about 1e-14.
pub fn sin(x: f64) -> f64 {
    let mut r = x - (x / (2.0 * PI)).round() * 2.0 * PI;
    if r > PI / 2.0 {
        r = PI - r;
    } else if r < -PI / 2.0 {
        r = -PI - r;
    }
    let (mut term, mut sum) = (r, r);
    for k in 1..11 {
        let n = f64::from(2 * k);
        term *= -r * r / (n * (n + 1.0));
        sum += term;
    }
    sum
}

/// Cosine.
pub fn cos(x: f64) -> f64 {
    sin(x + PI / 2.0)
}

/// The angle of the vector (x, y) from the x axis, except on the negative x axis: three halvings and a Taylor sum.
pub fn atan2(y: f64, x: f64) -> f64 {
    let mut t = y / ((x * x + y * y).sqrt() + x);
    for _ in 0..2 {
        t /= 1.0 + (1.0 + t * t).sqrt();
    }
    let (mut power, mut sum) = (t, t);
    for k in 1..24 {
        power *= -t * t;
        sum += power / f64::from(2 * k + 1);
    }
    8.0 * sum
}

/// 0 below `a`, 1 above `b`, smooth in between.
pub fn smoothstep(a: f64, b: f64, x: f64) -> f64 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A fixed pseudo-random number in -1..1 for each `seed`.
pub fn noise(seed: u64) -> f64 {
    let mut z = seed.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^= z >> 31;
    (z >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_right() {
        for i in -100..100 {
            let x = f64::from(i) * 0.173;
            assert!((sin(x) - x.sin()).abs() < 1e-12, "{x}");
            assert!((cos(x) - x.cos()).abs() < 1e-12, "{x}");
            let a = x / 6.0;
            assert!((atan2(2.0 * a.sin(), 2.0 * a.cos()) - a).abs() < 1e-12, "{a}");
        }
    }

    #[test]
    fn noise_spreads_over_its_range() {
        let all: Vec<f64> = (0..1000).map(noise).collect();
        assert!(all.iter().all(|v| (-1.0..=1.0).contains(v)));
        assert!(all.iter().sum::<f64>().abs() < 60.0);
    }
}
