//! The surface of the body that the cloth of a bundle is worn on: vertices with joints, and triangles, as images.
//!
//! Item n of a list is texel (n mod W, n / W) of an image that is [`WIDTH`] texels wide.

use crate::error::{Error, Result};
use crate::manifest::BodyEntry;
use crate::map::{Image, MAX_SIDE};

/// Texels per row of the images.
const WIDTH: u32 = 64;
/// Most sets of joints per vertex.
const MAX_SETS: u32 = 16;
/// Most vertices, and most triangles: those of the largest image.
pub const MAX_BODY: u32 = WIDTH * MAX_SIDE;

/// The surface of a body, where it is bound to its skeleton, as the positions of the pieces are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Body {
    /// Positions at rest \[m\].
    pub positions: Vec<[f32; 3]>,
    /// Vertices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Four joints of the skeleton, as many sets per vertex as [`Body::sets`], those of a vertex one after the other; empty for a body that rests.
    pub joints: Vec<[u32; 4]>,
    /// Their weights; those of all sets of a vertex sum to 1.
    pub weights: Vec<[f32; 4]>,
}

impl Body {
    /// Sets of four joints per vertex.
    pub fn sets(&self) -> usize {
        self.joints.len() / self.positions.len().max(1)
    }

    /// The rule that it breaks, in words; `None` for a sound one. `joints` is the number of joints of the bundle.
    pub fn fault(&self, joints: usize) -> Option<String> {
        let (vertices, sets) = (self.positions.len(), self.sets());
        if sets > MAX_SETS as usize {
            return Some(format!("the body has more than {MAX_SETS} sets of joints per vertex"));
        }
        if vertices == 0 || self.triangles.is_empty() {
            return Some("the body has no triangle".into());
        }
        if let Some(v) = self.positions.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            return Some(format!("the position of vertex {v} of the body is not finite"));
        }
        if let Some(t) = self.triangles.iter().position(|t| t.iter().any(|v| *v as usize >= vertices)) {
            return Some(format!("triangle {t} of the body has a corner that is not one of its {vertices} vertices"));
        }
        if self.joints.len() != sets * vertices || self.weights.len() != self.joints.len() {
            return Some("the body does not have the same number of joints and weights per vertex".into());
        }
        for (v, own) in self.weights.chunks(sets.max(1)).enumerate() {
            let weights = || own.iter().flatten();
            let sum: f32 = weights().sum();
            if weights().any(|w| !w.is_finite() || *w < 0.0) || (sum - 1.0).abs() > 1e-3 {
                return Some(format!("the weights of vertex {v} of the body are negative or do not sum to 1"));
            }
        }
        let strange = |(own, weights): (&[u32; 4], &[f32; 4])| {
            own.iter().zip(weights).any(|(joint, weight)| *weight > 0.0 && *joint as usize >= joints)
        };
        let found = self.joints.iter().zip(&self.weights).position(strange);
        found.map(|n| format!("vertex {} of the body follows a joint that does not exist", n / sets.max(1)))
    }

    /// Its entry in a manifest.
    pub(crate) fn entry(&self) -> BodyEntry {
        BodyEntry {
            vertices: self.positions.len() as u32,
            triangles: self.triangles.len() as u32,
            sets: self.sets() as u32,
        }
    }

    /// Its images by file name, in the order of [`files`].
    pub(crate) fn images(&self) -> Vec<(String, Image)> {
        let entry = self.entry();
        let three = |p: &[f32; 3]| [p[0], p[1], p[2], 1.0];
        let whole = |t: [u32; 4]| t.map(|v| v as f32);
        let corners = |t: &[u32; 3]| whole([t[0], t[1], t[2], 0]);
        let of_set = |n: usize| move |(k, _): &(usize, &[f32; 4])| k % entry.sets.max(1) as usize == n;
        let mut lists =
            vec![self.positions.iter().map(three).collect::<Vec<_>>(), self.triangles.iter().map(corners).collect()];
        let joints: Vec<[f32; 4]> = self.joints.iter().map(|j| whole(*j)).collect();
        for n in 0..entry.sets as usize {
            for list in [&joints, &self.weights] {
                lists.push(list.iter().enumerate().filter(of_set(n)).map(|(_, v)| *v).collect());
            }
        }
        let names = files(&entry).into_iter().map(|file| file.name);
        names.zip(lists.iter().map(|list| image(list))).collect()
    }

    /// From images in the order of [`files`].
    pub(crate) fn from_images(entry: &BodyEntry, images: &[Image]) -> Result<Self> {
        let list = |n: usize, count: u32| -> Vec<[f32; 4]> {
            let all = images.get(n).map_or(&[][..], |image| &image.data);
            all.as_chunks::<4>().0.iter().take(count as usize).copied().collect()
        };
        let whole = |v: &f32| (*v >= 0.0 && *v < 16_777_216.0 && v.fract() == 0.0).then_some(*v as u32);
        let wholes = |list: &[[f32; 4]], file: &str| -> Result<Vec<[u32; 4]>> {
            let each = |v: &[f32; 4]| {
                let [a, b, c, d] = v.each_ref().map(whole);
                Some([a?, b?, c?, d?])
            };
            let bad = || Error::Exr {
                file: file.into(),
                problem: "an index is not a whole number".into(),
                hint: "build the bundle again",
            };
            list.iter().map(each).collect::<Option<Vec<_>>>().ok_or_else(bad)
        };
        if entry.sets > MAX_SETS {
            let problem = format!("the body has {} sets of joints per vertex, more than {MAX_SETS}", entry.sets);
            return Err(Error::Manifest { problem, hint: "build the bundle again" });
        }
        let files = files(entry);
        let positions = list(0, entry.vertices).iter().map(|p| [p[0], p[1], p[2]]).collect();
        let triangles = wholes(&list(1, entry.triangles), &files[1].name)?;
        let mut body =
            Body { positions, triangles: triangles.iter().map(|t| [t[0], t[1], t[2]]).collect(), ..Body::default() };
        let sets = entry.sets as usize;
        (body.joints, body.weights) =
            (vec![[0; 4]; sets * entry.vertices as usize], vec![[0.0; 4]; sets * entry.vertices as usize]);
        for n in 0..sets {
            let joints = wholes(&list(2 + 2 * n, entry.vertices), &files[2 + 2 * n].name)?;
            for (v, (own, weights)) in joints.iter().zip(list(3 + 2 * n, entry.vertices)).enumerate() {
                (body.joints[v * sets + n], body.weights[v * sets + n]) = (*own, weights);
            }
        }
        Ok(body)
    }
}

