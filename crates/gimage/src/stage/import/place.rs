//! Where the garment stands: which axis is up, and where its middle is.

use super::ImportOptions;
use super::findings::Findings;
use super::matrix::{self, Matrix};
use crate::base::apart::apart;
use crate::base::mesh::{Mesh, Part, Semantic};
use crate::base::stray::strays;
use crate::base::words::{self, number};
use crate::error::{Error, Result};
use crate::record::Severity;

/// The axis of the file that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// x.
    X,
    /// y, as glTF demands: nothing is turned.
    #[default]
    Y,
    /// z, as in most CAD and in Blender.
    Z,
    /// -x.
    MinusX,
    /// -y.
    MinusY,
    /// -z.
    MinusZ,
}

impl Up {
    /// All of them, by the name that [`std::fmt::Display`] gives.
    pub const ALL: [Up; 6] = [Up::X, Up::Y, Up::Z, Up::MinusX, Up::MinusY, Up::MinusZ];

    /// The rotation that turns it to y, as three rows. It permutes coordinates and changes signs, which is exact.
    fn rows(self) -> [[f64; 3]; 3] {
        let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let minus = |v: [f64; 3]| v.map(|c: f64| if c == 0.0 { 0.0 } else { -c });
        match self {
            Up::Y => [x, y, z],
            Up::MinusY => [minus(x), minus(y), z],
            Up::Z => [x, z, minus(y)],
            Up::MinusZ => [x, minus(z), y],
            Up::X => [minus(y), x, z],
            Up::MinusX => [y, minus(x), z],
        }
    }

    fn turn(self, p: [f64; 3]) -> [f64; 3] {
        // Picked, not summed, as 0 times infinity is NaN; the last term makes 0 of -0.
        self.rows().map(|row| row.iter().zip(p).find(|(c, _)| **c != 0.0).map_or(0.0, |(c, x)| c * x + 0.0))
    }
}

impl std::fmt::Display for Up {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Up::X => "X",
            Up::Y => "Y",
            Up::Z => "Z",
            Up::MinusX => "-X",
            Up::MinusY => "-Y",
            Up::MinusZ => "-Z",
        })
    }
}

impl std::str::FromStr for Up {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let same = |up: &Up| up.to_string().eq_ignore_ascii_case(text.trim_start_matches('+'));
        Up::ALL.into_iter().find(same).ok_or_else(|| Error::Option {
            option: "up".into(),
            problem: format!("`{text}` is not an axis"),
            hint: "give X, Y, Z, -X, -Y or -Z".into(),
        })
    }
}

/// Turns the mesh so that `options.up` is y, then moves it as `options.center` asks, skeleton included: a joint's
/// inverse bind matrix times a position stays what it was. Then reports what looks wrong with size and axes. Returns the transform of
/// positions from the world of the file, unit included.
pub(crate) fn place(mesh: &mut Mesh, options: &ImportOptions, findings: &mut Findings) -> Matrix {
    let mut all = axes(options.up).0;
    all[..12].iter_mut().for_each(|x| *x *= options.unit);
    if options.up != Up::Y {
        turn(mesh, options.up);
    }
    if options.center
        && let Some((lo, hi)) = mesh.bounds()
    {
        let middle = |k: usize| 0.5 * lo[k] + 0.5 * hi[k];
        let by = [-middle(0), -lo[1], -middle(2)];
        mesh.positions.iter_mut().for_each(|p| *p = crate::base::vec3::add(*p, by));
        let mut go = matrix::IDENTITY;
        go[12..15].copy_from_slice(&by);
        all = matrix::mul(&go, &all);
        let mut back = matrix::IDENTITY;
        back[12..15].copy_from_slice(&by.map(|x| -x));
        move_joints(mesh, &go, &back);
        let message = "The middle of the bounding box was moved to x = 0 and z = 0, and its lowest point to y = 0.";
        findings.add(Severity::Note, "centered", 1, message, || {
            let [x, y, z] = by.map(number);
            format!("moved by ({x}, {y}, {z}) m")
        });
    }
    hint(mesh, options, findings);
    all
}

fn turn(mesh: &mut Mesh, up: Up) {
    mesh.positions.iter_mut().for_each(|p| *p = up.turn(*p));
    for channel in mesh.channels.iter_mut().filter(|c| c.semantic == Semantic::Normal && c.width == 3) {
        channel.values.as_chunks_mut::<3>().0.iter_mut().for_each(|n| *n = up.turn(n.map(f64::from)).map(|c| c as f32));
    }
    let (go, back) = axes(up);
    move_joints(mesh, &go, &back);
}

