//! Numbers for people: few digits, and the unit that keeps them short.

/// `x` to `digits` significant digits, with commas between thousands.
pub fn significant(x: f64, digits: i32) -> String {
    if !x.is_finite() {
        return x.to_string();
    }
    if x == 0.0 {
        return "0".into();
    }
    let rounded: f64 = format!("{x:.*e}", (digits - 1).max(0) as usize).parse().unwrap_or(x);
    let exponent = rounded.abs().log10().floor() as i32;
    if !(-5..12).contains(&exponent) {
        return format!("{x:.*e}", (digits - 1).max(0) as usize);
    }
    if exponent >= digits - 1 {
        let whole = grouped(rounded.abs() as u64);
        return if x < 0.0 { format!("-{whole}") } else { whole };
    }
    format!("{rounded:.*}", (digits - 1 - exponent) as usize)
}

/// A whole number with commas between thousands.
pub fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// The first unit that leaves at least 1, else the last.
fn scaled(x: f64, units: &[(f64, &str)]) -> String {
    let unit = units.iter().find(|(size, _)| x.abs() >= *size * 0.9995).or(units.last());
    match unit {
        _ if x == 0.0 => "0".into(),
        Some((size, name)) => format!("{} {name}", significant(x / size, 4)),
        None => significant(x, 4),
    }
}

/// Metres.
pub fn length(metres: f64) -> String {
    scaled(metres, &[(1e3, "km"), (1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm")])
}

/// Square metres.
pub fn area(square_metres: f64) -> String {
    scaled(square_metres, &[(1e6, "km²"), (1.0, "m²"), (1e-4, "cm²"), (1e-6, "mm²")])
}

/// Kilograms.
pub fn mass(kilograms: f64) -> String {
    scaled(kilograms, &[(1.0, "kg"), (1e-3, "g"), (1e-6, "mg"), (1e-9, "µg")])
}

/// How often something was found, as in `32x`; nothing where it was once, or where the message begins with the number.
pub fn times(count: u64, message: &str) -> Option<String> {
    let said = message.split_whitespace().next().is_some_and(|word| word == count.to_string());
    (count > 1 && !said).then(|| format!("{}x", grouped(count)))
}

/// Seconds.
pub fn time(seconds: f64) -> String {
    scaled(seconds, &[(1.0, "s"), (1e-3, "ms"), (1e-6, "µs")])
}

/// Bytes, in powers of 1000.
pub fn bytes(n: u64) -> String {
    if n < 1000 { format!("{n} B") } else { scaled(n as f64, &[(1e9, "GB"), (1e6, "MB"), (1e3, "kB")]) }
}

/// A share as per cent.
pub fn percent(share: f64) -> String {
    format!("{} %", significant(share * 100.0, 3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_keep_their_digits() {
        let cases = [(0.0, "0"), (1.0, "1.000"), (-0.012346, "-0.01235"), (9999.6, "10,000"), (123456.0, "123,500")];
        for (x, text) in cases {
            assert_eq!(significant(x, 4), text);
        }
        assert_eq!((significant(1.5e-9, 3), significant(f64::INFINITY, 3)), ("1.50e-9".into(), "inf".into()));
    }

    #[test]
    fn a_count_is_said_once() {
        assert_eq!(times(32, "32 edges with three or more triangles"), None);
        assert_eq!(times(1, "Animations are not kept."), None);
        assert_eq!(times(3200, "Triangles were left out."), Some("3,200x".into()));
        assert_eq!(times(3, "32 edges"), Some("3x".into()));
    }

    #[test]
    fn units_fit_the_number() {
        assert_eq!(length(0.000_123_4), "123.4 µm");
        assert_eq!(length(1.0), "1.000 m");
        assert_eq!(length(0.999_99), "1.000 m");
        assert_eq!(area(0.05), "500.0 cm²");
        assert_eq!(bytes(1_234_567), "1.235 MB");
        assert_eq!(bytes(12), "12 B");
        assert_eq!(percent(0.001_234_5), "0.123 %");
        assert_eq!(grouped(1_234_567), "1,234,567");
    }
}
