//! How the vertices of a mesh are bound to the triangles of a cloth, on each level of its image.

use std::sync::{Arc, OnceLock};

use gimage_bundle::Frame;

use super::covers::Covers;
use super::lookup::Lookup;
use crate::cloth::Cloth;
use crate::coarser::{Coarser, Motion};
use crate::cpu::body::make_normals;
use crate::cpu::restrict;
use crate::cpu::rows::Threads;
use crate::cpu::start::inverse_masses;
use crate::cpu::wrap::UNBOUND;
use crate::error::{Error, Result};
use crate::layout::BoundRow;
use crate::number::real::{V3, cast, with_w, xyz};
use crate::options::Solver;

/// Levels that a binding keeps: the longest side of an image has 2^14 texels.
const LEVELS: usize = 14;

/// The bindings of a mesh on all levels; those of coarser ones are made when they are first asked for.
#[derive(Debug)]
pub(crate) struct Binding {
    pub finest: Arc<Bound>,
    coarser: [OnceLock<Arc<Bound>>; LEVELS],
}

/// The binding to the image of one level.
#[derive(Debug)]
pub(crate) struct Bound {
    /// A row per vertex.
    pub rows: Vec<BoundRow>,
    /// The particles of that level at rest \[m\], with -1 as w where there is none, and their normals.
    pub positions: Vec<[f32; 4]>,
    pub normals: Vec<V3<f32>>,
    covers: OnceLock<Arc<Covers>>,
}

impl Binding {
    pub fn new(finest: Bound) -> Self {
        Binding { finest: Arc::new(finest), coarser: Default::default() }
    }

    /// The binding after some steps to coarser images. Errors if these begin at a cloth of another number of particles. The first call for a level
    /// takes 0.3 microseconds per vertex.
    pub fn on(&self, cloth: &str, steps: &[Coarser]) -> Result<Arc<Bound>> {
        let mut bound = self.finest.clone();
        for (n, step) in steps.iter().enumerate() {
            bound.fits(cloth, step.fine_len())?;
            bound = match self.coarser.get(n) {
                Some(known) => known.get_or_init(|| Arc::new(bound.coarser(step))).clone(),
                None => Arc::new(bound.coarser(step)),
            };
            bound.fits(cloth, step.cloth().len())?;
        }
        Ok(bound)
    }
}

impl Bound {
    pub fn new(rows: Vec<BoundRow>, positions: Vec<[f32; 4]>, normals: Vec<V3<f32>>) -> Self {
        Bound { rows, positions, normals, covers: OnceLock::new() }
    }

    /// Refuses a cloth of another bundle.
    pub fn fits(&self, cloth: &str, found: usize) -> Result<()> {
        let expected = self.positions.len();
        if found == expected { Ok(()) } else { Err(Error::RenderMesh { cloth: cloth.into(), expected, found }) }
    }

    /// The triangles of the cloth that each triangle of the mesh covers; `cloth` is that of the level. Made by the first call.
    pub fn covers(&self, cloth: &Cloth, indices: &[u32]) -> Arc<Covers> {
        self.covers.get_or_init(|| Arc::new(Covers::new(self, cloth, indices))).clone()
    }

    /// The binding of the same vertices to a coarser image, which lies as it does after a change of level at rest. Each is bound to the triangle at
    /// its place in the image, with the offset that puts it where it is at rest.
    fn coarser(&self, step: &Coarser) -> Bound {
        let (cloth, fine) = (step.cloth(), step.fine_grids());
        let rest = Motion { now: self.positions.clone(), before: self.positions.clone() };
        let solver = Solver::default();
        let mut motion = Motion::room(inverse_masses(cloth, solver));
        restrict::run(&step.table_where(|k| self.positions[k][3] >= 0.0, cloth, solver), &rest, &mut motion);
        let exists = |k: u32| cloth.particles()[k as usize].exists();
        let place = |(k, p): (u32, &[f32; 4])| with_w(xyz(*p), if exists(k) { 1.0 } else { -1.0 });
        let positions: Vec<[f32; 4]> = (0..).zip(&motion.now).map(place).collect();
        let mut normals = vec![[0.0; 4]; positions.len()];
        make_normals(&Threads::one(), cloth.grids(), (&positions, &[]), cloth.rings(), &mut normals);
        let normals: Vec<V3<f32>> = normals.into_iter().map(xyz).collect();
        let looks: Vec<Lookup> =
            fine.iter().zip(cloth.grids()).map(|(f, c)| Lookup::new((f, c), step.samples(), exists)).collect();
        let row = |row: &BoundRow| {
            if row.corners[0] == UNBOUND {
                return *row;
            }
            let g = fine.partition_point(|g| g.range().end <= row.corners[0] as usize);
            let (corners, weights) = looks[g].point(&fine[g], row.corners, row.weights);
            let at = |list: &[V3<f32>], corners: [u32; 3]| corners.map(|k| list[k as usize]);
            let place = |list: &[[f32; 4]], corners: [u32; 3]| corners.map(|k| xyz(list[k as usize]));
            let (from, to) = (place(&self.positions, row.corners), place(&positions, corners));
            let was = Frame::new(from, at(&self.normals, row.corners), row.weights);
            let is = Frame::new(to, at(&normals, corners), weights);
            let (p, foot) = (was.place(from, row.weights, row.offset), is.place(to, weights, [0.0; 3]));
            let way: V3<f64> = std::array::from_fn(|c| f64::from(p[c]) - f64::from(foot[c]));
            let inward = |v: V3<f64>| is.inward(v).map(|x| x as f32);
            let turned = |v: [f32; 4]| with_w(inward(cast(was.outward(xyz(v)))), v[3]);
            let (normal, tangent) = (turned(row.normal), turned(row.tangent));
            BoundRow { corners, weights, offset: inward(way), normal, tangent }
        };
        Bound::new(self.rows.iter().map(row).collect(), positions, normals)
    }
}