/// A file of a body: its name and the size of its image.
pub(crate) struct BodyFile {
    pub name: String,
    pub size: (u32, u32),
}

/// The files of a body, which no piece can have: theirs have two dots.
pub(crate) fn files(entry: &BodyEntry) -> Vec<BodyFile> {
    let size = |count: u32| (WIDTH, count.div_ceil(WIDTH).max(2));
    let file = |name: &str, count| BodyFile { name: format!("body_{name}.exr"), size: size(count) };
    let mut all = vec![file("position", entry.vertices), file("triangles", entry.triangles)];
    for n in 0..entry.sets.min(MAX_SETS) {
        let number = if n == 0 { String::new() } else { n.to_string() };
        all.push(file(&format!("joints{number}"), entry.vertices));
        all.push(file(&format!("weights{number}"), entry.vertices));
    }
    all
}

fn image(list: &[[f32; 4]]) -> Image {
    let height = (list.len() as u32).div_ceil(WIDTH).max(2);
    let mut image = Image::zeros(WIDTH, height, 4);
    image.data[..4 * list.len()].copy_from_slice(list.as_flattened());
    image
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(sets: usize) -> Body {
        let positions: Vec<[f32; 3]> = (0..130).map(|k| [k as f32, 0.5, -1.0 / (k + 1) as f32]).collect();
        let n = positions.len() * sets;
        Body {
            triangles: (0..128).map(|k| [k, k + 1, k + 2]).collect(),
            joints: (0..n as u32).map(|k| [k % 3, 1, 2, 0]).collect(),
            weights: vec![[0.5 / sets as f32, 0.25 / sets as f32, 0.25 / sets as f32, 0.0]; n],
            positions,
        }
    }

    #[test]
    fn images_hold_all_of_a_body() {
        for sets in 0..3 {
            let body = body(sets);
            assert_eq!((body.fault(3), body.entry().sets as usize), (None, sets));
            let images: Vec<Image> = body.images().into_iter().map(|i| i.1).collect();
            let sizes: Vec<(u32, u32)> = files(&body.entry()).iter().map(|f| f.size).collect();
            assert_eq!(sizes, images.iter().map(|i| (i.width, i.height)).collect::<Vec<_>>());
            assert_eq!(Body::from_images(&body.entry(), &images).unwrap(), body);
        }
    }

    #[test]
    fn bodies_that_break_a_rule_are_named() {
        let with = |change: &dyn Fn(&mut Body)| {
            let mut body = body(1);
            change(&mut body);
            body.fault(3).unwrap_or_default()
        };
        assert!(with(&|b| b.triangles.clear()).contains("no triangle"));
        assert!(with(&|b| b.positions[3][1] = f32::NAN).contains("vertex 3"));
        assert!(with(&|b| b.triangles[5][2] = 130).contains("triangle 5"));
        assert!(with(&|b| b.weights[7][0] = 0.9).contains("vertex 7"));
        assert!(with(&|b| b.joints[9][1] = 3).contains("vertex 9"));
        assert!(with(&|b| b.weights.truncate(9)).contains("number of joints"));
        let mut images: Vec<Image> = body(1).images().into_iter().map(|i| i.1).collect();
        images[1].data[0] = 0.5;
        assert!(Body::from_images(&body(1).entry(), &images).is_err());
    }
}
