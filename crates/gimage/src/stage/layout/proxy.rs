//! The disk as the search sees it: few triangles, mapped in a fraction of a millisecond.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use super::Layout;
use super::search::{ASPECTS, LEAST_SIDE, SearchOptions};
use super::strip::Strip;
use crate::base::decimate::{Coarse, decimate};
use crate::base::vec3::{cross, norm, sub};
use crate::stage::border::{Border, on_rectangle};
use crate::stage::cut::OpenSurface;
use crate::stage::cut::corners::Corners;
use crate::stage::cut::disk::Disk;
use crate::stage::parameterize::{NewtonOptions, Shape, Start, System, solve};

/// Relative fall of the energy below which a trial takes no further Newton step: layouts are compared, not mapped.
const TOLERANCE: f64 = 1e-2;

fn triangle_area([a, b, c]: [[f64; 3]; 3]) -> f64 {
    0.5 * norm(cross(sub(b, a), sub(c, a)))
}

/// A layout and the map of the stand-in so far.
#[derive(Clone, Debug)]
pub(super) struct Trial {
    pub(super) layout: Layout,
    pub(super) uv: Vec<[f64; 2]>,
    /// The score after the first lot of steps.
    pub(super) early: f64,
    /// The map is the plain mean-value one.
    pub(super) plain: bool,
    /// Index of the aspect and part of the loop at the middle of the side v = 0.
    pub(super) aspect: usize,
    pub(super) middle: f64,
}

/// The disk as the search sees it.
pub(crate) struct Proxy<'a> {
    disk: &'a Disk,
    pub(super) border: &'a Border,
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    wanted: Vec<f64>,
    /// Whether each vertex lies on the boundary.
    fixed: Vec<bool>,
    /// The disk vertex of each coarse vertex; those past its end were split in.
    vertex: Vec<u32>,
    /// Coarse boundary vertices with their places in the loop of the disk.
    loop_at: Vec<(u32, usize)>,
    system: System,
    /// Places in the loop and dead ends for each way of sharing out the steps.
    along: BTreeMap<Vec<u32>, (Vec<f64>, Vec<u32>)>,
    /// Set where the disk is longer than all of [`ASPECTS`].
    pub(super) strip: Option<Strip>,
    /// The aspects of the search.
    pub(super) aspects: Vec<f64>,
    /// Least share of the border that a side between two nodes may have.
    pub(super) least_side: f64,
    pub(super) options: SearchOptions,
}

/// The coarse mesh of a disk by the number of its triangles: it serves all sizes that are tried.
#[derive(Clone, Debug, Default)]
pub(crate) struct StandIn(OnceLock<(usize, Coarse)>);

fn coarse(disk: &Disk, border: &Border, triangles: usize) -> Coarse {
    let mask = disk.boundary_mask();
    let mut locked = vec![false; disk.positions.len()];
    for (i, &v) in disk.boundary.iter().enumerate() {
        locked[v as usize] = border.nodes.get(i).copied().unwrap_or(false);
    }
    // Where each vertex went is not asked for.
    Coarse { patch: Vec::new(), ..decimate(&disk.positions, &disk.triangles, &mask, &locked, triangles) }
}

impl<'a> Proxy<'a> {
    /// Makes the stand-in.
    pub(crate) fn new(disk: &'a Disk, border: &'a Border, options: SearchOptions) -> Self {
        Self::with(disk, border, options, coarse(disk, border, options.triangles))
    }

    /// As [`Proxy::new`]; the coarse mesh is made once.
    pub(crate) fn over(open: &'a OpenSurface, options: SearchOptions) -> Self {
        let OpenSurface { disk, border, .. } = open;
        let made = || (options.triangles, coarse(disk, border, options.triangles));
        match open.stand_in.0.get_or_init(made) {
            (triangles, coarse) if *triangles == options.triangles => Self::with(disk, border, options, coarse.clone()),
            _ => Self::new(disk, border, options),
        }
    }