/// The rotation that turns an axis to y, and the one back.
pub(crate) fn axes(up: Up) -> (Matrix, Matrix) {
    let rows = up.rows();
    let (mut go, mut back) = (matrix::IDENTITY, matrix::IDENTITY);
    for i in 0..3 {
        for j in 0..3 {
            go[4 * j + i] = rows[i][j];
            back[4 * i + j] = rows[i][j];
        }
    }
    (go, back)
}

fn move_joints(mesh: &mut Mesh, go: &Matrix, back: &Matrix) {
    for joint in &mut mesh.skeleton.joints {
        joint.inverse_bind = matrix::mul(&joint.inverse_bind, back);
        joint.world = matrix::mul(go, &joint.world);
    }
}

/// The largest side \[m\] that garments have, curtains and wedding dresses among them, and the smallest: a doll's sock.
const SIZES: [f64; 2] = [5.0, 0.02];
/// The largest side \[m\] of a garment for people, roughly; a unit is proposed that brings it here.
const USUAL: [f64; 2] = [0.2, 2.5];
/// Metres in units that files come in, the usual ones first.
const UNITS: [f64; 7] = [0.01, 0.001, 0.1, 0.0254, 100.0, 1000.0, 10.0];

/// Notes about size and axes. They are guesses, and change neither the mesh nor the exit code.
fn hint(mesh: &Mesh, options: &ImportOptions, findings: &mut Findings) {
    // One part or one vertex far off the others says nothing about the unit of the file.
    let far = apart(mesh);
    for (part, (lo, hi), gap) in &far {
        let message = "Parts lie far from the garment, as nodes of another unit do, and take texels from it. Leave them out with --cloth, or correct the file.";
        findings.add(Severity::Note, "hint-apart", 1, message, || {
            let [x, y, z] = [0, 1, 2].map(|k| number(hi[k] - lo[k]));
            let Part { node, mesh, .. } = &mesh.parts[*part as usize];
            let name = if node.is_empty() { mesh } else { node };
            format!("{name}: {x} x {y} x {z} m, {} m away", number(*gap))
        });
    }
    let is_near = |part: &u32| far.binary_search_by_key(part, |(far, ..)| *far).is_err();
    let triangles = mesh.triangles.iter().zip(&mesh.triangle_part).filter(|(_, part)| is_near(part));
    let triangles: Vec<[u32; 3]> = triangles.map(|(triangle, _)| *triangle).collect();
    let Some((lo, hi)) = strays(&mesh.positions, &triangles).1.or_else(|| mesh.bounds()) else { return };
    let side: [f64; 3] = std::array::from_fn(|k| hi[k] - lo[k]);
    let place = || {
        let span = |k: usize| words::span(lo[k], hi[k]);
        format!("x {}, y {}, z {} m", span(0), span(1), span(2))
    };
    let largest = side.iter().copied().fold(0.0, f64::max);
    if largest > SIZES[0] || (largest > 0.0 && largest < SIZES[1]) {
        let fits = |u: &&f64| (USUAL[0]..=USUAL[1]).contains(&(largest * **u));
        let unit =
            UNITS.iter().find(fits).map_or("--unit METRES".into(), |u| format!("--unit {}?", number(u * options.unit)));
        let [x, y, z] = side.map(number);
        let message = format!("The garment is {x} m wide, {y} m high and {z} m deep: {unit}");
        findings.add(Severity::Note, "hint-unit", 1, &message, place);
    }
    if let Some(up) = standing(&lo, &hi, &side) {
        // The axis is one of the mesh as it stands; that of the file is known only where nothing was turned.
        let option =
            if options.up == Up::Y { format!("--up {up}?") } else { format!("another axis than --up {}?", options.up) };
        let message =
            format!("The garment extends along z and does not reach the plane z = 0, as in a file with Z up: {option}");
        findings.add(Severity::Note, "hint-up", 1, &message, place);
    }
}

