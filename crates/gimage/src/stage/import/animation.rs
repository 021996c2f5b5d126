//! Animations of glTF: key frames, and their values in between (glTF 2.0, section 3.11 and appendix C).

use serde_json::Value;

use super::accessor::Accessors;
use crate::error::Result;

/// Most values of all channels of an animation.
const MAX_VALUES: usize = 1 << 26;

/// The way from one key frame to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Between {
    /// The value stays until the next key.
    Step,
    /// Linear; of rotations spherical linear, the shorter way.
    Linear,
    /// A cubic Hermite spline, with a tangent into each key and one out of it.
    Cubic,
}

/// The property of a node that a channel moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    Translation,
    Rotation,
    Scale,
}

impl Target {
    fn width(self) -> usize {
        if self == Target::Rotation { 4 } else { 3 }
    }
}

/// Key frames of one property of a node.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Channel {
    pub node: usize,
    pub target: Target,
    between: Between,
    /// \[s\], ascending.
    times: Vec<f64>,
    /// One value per key, or three of a cubic spline: tangent in, value, tangent out; the fourth component of a vector is 0.
    values: Vec<[f64; 4]>,
}

/// An animation.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Clip {
    pub channels: Vec<Channel>,
    /// Channels of other properties, such as the weights of morph targets.
    pub skipped: usize,
}

impl Clip {
    /// Reads the channels of animation `index` that move nodes.
    pub fn read(accessors: &Accessors, index: usize) -> Result<Self> {
        let doc = accessors.doc;
        let clip = &doc.clips[index];
        let element = |n: usize| format!("animation {index} `{}`, channel {n}", doc.animations[index].name);
        let number = |value: &Value| usize::try_from(value.as_u64()?).ok();
        let (mut all, mut total) = (Clip::default(), 0);
        for (n, channel) in clip["channels"].as_array().into_iter().flatten().enumerate() {
            let target = match channel["target"]["path"].as_str() {
                Some("translation") => Target::Translation,
                Some("rotation") => Target::Rotation,
                Some("scale") => Target::Scale,
                _ => {
                    all.skipped += 1;
                    continue;
                }
            };
            // A channel without a node has a target that an extension names.
            let Some(node) = number(&channel["target"]["node"]) else {
                all.skipped += 1;
                continue;
            };
            if node >= doc.root.nodes.len() {
                return Err(doc.bad(element(n), format!("its node {node} does not exist")));
            }
            let sampler = number(&channel["sampler"]).and_then(|s| clip["samplers"].get(s));
            let Some((sampler, input, output)) =
                sampler.and_then(|s| Some((s, number(&s["input"])?, number(&s["output"])?)))
            else {
                return Err(doc.bad(element(n), "its sampler does not exist, or has no input or output"));
            };
            let between = match sampler["interpolation"].as_str() {
                None | Some("LINEAR") => Between::Linear,
                Some("STEP") => Between::Step,
                Some("CUBICSPLINE") => Between::Cubic,
                Some(other) => return Err(doc.bad(element(n), format!("glTF has no interpolation `{other}`"))),
            };
            let (times, values) = (accessors.floats(input)?, accessors.floats(output)?);
            total += times.values.len() + values.values.len();
            if total > MAX_VALUES {
                return Err(doc.bad(element(n), format!("the animation has more than {MAX_VALUES} values")));
            }
            let keys = Keys { target, between, times, values };
            all.channels.push(keys.channel(node).map_err(|problem| doc.bad(element(n), problem))?);
        }
        Ok(all)
    }

    /// Time of the last key \[s\], 0 without keys.
    pub fn seconds(&self) -> f64 {
        self.channels.iter().filter_map(|c| c.times.last()).copied().fold(0.0, f64::max)
    }
}

/// Key frames as accessors have them.
struct Keys {
    target: Target,
    between: Between,
    times: super::accessor::Floats,
    values: super::accessor::Floats,
}

