//! The triangles of a picture beside cloths and colliders: the mesh of the source, the body, the ground under them.

use std::path::Path;

use gimage_runtime::draw::{Facet, Ground, bounds};
use gimage_runtime::{Collider, Shape};
use gimage_runtime::{RenderMesh, RenderPart, Skinning};

use super::body::Body;
use super::paints::Paints;
use crate::args::RenderArgs;
use crate::commands::character::Animated;
use crate::commands::engine::Engine;
use crate::commands::scene::Loaded;
use crate::commands::surface::SourceMesh;
use crate::exit::Failure;
use crate::output::Output;

/// Radius of a ground, and the least one, as shares of the height of a scene.
const GROUND_RADIUS: f32 = 1.3;

/// An object that the host of a picture places.
pub struct Shown<'a> {
    /// Each with the paints of its parts.
    meshes: Vec<(SourceMesh, Vec<usize>)>,
    /// Whether parts of a mesh that no cloth moves are drawn where the file has them.
    whole: bool,
    body: Option<Body>,
    pub paints: Paints<'a>,
}

impl<'a> Shown<'a> {
    /// For a scene: its meshes and its body, as the arguments ask for them.
    pub fn new(args: &RenderArgs, loaded: &Loaded, out: &'a Output) -> Result<Self, Failure> {
        let mut paints = Paints::new(out);
        let meshes = SourceMesh::choose(args.surface, args.scene.scene(), loaded, out)?;
        let meshes: Vec<_> = meshes
            .into_iter()
            .map(|of| {
                let numbers = paints.of_mesh(&of.mesh);
                (of, numbers)
            })
            .collect();
        // A scene file places its cloths elsewhere.
        let is_bundle = Path::new(args.scene.scene()).is_dir();
        let whole = loaded.animated.is_none() && !args.colliders && is_bundle;
        // A mesh has its own clothes.
        let cloths = if meshes.is_empty() { &loaded.file.scene.cloths[..] } else { &[][..] };
        let body = match loaded.animated.as_ref().filter(|_| !args.colliders) {
            Some(animated) => {
                let reading = (&animated.reading.import, &animated.reading.select);
                let skinning = loaded.file.scene.cloths.first().map_or(Skinning::Linear, |cloth| cloth.skinning);
                Body::read(&animated.path, reading, animated.character(), (cloths, skinning), &mut paints)?
            }
            None => None,
        };
        Ok(Shown { meshes, whole, body, paints })
    }

    /// Whether the mesh of the source is drawn.
    pub fn has_mesh(&self) -> bool {
        !self.meshes.is_empty()
    }

    /// Whether triangles stand for a cloth.
    pub fn has_cloth(&self, cloth: usize) -> bool {
        self.meshes.iter().any(|(of, _)| of.cloth == cloth) || self.body.as_ref().is_some_and(|body| body.wears(cloth))
    }

    /// Whether triangles stand for colliders: all of an animated character, or those of a bundle whose body is a part of its mesh.
    pub fn hides_collider(&self, index: usize, animated: Option<&Animated>) -> bool {
        match animated {
            Some(animated) => self.body.is_some() && animated.colliders().any(|own| own == index),
            None => self.whole && self.meshes.iter().any(|(of, _)| has_body(&of.mesh)),
        }
    }

    /// Whether anything is drawn.
    pub fn is_empty(&self) -> bool {
        self.meshes.is_empty() && self.body.is_none()
    }

    /// All triangles at the time of an engine.
    pub fn facets(&mut self, engine: &Engine, fraction: f32) -> Result<Vec<Facet>, Failure> {
        let mut facets = Vec::new();
        if let (Some(body), Some(animated)) = (&self.body, engine.animated()) {
            facets = body.facets(&animated.worlds(engine.time()));
            for cloth in (0..engine.stepper.scene().cloths.len()).filter(|cloth| body.wears(*cloth)) {
                facets.extend(body.worn(cloth, &engine.positions(cloth)?, &engine.normals(cloth)?));
            }
        }
        for (of, numbers) in &mut self.meshes {
            of.follow(engine, fraction)?;
            for (part, paint) in of.mesh.parts.iter().zip(numbers.iter()) {
                add_part(of, part, (*paint, self.whole), &self.paints, &mut facets);
            }
        }
        Ok(facets)
    }

