//! The solvers that are compared.

use std::str::FromStr;

use gimage_runtime::{Options, Solver};

/// A solver with its settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// Its name in the table, which says it all.
    pub name: String,
    /// Which.
    pub solver: Solver,
    /// Tethers of a particle.
    pub tethers: u32,
    /// Steps from one run of the pyramid to the next; 0 is none.
    pub pyramid: u32,
    /// Further rounds of structural springs.
    pub polish: u32,
    /// Relaxations per step.
    pub iterations: u32,
}

/// Those of a run without any named; a line in the plot each.
pub const USUAL: [&str; 5] = ["classic", "xpbd", "xpbd+tethers", "xpbd+tethers+polish", "xpbd+pyramid"];

impl FromStr for Variant {
    type Err = String;

    /// `classic`, or `xpbd` with any of `+tethers`, `+pyramid`, `+polish` and `+iterations`, each with a number after it or
    /// without: 2, 2, 1 and 2.
    fn from_str(name: &str) -> Result<Self, String> {
        let mut parts = name.split('+');
        let solver = match parts.next() {
            Some("classic") => Solver::Classic,
            Some("xpbd") => Solver::Xpbd,
            _ => return Err(format!("there is no solver {name}; name it as in {}", USUAL.join(", "))),
        };
        let mut variant = Variant { name: name.into(), solver, tethers: 0, pyramid: 0, polish: 0, iterations: 1 };
        for part in parts.filter(|_| solver == Solver::Xpbd) {
            let (word, number) = part.split_at(part.find(|c: char| c.is_ascii_digit()).unwrap_or(part.len()));
            let (setting, usual) = match word {
                "tethers" => (&mut variant.tethers, 2),
                "pyramid" => (&mut variant.pyramid, 2),
                "polish" => (&mut variant.polish, 1),
                "iterations" => (&mut variant.iterations, 2),
                _ => {
                    return Err(format!(
                        "{name}: there is no +{word}, only +tethers, +pyramid, +polish and +iterations"
                    ));
                }
            };
            let wrong = |_| format!("{name}: {number:?} is not a number");
            *setting = if number.is_empty() { usual } else { number.parse().map_err(wrong)? };
        }
        Ok(variant)
    }
}

impl Variant {
    /// The settings for a number of substeps; what is not said here is as in `base`.
    pub fn options(&self, substeps: u32, base: &Options) -> Options {
        let Variant { solver, tethers, pyramid, polish, iterations, .. } = *self;
        Options { solver, tethers, pyramid, polish: Some(polish), iterations, substeps: Some(substeps), ..base.clone() }
    }

    /// Whether a scene shows it: the classic solver knows no compliance, and what falls freely has no tethers,
    /// and a pyramid of limits knows no compliance either.
    pub fn can(&self, scene: &str) -> bool {
        let (soft, free) = (scene == "s1k", scene.starts_with("s2"));
        !(soft && self.solver == Solver::Classic || free && self.tethers > 0 || soft && self.pyramid > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_says_it_all() {
        let of = |name: &str| name.parse::<Variant>().map(|v| (v.solver, v.tethers, v.pyramid, v.polish));
        assert_eq!(of("classic"), Ok((Solver::Classic, 0, 0, 0)));
        assert_eq!(of("xpbd+tethers+polish"), Ok((Solver::Xpbd, 2, 0, 1)));
        assert_eq!(of("xpbd+pyramid4+polish3"), Ok((Solver::Xpbd, 0, 4, 3)));
        assert!(of("fast").is_err() && of("xpbd+wings").is_err() && of("xpbd+polish1x").is_err());
        assert!(USUAL.iter().all(|name| of(name).is_ok()));
    }
}