    fn with(disk: &'a Disk, border: &'a Border, options: SearchOptions, coarse: Coarse) -> Self {
        let mut place = vec![usize::MAX; disk.positions.len()];
        disk.boundary.iter().enumerate().for_each(|(i, &v)| place[v as usize] = i);
        let mut small = Disk {
            positions: coarse.vertex.iter().map(|&v| disk.positions[v as usize]).collect(),
            face: vec![0; coarse.triangles.len()],
            corners: Corners::whole(coarse.triangles.len()),
            origin: coarse.vertex.clone(),
            wanted: coarse.vertex.iter().map(|&v| disk.wanted[v as usize]).collect(),
            triangles: coarse.triangles,
            ..Disk::default()
        };
        let loop_at: Vec<(u32, usize)> = coarse
            .vertex
            .iter()
            .enumerate()
            .filter(|(_, v)| place[**v as usize] != usize::MAX)
            .map(|(k, v)| (k as u32, place[*v as usize]))
            .collect();
        small.boundary = loop_at.iter().map(|x| x.0).collect();
        small.split_chords();
        let fixed = small.boundary_mask();
        let system = System::new(&small.triangles, &fixed);
        let around: Vec<[f64; 3]> = disk.boundary.iter().map(|&v| disk.positions[v as usize]).collect();
        let area = disk.triangles.iter().map(|t| triangle_area(t.map(|v| disk.positions[v as usize]))).sum();
        Self {
            strip: Strip::of(&around, area, ASPECTS[ASPECTS.len() - 1]),
            aspects: ASPECTS.to_vec(),
            least_side: LEAST_SIDE,
            disk,
            border,
            positions: small.positions,
            triangles: small.triangles,
            wanted: small.wanted,
            fixed,
            vertex: coarse.vertex,
            loop_at,
            system,
            along: BTreeMap::new(),
            options,
        }
    }

    /// The start of the map of the stand-in for a layout. `None` if the layout cannot be, or has no flip-free start.
    pub(super) fn begin(&mut self, (w, h): (u32, u32), shift: f64, count: Vec<u32>, passes: usize) -> Option<Trial> {
        let perimeter = 2 * (w + h);
        let (disk, border) = (self.disk, self.border);
        if !self.along.contains_key(&count) {
            self.along.insert(count.clone(), (border.along(disk, &count), border.dead_ends(&count)));
        }
        let (along, dead) = &self.along[&count];
        let at_corner = |step: &u32| {
            let p = (f64::from(*step) + shift).rem_euclid(f64::from(perimeter)).round() as u32 % perimeter;
            [0, w, w + h, 2 * w + h].contains(&p)
        };
        if dead.iter().any(at_corner) {
            return None;
        }
        let mut uv = vec![[0.0; 2]; self.positions.len()];
        for &(k, i) in &self.loop_at {
            uv[k as usize] = on_rectangle(along[i] + shift, w, h);
        }
        let layout = Layout { w, h, shift, count, score: f64::INFINITY };
        let mut trial = Trial { layout, uv, early: f64::INFINITY, plain: false, aspect: 0, middle: 0.0 };
        self.solve(&mut trial, Start::Convex { passes }, 0).then_some(trial)
    }

    /// Starts the map of a trial and takes Newton steps; says whether it has a score.
    pub(super) fn solve(&mut self, trial: &mut Trial, start: Start, steps: usize) -> bool {
        let options = NewtonOptions { steps, further: 0, tolerance: TOLERANCE };
        let (positions, triangles, wanted, fixed) = (&self.positions, &self.triangles, &self.wanted, &self.fixed);
        let shape = Shape { positions, triangles, wanted, fixed };
        let record = solve(&mut self.system, shape, &mut trial.uv, start, &options);
        trial.plain = steps == 0 && record.is_some_and(|r| r.start_passes == 1 && !r.uniform_start);
        trial.layout.score = record.map_or(f64::INFINITY, |r| r.log_distortion);
        trial.layout.score.is_finite()
    }

    /// The plain mean-value map of the stand-in for a layout.
    pub(crate) fn plain(&mut self, layout: &Layout) -> Option<Vec<[f64; 2]>> {
        Some(self.begin((layout.w, layout.h), layout.shift, layout.count.clone(), 1)?.uv)
    }

    /// The disk vertex that a vertex of the stand-in is.
    pub(crate) fn original(&self, v: u32) -> Option<u32> {
        self.vertex.get(v as usize).copied()
    }

    /// Positions and triangles of the stand-in.
    pub(crate) fn coarse(&self) -> (&[[f64; 3]], &[[u32; 3]]) {
        (&self.positions, &self.triangles)
    }
}