impl Keys {
    fn channel(self, node: usize) -> std::result::Result<Channel, String> {
        let Keys { target, between, times, values } = self;
        let times: Vec<f64> = times.values.iter().map(|t| f64::from(*t)).collect();
        let each = if between == Between::Cubic { 3 } else { 1 };
        let width = target.width();
        if values.width != width || values.values.len() != width * each * times.len() {
            let (found, need) = (values.values.len(), width * each * times.len());
            return Err(format!("it has {found} numbers for {} keys, which need {need}", times.len()));
        }
        if times.is_empty() || times.iter().any(|t| !t.is_finite()) || times.windows(2).any(|t| t[0] >= t[1]) {
            return Err("the times of its keys do not ascend".into());
        }
        if values.values.iter().any(|v| !v.is_finite()) {
            return Err("a value of its keys is not finite".into());
        }
        let vector = |v: &[f32]| std::array::from_fn(|c| v.get(c).map_or(0.0, |x| f64::from(*x)));
        let values = values.values.chunks(width).map(vector).collect();
        Ok(Channel { node, target, between, times, values })
    }
}

impl Channel {
    /// The value at `time` \[s\]: that of the first key before it, of the last key after it. A rotation is a unit quaternion x, y, z, w.
    pub fn at(&self, time: f64) -> [f64; 4] {
        let cubic = self.between == Between::Cubic;
        let value = |key: usize| self.values[if cubic { 3 * key + 1 } else { key }];
        let next = self.times.partition_point(|t| *t <= time);
        let last = self.times.len() - 1;
        let value = if next == 0 || next > last {
            value(if next == 0 { 0 } else { last })
        } else {
            let key = next - 1;
            let length = self.times[next] - self.times[key];
            let s = (time - self.times[key]) / length;
            match self.between {
                Between::Step => value(key),
                Between::Linear if self.target == Target::Rotation => slerp(value(key), value(next), s),
                Between::Linear => {
                    let (a, b) = (value(key), value(next));
                    [0, 1, 2, 3].map(|c| a[c] + (b[c] - a[c]) * s)
                }
                Between::Cubic => {
                    let (out, into) = (self.values[3 * key + 2], self.values[3 * next]);
                    hermite([value(key), value(next)], [out, into].map(|t| t.map(|x| x * length)), s)
                }
            }
        };
        if self.target == Target::Rotation { unit(value) } else { value }
    }
}

/// The cubic that has these values at its ends, and these derivatives by its parameter.
fn hermite([a, b]: [[f64; 4]; 2], [out, into]: [[f64; 4]; 2], s: f64) -> [f64; 4] {
    let (s2, s3) = (s * s, s * s * s);
    let weights = [2.0 * s3 - 3.0 * s2 + 1.0, s3 - 2.0 * s2 + s, 3.0 * s2 - 2.0 * s3, s3 - s2];
    [0, 1, 2, 3].map(|c| weights[0] * a[c] + weights[1] * out[c] + weights[2] * b[c] + weights[3] * into[c])
}

/// The rotation on the shorter arc between two, which need not be unit quaternions.
fn slerp(a: [f64; 4], b: [f64; 4], s: f64) -> [f64; 4] {
    let (a, mut b) = (unit(a), unit(b));
    let mut cosine: f64 = (0..4).map(|c| a[c] * b[c]).sum();
    if cosine < 0.0 {
        (b, cosine) = (b.map(|x| -x), -cosine);
    }
    let angle = cosine.min(1.0).acos();
    // Nearly alike: the chord is as good as the arc, and has no division by 0.
    let (wa, wb) = if angle < 1e-6 {
        (1.0 - s, s)
    } else {
        (((1.0 - s) * angle).sin() / angle.sin(), (s * angle).sin() / angle.sin())
    };
    [0, 1, 2, 3].map(|c| wa * a[c] + wb * b[c])
}

/// The unit quaternion; no rotation for one of no length.
fn unit(q: [f64; 4]) -> [f64; 4] {
    let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    if norm > 0.0 { q.map(|x| x / norm) } else { [0.0, 0.0, 0.0, 1.0] }
}

#[cfg(test)]
mod tests {
    use super::super::accessor::Floats;
    use super::*;

    fn channel(target: Target, between: Between, times: &[f32], values: &[f32]) -> Channel {
        let times = Floats { width: 1, values: times.to_vec() };
        let values = Floats { width: target.width(), values: values.to_vec() };
        Keys { target, between, times, values }.channel(0).unwrap()
    }

