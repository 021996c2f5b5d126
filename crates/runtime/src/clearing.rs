//! Clears the start of a scene: particles that begin inside a body, inside colliders or behind cloth of a layer below leave it before the first
//! frame, and the cloth around them gives way.
//!
//! Garments are cleared from the body outwards. Each is a net of points and links ([`net`]); obstacles are planes at the points near them
//! ([`obstacles`]), found again every few sweeps; links that are longer than at rest and at the start pull the cloth along ([`relax`]).

mod floors;
mod layers;
mod net;
mod obstacles;
mod relax;
mod report;

use crate::cloth::Cloth;
use crate::cloth::surface::Posed;
use crate::coat::Coats;
use crate::collider::solid::Solid;
use crate::error::Result;
use crate::findings::thrown;
use crate::number::real::with_w;
use crate::options::Options;
use crate::scene::Scene;
use layers::{Garment, garments};
use net::Net;
use obstacles::{Below, Obstacles, Worn};
use relax::Part;

pub use report::ClearedStart;

impl Scene {
    /// Moves free particles out of what they begin in, so that the first frame does not throw them out: the surface of a body
    /// ([`Cloth::set_body`]), colliders that the cloth meets, and, between garments of cloth with [`Cloth::contact`], garments of layers below. The cloth
    /// around them gives way, so that springs get as little longer as possible. Positions at the start change ([`Cloth::positions`]), nothing else:
    /// rest lengths, pins and joints stay. Call it after [`Cloth::follow_joints`] and [`Cloth::set_body`], before a stepper takes the scene.
    ///
    /// - Pinned particles stay. Where they are inside of a body, the particles around them stay inside too, less and less with their distance along the cloth:
    ///   otherwise springs between both would tear. A particle stays within nine tenths of its [`Cloth::limits`].
    /// - Particles keep the thickness of the cloth from colliders, and what they keep in motion from the surface of a body: 1 mm if they began inside.
    /// - A garment is cloth that seams and stitches hold together, several per cloth or one. [`crate::ClothContact::layer`] says which of two garments is over the
    ///   other; of one layer, the one that most of the other's surface near it faces. Without contact nothing keeps cloths apart, so layers do not count.
    ///
    /// Returns what was found and done per cloth. A scene in which nothing begins inside keeps its bits. Deterministic. Takes some microseconds per
    /// particle to look, and about a second for 16,000 particles of which most begin inside. Errors as [`Scene::check`].
    ///
    /// ```
    /// use gimage_runtime::{Collider, Flat, Options, Scene, Shape};
    ///
    /// let mut scene = Scene::new("a sheet in a ball");
    /// scene.cloths.push(Flat::square("sheet", 17).cloth()?);
    /// scene.colliders.push(Collider::new(Shape::Sphere { radius: 0.2 }, [0.0, -0.15, 0.0]));
    /// let cleared = scene.clear_start(&Options::default())?;
    /// assert!(cleared[0].inside > 0 && cleared[0].left == 0, "{}", cleared[0]);
    /// # Ok::<(), gimage_runtime::Error>(())
    /// ```
    pub fn clear_start(&mut self, options: &Options) -> Result<Vec<ClearedStart>> {
        self.check()?;
        let mut nets: Vec<Net> = self.cloths.iter().map(Net::new).collect();
        let garments = garments(&self.cloths, &nets);
        let new = |(index, (cloth, net)): (usize, (&Cloth, &Net))| ClearedStart::new(index, cloth, net);
        let mut cleared: Vec<_> = self.cloths.iter().zip(&nets).enumerate().map(new).collect();
        let mut floors: Vec<Vec<f64>> =
            self.cloths.iter().zip(&nets).map(|(cloth, net)| floors::floors(cloth, net)).collect();
        let mut is_moved = vec![false; nets.len()];
        for garment in &garments {
            let (index, points) = (garment.cloth, &garment.points[..]);
            let obstacles = self.obstacles(garment, (&garments, &nets), (&floors[index], options));
            if obstacles.is_empty() {
                continue;
            }
            let part = Part { points, links: &garment.links, surface: garment.surface.as_ref() };
            cleared[index].before(&nets[index], points, &obstacles);
            is_moved[index] |= relax::clear(&mut nets[index], &part, &obstacles);
            cleared[index].after(&nets[index], points, &obstacles);
            let Some(worn) = &obstacles.body else { continue };
            for point in points.iter().map(|point| *point as usize) {
                // A point that could not leave may stay as deep.
                let height = worn.height(point, nets[index].at[point]);
                let floor = &mut floors[index][point];
                *floor = floor.min(height.unwrap_or(*floor));
            }
        }
        for (index, cloth) in self.cloths.iter_mut().enumerate() {
            if cloth.body().is_some() {
                cloth.set_floors(&nets[index].of_particle, &floors[index]);
            }
            if is_moved[index] {
                let before = cloth.positions().to_vec();
                cloth.place(nets[index].positions(cloth))?;
                cleared[index].compare(cloth, &before);
            }
        }
        Ok(cleared)
    }

    /// Whether the first frame would throw cloth out of colliders, which [`Scene::clear_start`] prevents: the mean way out of the free particles
    /// of a cloth is longer than 1 mm. Ways out that cancel each other, as of a sleeve around an arm, throw nothing. O(particles x
    /// colliders).
    ///
    /// ```
    /// use gimage_runtime::{Collider, Flat, Options, Scene, Shape};
    ///
    /// let mut scene = Scene::new("a sheet under a floor");
    /// scene.cloths.push(Flat::square("sheet", 17).cloth()?);
    /// scene.colliders.push(Collider::new(Shape::HalfSpace, [0.0, 0.1, 0.0]));
    /// let options = Options::default();
    /// if scene.is_to_clear(&options) {
    ///     scene.clear_start(&options)?;
    /// }
    /// assert!(!scene.is_to_clear(&options));
    /// # Ok::<(), gimage_runtime::Error>(())
    /// ```
    pub fn is_to_clear(&self, options: &Options) -> bool {
        let (coats, places) = Coats::new(self, options);
        let solids = coats.solids::<f32>(&self.colliders);
        self.cloths.iter().zip(places).any(|(cloth, coat)| {
            let at = |(k, p): (usize, &[f32; 3])| with_w(*p, cloth.inverse_mass(k));
            let met = &solids[coat];
            !met.is_empty()
                && thrown::is_to_clear(&cloth.positions().iter().enumerate().map(at).collect::<Vec<_>>(), met)
        })
    }

    /// All that a garment must be outside of, where its body and the garments below are now.
    fn obstacles<'a>(
        &'a self,
        garment: &Garment,
        (garments, nets): (&'a [Garment], &[Net]),
        (floors, options): (&[f64], &Options),
    ) -> Obstacles<'a> {
        let (cloth, net) = (&self.cloths[garment.cloth], &nets[garment.cloth]);
        let thickness = f64::from(cloth.thickness.unwrap_or(options.thickness));
        let body = cloth.body().map(|surface| {
            let posed =
                Posed::by_joints(surface, cloth.skinning, cloth.first_joints().map_or(&[], |matrices| matrices));
            let coats = net.particles.iter().map(|k| f64::from(cloth.coat(*k as usize, options.thickness)));
            let floors = floors.iter().zip(coats).map(|(floor, coat)| floor.min(coat)).collect();
            Worn::new(posed, &net.at, floors, net.normals(cloth))
        });
        let solids = self.met(cloth.met_groups()).map(Solid::new).collect();
        let below = garment.below.iter().filter_map(|place| Below::new(garment, &garments[*place], nets));
        Obstacles { body, solids, thickness, below: below.collect() }
    }
}
