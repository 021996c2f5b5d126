//! The frame of reference of a character: that of a joint, in which its cloth is simulated.

use gimage::import::Character;
use gimage_runtime::scene::Pose;
use gimage_runtime::{Inertia, MovingFrame, Scene, Stepper};

use super::Frame;
use crate::exit::Failure;

/// A joint in whose frame everything is.
pub struct Local {
    node: usize,
    /// Where the joint is in the pose of the file: there the frame is that of the world.
    rest: Frame,
    /// Colliders that no joint moves, where they are in the world: they move against the frame.
    fixed: Vec<(usize, Pose)>,
}

impl Local {
    /// The frame of a joint; cloths of the scene feel shares of its motion. `moved` are the colliders that joints move.
    pub fn new(
        (joint, inertia): (&str, Option<&str>),
        character: &Character,
        moved: &[usize],
        scene: &mut Scene,
    ) -> Result<Self, Failure> {
        let node = character.node(joint).map_err(|e| Failure::refused(e.to_string()))?;
        if let Some(text) = inertia {
            let inertia = parse(text)?;
            scene.cloths.iter_mut().for_each(|cloth| cloth.inertia = inertia);
        }
        let fixed = scene.colliders.iter().enumerate().filter(|(k, _)| !moved.contains(k));
        let fixed = fixed.map(|(k, c)| (k, c.pose())).collect();
        Ok(Local { node, rest: Frame::of(&character.rest_worlds()[node]), fixed })
    }

    /// Where the frame is, given where nodes are in the world.
    pub fn frame(&self, worlds: &[[f64; 16]]) -> MovingFrame {
        let now = Frame::of(&worlds[self.node]);
        // The turn from the pose of the file to now: now times the transpose of rest, as columns.
        let column = |c: usize| {
            let sum = |r: usize| (0..3).map(|k| now.axes[k][r] * self.rest.axes[k][c]).sum::<f64>();
            [sum(0), sum(1), sum(2)]
        };
        let mut frame = MovingFrame::of_axes([0.0; 3], &[column(0), column(1), column(2)]);
        let carried = frame.to_world(self.rest.origin);
        frame.position = [0, 1, 2].map(|c| now.origin[c] - carried[c]);
        frame
    }

    /// Transforms of nodes, in the frame.
    pub fn inside(&self, worlds: &[[f64; 16]]) -> Vec<[f64; 16]> {
        let frame = self.frame(worlds);
        let turned = MovingFrame { position: [0.0; 3], ..frame };
        let column = |m: &[f64; 16], n: usize| {
            let v = [m[4 * n], m[4 * n + 1], m[4 * n + 2]];
            if n == 3 { frame.to_local(v) } else { turned.to_local(v) }
        };
        let one = |m: &[f64; 16]| {
            let [a, b, c, d] = [0, 1, 2, 3].map(|n| column(m, n));
            let row = |v: [f64; 3], last: f64| [v[0], v[1], v[2], last];
            let all = [row(a, 0.0), row(b, 0.0), row(c, 0.0), row(d, 1.0)];
            std::array::from_fn(|k| all[k / 4][k % 4])
        };
        worlds.iter().map(one).collect()
    }

    /// Poses of the colliders that stand still in the world, in the frame.
    pub fn fixed(&self, worlds: &[[f64; 16]]) -> impl Iterator<Item = (usize, Pose)> {
        let frame = self.frame(worlds);
        let [x, y, z, w] = frame.rotation;
        self.fixed.iter().map(move |(index, pose)| {
            let q = pose.rotation.map(f64::from);
            let axis = |v: [f64; 3]| MovingFrame { position: [0.0; 3], rotation: [-x, -y, -z, w] }.to_world(v);
            let axes = Frame::turned(q).axes.map(axis);
            (*index, Pose::of_axes(frame.to_local(pose.position.map(f64::from)).map(|p| p as f32), &axes))
        })
    }

    /// Moves the frame of all cloths to where it is at the end of the next frame; `start` is where it was before the first one.
    pub fn go(&self, stepper: &mut Stepper, worlds: &[[f64; 16]], start: &[[f64; 16]]) -> Result<(), Failure> {
        let to = self.frame(worlds);
        for cloth in 0..stepper.scene().cloths.len() {
            if stepper.moving_frame(cloth)?.is_none() {
                stepper.set_moving_frame(cloth, &self.frame(start))?;
            }
            stepper.set_moving_frame(cloth, &to)?;
        }
        Ok(())
    }
}

/// Shares that a text gives: one for all, or linear, angular and centrifugal.
fn parse(text: &str) -> Result<Inertia, Failure> {
    let numbers: Vec<f32> = text.split(',').filter_map(|t| t.trim().parse().ok()).collect();
    let inertia = match numbers[..] {
        [all] if !text.contains(',') => [all; 3],
        [linear, angular, centrifugal] if text.matches(',').count() == 2 => [linear, angular, centrifugal],
        _ => [f32::NAN; 3],
    };
    if !inertia.iter().all(|x| (0.0..=1.0).contains(x)) {
        let hint = "give one share from 0 to 1, or three: linear,angular,centrifugal";
        return Err(Failure::refused(format!("--inertia {text}: {hint}")));
    }
    let [linear, angular, centrifugal] = inertia;
    Ok(Inertia { linear, angular, centrifugal })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_joint_stays_in_its_frame_where_it_was_in_the_file() {
        let at = |turn: f64, x: f64| {
            let (s, c) = turn.sin_cos();
            [c, s, 0.0, 0.0, -s, c, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, 1.0, 0.5, 1.0]
        };
        let fixed = vec![(4, Pose { position: [2.0, 0.0, 0.0], ..Pose::default() })];
        let local = Local { node: 1, rest: Frame::of(&at(0.3, 0.2)), fixed };
        let worlds = [at(1.0, 3.0), at(1.7, 7.0)];
        let inside = local.inside(&worlds);
        let expected = at(0.3, 0.2);
        assert!(inside[1].iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-6), "{:?}", inside[1]);
        // The other one is turned against it as in the world, and a fixed collider comes back.
        assert!((inside[0][0] - (1.0f64 - 1.7 + 0.3).cos()).abs() < 1e-6);
        let frame = local.frame(&worlds);
        let (index, pose) = local.fixed(&worlds).next().unwrap();
        let back = frame.to_world(pose.position.map(f64::from));
        assert!(index == 4 && (back[0] - 2.0).abs() < 1e-5 && back[1].abs() < 1e-5);
        let axis = pose.apply([1.0, 0.0, 0.0]).map(f64::from);
        let back = frame.to_world(axis);
        assert!((back[0] - 3.0).abs() < 1e-5 && back[1].abs() < 1e-5, "{back:?}");
    }

    #[test]
    fn shares_are_one_or_three() {
        assert_eq!(parse("0.5").unwrap(), Inertia { linear: 0.5, angular: 0.5, centrifugal: 0.5 });
        assert_eq!(parse("0, 0.5,1").unwrap(), Inertia { linear: 0.0, angular: 0.5, centrifugal: 1.0 });
        for wrong in ["", "2", "0.1,0.2", "0,1,x", "nan", "1,,1", "0.1,"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }
}
