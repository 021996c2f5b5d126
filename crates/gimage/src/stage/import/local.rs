//! Where a node is in the space of its parent.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};

use super::document::Document;
use super::matrix::{self, Matrix};

/// How far axes of length 1 may be from being at right angles, as their cosine.
const SHEAR: f64 = 1e-4;

/// The transform of a node to its parent's space.
#[derive(Clone, Copy, Debug)]
pub(super) enum Local {
    Matrix(Matrix),
    Parts { translation: [f64; 3], rotation: [f64; 4], scale: [f64; 3] },
}

impl Local {
    /// Those of the nodes of a file.
    pub fn all(doc: &Document) -> Vec<Local> {
        let local = |(node, own): (&gltf::json::Node, &Matrix)| match node.matrix {
            Some(_) => Local::Matrix(*own),
            None => Local::Parts {
                translation: node.translation.unwrap_or_default().map(f64::from),
                rotation: node.rotation.map_or([0.0, 0.0, 0.0, 1.0], |q| q.0.map(f64::from)),
                scale: node.scale.unwrap_or([1.0; 3]).map(f64::from),
            },
        };
        doc.root.nodes.iter().zip(&doc.locals).map(local).collect()
    }

    /// The parts of a matrix; `None` if it shears or flattens.
    pub fn parts(m: &Matrix) -> Option<Local> {
        let mut linear = Matrix3::from_fn(|i, j| m[4 * j + i]);
        let mut scale: [f64; 3] = std::array::from_fn(|j| linear.column(j).norm());
        if linear.determinant() < 0.0 {
            scale[0] = -scale[0];
        }
        for (j, s) in scale.iter().enumerate() {
            linear.column_mut(j).unscale_mut(*s);
        }
        let is_turn = (linear.transpose() * linear - Matrix3::identity()).amax() <= SHEAR;
        let [x, y, z, w] =
            UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(linear)).coords.into();
        let rotation = [x, y, z, w];
        is_turn.then_some(Local::Parts { translation: [m[12], m[13], m[14]], rotation, scale })
    }

    /// It as a matrix.
    pub fn matrix(&self) -> Matrix {
        match *self {
            Local::Matrix(matrix) => matrix,
            Local::Parts { translation, rotation, scale } => matrix::from_trs(translation, rotation, scale),
        }
    }

    /// A transform between two, of which only the parts can differ.
    pub fn towards(&self, other: &Local, share: f64) -> Local {
        let (Local::Parts { translation, rotation, scale }, Local::Parts { translation: t, rotation: r, scale: s }) =
            (*self, *other)
        else {
            return *other;
        };
        let mix = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|c| a[c] + (b[c] - a[c]) * share);
        let way = if (0..4).map(|c| rotation[c] * r[c]).sum::<f64>() < 0.0 { -1.0 } else { 1.0 };
        // The matrix is made of the quaternion at length 1.
        let rotation = [0, 1, 2, 3].map(|c| rotation[c] + (way * r[c] - rotation[c]) * share);
        Local::Parts { translation: mix(translation, t), rotation, scale: mix(scale, s) }
    }
}
