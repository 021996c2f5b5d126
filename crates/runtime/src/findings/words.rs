//! Findings in words.

use std::fmt;

use super::{Fate, Finding, PieceTexel};

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Finding { name, place, time, substeps, .. } = self;
        write!(f, "cloth '{name}', at {time:.2} s: ")?;
        match self.fate {
            Fate::Stretched { ratio, p99, at_pin, between } => {
                let percent = 100.0 * p99;
                write!(f, "springs are up to {ratio:.1} times as long as at rest")?;
                place.iter().try_for_each(|place| write!(f, ", the longest at {place}"))?;
                write!(f, ", and 1 in 100 is at least {percent:.0} % longer: ")?;
                if at_pin {
                    f.write_str("the longest is at a pin, so keep pins out of colliders and the body, and pin what lies between them; else ")?;
                } else if let Some([a, b]) = between {
                    write!(
                        f,
                        "the longest is where colliders {a} and {b} press it, as in an armpit, and steps do not make room: make them smaller, or pin what \
                         lies there, if it shows; else "
                    )?;
                }
                write!(f, "use more substeps (now {substeps}) and, without a material, 8 or more rounds of polish")
            }
            Fate::Left => f.write_str(
                "it left its body: its topmost particle is below all colliders that it touched: use more substeps and no \
                 pyramid, more friction, or pins",
            ),
            Fate::Falls => match place {
                Some(PieceTexel { piece, .. }) => {
                    write!(f, "piece '{piece}' falls, as neither pins nor seams nor stitches hold it: pin it, or build the bundle with a larger --stitch")
                }
                None => f.write_str("it falls, as no pin holds it and nothing is below: pin particles, or add a collider"),
            },
            Fate::Tunnelled { particles, particle, collider } => {
                write!(f, "{particles} particles went through collider {collider} in one frame, for example particle {particle}")?;
                place.iter().try_for_each(|place| write!(f, " at {place}"))?;
                write!(f, ": use more substeps (now {substeps}), a thicker collider, or a lower speed")
            }
            Fate::Crossed { pairs, touching, forced: 0 } => write!(
                f,
                "{pairs} pairs of triangles cross and {touching} touch where cloth starts or was put: contact takes crossing layers apart; \
                 keep layers apart at the start where their motion from the first frame on matters (gimage check-crossings lists the pairs)"
            ),
            Fate::Crossed { pairs, touching, forced } => write!(
                f,
                "{forced} pins or joints left cloth no room, and {pairs} pairs of triangles cross and {touching} touch: pin fewer \
                 particles there, move pins more slowly, or use more substeps (now {substeps})"
            ),
            Fate::Tangled { pairs } => write!(
                f,
                "{pairs} pairs of triangles still cross 2 s after contact began to take them apart: pin fewer particles there, leave more room \
                 between colliders, or give the cloths layers"
            ),
            Fate::Slowed { particles } => write!(
                f,
                "{particles} particles in one step are too fast for contact of the tier safe and were held back: use more substeps \
                 (now {substeps}), or the tier particles"
            ),
            Fate::Squeezed { depth } => write!(
                f,
                "contact of the tier safe holds particles up to {:.1} mm inside a collider, because the layers of cloth do not fit into the gap: leave \
                 more room between colliders, move them more slowly, or use more substeps (now {substeps})",
                1e3 * depth
            ),
            Fate::Thrown { collider, depth, speed } => {
                write!(f, "it was up to {:.1} mm inside collider {collider} as a frame began", 1e3 * depth)?;
                place.iter().try_for_each(|place| write!(f, ", deepest at {place}"))?;
                write!(
                    f,
                    ", and contact throws it out with {speed:.1} m/s on average: start it outside, clear the start (Scene::clear_start, or --clear-start on), and \
                     move colliders to cloth in place of putting them on it"
                )
            }
        }
    }
}

impl fmt::Display for PieceTexel {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "texel ({}, {}) of piece '{}'", self.texel[0], self.texel[1], self.piece)
    }
}