    fn near(a: [f64; 4], b: [f64; 4]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9)
    }

    #[test]
    fn a_step_stays_until_the_next_key_and_ends_are_held() {
        let c = channel(Target::Translation, Between::Step, &[1.0, 3.0], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let (a, b) = ([1.0, 2.0, 3.0, 0.0], [4.0, 5.0, 6.0, 0.0]);
        assert_eq!([0.0, 1.0, 2.999, 3.0, 9.0].map(|t| c.at(t)), [a, a, a, b, b]);
    }

    #[test]
    fn vectors_are_linear_and_rotations_take_the_shorter_arc() {
        let c = channel(Target::Scale, Between::Linear, &[1.0, 3.0], &[1.0, 2.0, 3.0, 5.0, 2.0, -1.0]);
        assert!(near(c.at(1.5), [2.0, 2.0, 2.0, 0.0]));
        // From none to a quarter turn about z, which the file has with the opposite sign: a third of the way is 30 degrees.
        let h = 0.5f32.sqrt();
        let c = channel(Target::Rotation, Between::Linear, &[0.0, 3.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -h, -h]);
        let (s, c1) = (15f64.to_radians().sin(), 15f64.to_radians().cos());
        assert!(c.at(1.0).iter().zip([0.0, 0.0, s, c1]).all(|(a, b)| (a - b).abs() < 1e-7), "{:?}", c.at(1.0));
    }

    #[test]
    fn a_cubic_spline_has_its_values_and_its_tangents() {
        // From 1 at 2 s to 5 at 4 s; out at 3 per second, in at -1 per second.
        let zero = [0.0; 2];
        let key = |into: f32, value: f32, out: f32| {
            [[into, zero[0], zero[1]], [value, 0.0, 0.0], [out, 0.0, 0.0]].as_flattened().to_vec()
        };
        let values = [key(7.0, 1.0, 3.0), key(-1.0, 5.0, 8.0)].concat();
        let c = channel(Target::Translation, Between::Cubic, &[2.0, 4.0], &values);
        // By hand, at the middle: (1 + 5) / 2 + 2 (3 / 8 + 1 / 8) = 4; at a quarter: 0.84375 + 2 * 3 * 9 / 64 + 5 * 0.15625 + 2 * 3 / 64.
        assert!(near(c.at(3.0), [4.0, 0.0, 0.0, 0.0]), "{:?}", c.at(3.0));
        assert!(near(c.at(2.5), [0.84375 + 0.84375 + 0.78125 + 0.09375, 0.0, 0.0, 0.0]), "{:?}", c.at(2.5));
        assert!(near(c.at(2.0), [1.0, 0.0, 0.0, 0.0]) && near(c.at(4.0), [5.0, 0.0, 0.0, 0.0]));
        let slope = (c.at(2.0 + 1e-6)[0] - c.at(2.0)[0]) / 1e-6;
        assert!((slope - 3.0).abs() < 1e-4, "{slope}");
        // Of rotations the result is a unit quaternion.
        let q = [[0.0; 4], [0.0, 0.0, 0.0, 1.0], [0.0; 4], [0.0; 4], [0.0, 0.0, 1.0, 0.0], [0.0; 4]];
        let c = channel(Target::Rotation, Between::Cubic, &[0.0, 1.0], q.as_flattened());
        let h = 0.5f64.sqrt();
        assert!(near(c.at(0.5), [0.0, 0.0, h, h]), "{:?}", c.at(0.5));
    }

    #[test]
    fn keys_that_make_no_sense_are_refused() {
        let of = |times: &[f32], values: &[f32]| {
            let (times, values) = (times.to_vec(), values.to_vec());
            let (times, values) = (Floats { width: 1, values: times }, Floats { width: 3, values });
            Keys { target: Target::Scale, between: Between::Linear, times, values }.channel(0).unwrap_err()
        };
        assert!(of(&[0.0, 1.0], &[1.0; 3]).contains("3 numbers for 2 keys, which need 6"));
        assert!(of(&[1.0, 1.0], &[1.0; 6]).contains("ascend"));
        assert!(of(&[0.0, f32::NAN], &[1.0; 6]).contains("ascend"));
        assert!(of(&[0.0, 1.0], &[f32::INFINITY; 6]).contains("not finite"));
        assert!(of(&[], &[]).contains("ascend"));
    }
}