    /// The ground below a scene: an upright half-space, else below its body and its cloth.
    pub fn ground(&self, loaded: &Loaded, times: &[f64], lowest: Option<f32>) -> Option<Ground> {
        let scene = &loaded.file.scene;
        let boxes = scene.cloths.iter().filter_map(|cloth| cloth.bounds()).chain(bounds(&[], &scene.colliders));
        let join = |a: ([f32; 3], [f32; 3]), b: ([f32; 3], [f32; 3])| {
            ([0, 1, 2].map(|c| a.0[c].min(b.0[c])), [0, 1, 2].map(|c| a.1[c].max(b.1[c])))
        };
        let (low, high) = boxes.reduce(join)?;
        let floor = |c: &&Collider| c.shape == Shape::HalfSpace && c.rotation[0].hypot(c.rotation[2]) < 0.1;
        let feet = |time: &f64| {
            let (body, animated) = (self.body.as_ref()?, loaded.animated.as_ref()?);
            let facets = body.facets(&animated.worlds(*time));
            Some(facets.iter().flat_map(|f| f.corners).map(|p| p[1]).fold(f32::INFINITY, f32::min))
        };
        let feet = times.iter().filter_map(feet).reduce(f32::min).filter(|y| y.is_finite());
        // Legs or a robe may be cloth, and go lower than what is left as the body; a train that hangs lower in motion does not count.
        let tall = high[1] - low[1].min(feet.unwrap_or(low[1]));
        let feet = feet.map(|y| if low[1] < y - ABOVE * tall { lowest.unwrap_or(low[1]).min(y) } else { y });
        let height = scene.colliders.iter().find(floor).map(|c| c.center[1]).or(feet).or(lowest).unwrap_or(low[1]);
        let size = [0, 1, 2].map(|c| high[c] - low[c]).into_iter().chain([high[1] - height]).fold(0.0, f32::max);
        let middle = [0, 2].map(|c| (low[c] + high[c]) / 2.0);
        Some(Ground { height, middle, radius: GROUND_RADIUS * size.max(1e-3) })
    }
}

/// Share of the height by which cloth at rest is below the body, from which it stands on the ground.
const ABOVE: f32 = 0.05;

/// Share of the vertices of a mesh from which those that no cloth moves are a body; a component of a part may be all of the cloth.
const BODY: f64 = 0.1;

/// Whether a good part of a mesh stays where it is.
fn has_body(mesh: &RenderMesh) -> bool {
    let all = || mesh.parts.iter().flat_map(|part| part.vertices.clone());
    let still = all().filter(|vertex| !mesh.is_bound(*vertex)).count();
    mesh.parts.iter().any(|part| !part.is_bound) || still as f64 > BODY * all().count() as f64
}

/// Adds the triangles of a part; those with a vertex that no cloth moves are left out of an animated character, whose body is drawn apart.
fn add_part(
    of: &SourceMesh,
    part: &RenderPart,
    (paint, whole): (usize, bool),
    paints: &Paints,
    facets: &mut Vec<Facet>,
) {
    if !part.is_bound && !whole {
        return;
    }
    let (mesh, vertices) = (&of.mesh, of.moved());
    let indices = of.indices().get(part.indices.clone()).unwrap_or_default();
    for t in indices.as_chunks::<3>().0.iter().map(|t| t.map(|v| v as usize)) {
        let is_cut = t[1] == t[0] && t[2] == t[0];
        if is_cut || (!whole && t.iter().any(|v| !mesh.is_bound(*v))) {
            continue;
        }
        let three = |p: [f32; 4]| [p[0], p[1], p[2]];
        facets.push(Facet {
            corners: t.map(|v| three(vertices[v].position)),
            normals: t.map(|v| three(vertices[v].normal)),
            uv: t.map(|v| paints.uv(paint, mesh.uv[v])),
            colors: t.map(|v| mesh.colors.get(v).copied().unwrap_or([1.0; 4])),
            paint,
        });
    }
}