/// Which way of the z axis is up if the garment stands on it, as one made for a body does: longer than it is deep, off the
/// floor or on it, and with its other two axes through the body.
fn standing(lo: &[f64; 3], hi: &[f64; 3], side: &[f64; 3]) -> Option<Up> {
    let middle = |k: usize| 0.5 * (lo[k] + hi[k]);
    let about_zero = |k: usize| middle(k).abs() <= 0.3 * side[k];
    let tall = side[2] >= 1.2 * side[1] && side[1] > 0.02 * side[2];
    let off = middle(2).abs() >= 0.4 * side[2];
    (tall && off && about_zero(0) && about_zero(1)).then_some(if middle(2) > 0.0 { Up::Z } else { Up::MinusZ })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_axis_turns_to_y_without_mirroring() {
        let axes =
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
        for (up, axis) in Up::ALL.into_iter().zip(axes) {
            assert_eq!(up.turn(axis), [0.0, 1.0, 0.0], "{up}");
            let [a, b, c] = [axes[0], axes[1], axes[2]].map(|p| up.turn(p));
            assert_eq!(crate::base::vec3::dot(crate::base::vec3::cross(a, b), c), 1.0, "{up}");
            assert_eq!(up.to_string().parse::<Up>().unwrap(), up);
        }
        assert_eq!("+z".parse::<Up>().unwrap(), Up::Z);
        assert!("up".parse::<Up>().unwrap_err().to_string().starts_with("option up: `up`"));
    }

    /// A box from one corner to the other, as two triangles of its bounds.
    fn boxed(lo: [f64; 3], hi: [f64; 3]) -> Mesh {
        let positions = vec![lo, [hi[0], lo[1], lo[2]], hi, [lo[0], hi[1], hi[2]]];
        Mesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], triangle_part: vec![0; 2], ..Mesh::default() }
    }

    fn hints(lo: [f64; 3], hi: [f64; 3], options: &ImportOptions) -> Vec<String> {
        let mut findings = Findings::default();
        place(&mut boxed(lo, hi), options, &mut findings);
        let found = findings.into_vec();
        assert!(found.iter().all(|f| f.severity == Severity::Note));
        found.into_iter().filter(|f| f.kind.starts_with("hint-")).map(|f| f.message).collect()
    }

    #[test]
    fn a_file_in_centimetres_or_with_z_up_gets_a_hint() {
        let d = ImportOptions::default();
        // A shirt on a body, as it should be, and a cape on the floor.
        assert_eq!(hints([-0.75, 1.0, -0.15], [0.75, 1.5, 0.15], &d), [""; 0]);
        assert_eq!(hints([-0.5, 0.0, -0.5], [0.5, 0.0, 0.5], &d), [""; 0]);
        let cm = hints([-75.0, 100.0, -15.0], [75.0, 150.0, 15.0], &d);
        assert_eq!(cm, ["The garment is 150 m wide, 50 m high and 30 m deep: --unit 0.01?"]);
        let again = hints([-75.0, 100.0, -15.0], [75.0, 150.0, 15.0], &ImportOptions { unit: 0.1, ..d.clone() });
        assert!(again[0].contains("--unit 0.001?"), "{again:?}");
        assert!(hints([0.0; 3], [1e-3; 3], &d)[0].contains("--unit 1000?"));
        assert!(hints([0.0; 3], [1e9; 3], &d)[0].contains("--unit METRES"));
        let z = hints([-0.75, -0.15, 1.0], [0.75, 0.15, 1.5], &d);
        assert!(z.len() == 1 && z[0].ends_with("--up Z?"), "{z:?}");
        assert!(hints([-0.75, -0.15, -1.5], [0.75, 0.15, -1.0], &d)[0].ends_with("--up -Z?"));
        assert_eq!(hints([-0.75, -0.15, 1.0], [0.75, 0.15, 1.5], &ImportOptions { up: Up::Z, ..d.clone() }), [""; 0]);
        assert_eq!(hints([-75.0, -15.0, 100.0], [75.0, 15.0, 150.0], &d).len(), 2);
    }

    #[test]
    fn buttons_of_another_unit_get_a_hint_and_say_nothing_about_the_unit_of_the_garment() {
        let mut mesh = boxed([-0.2, -0.4, -0.1], [0.2, 0.4, 0.1]);
        let button = boxed([0.0, 107.0, 9.0], [2.0, 109.0, 9.5]);
        mesh.positions.extend(button.positions);
        mesh.triangles.push([4, 5, 6]);
        mesh.triangle_part.push(1);
        let part = |node: &str| Part { node: node.into(), ..Part::default() };
        mesh.parts = vec![part("Cloth"), part("Button")];
        let mut findings = Findings::default();
        place(&mut mesh, &ImportOptions::default(), &mut findings);
        let found = findings.into_vec();
        let [only] = &found[..] else { panic!("{found:?}") };
        assert_eq!((only.kind, only.severity), ("hint-apart", Severity::Note));
        assert_eq!(only.examples, ["Button: 2 x 2 x 0.5 m, 107 m away"]);
    }

    #[test]
    fn center_puts_the_garment_on_the_floor_at_the_origin() {
        let mut findings = Findings::default();
        let mut mesh = boxed([10.0, 20.0, 30.0], [11.0, 22.0, 33.0]);
        let options = ImportOptions { center: true, ..ImportOptions::default() };
        place(&mut mesh, &options, &mut findings);
        assert_eq!(mesh.bounds(), Some(([-0.5, 0.0, -1.5], [0.5, 2.0, 1.5])));
        let found = findings.into_vec();
        assert_eq!((found[0].kind, found[0].examples[0].as_str()), ("centered", "moved by (-10.5, -20, -31.5) m"));
    }
}
