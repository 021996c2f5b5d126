//! The same pictures on the CPU, for machines without an adapter. Four samples per pixel, each lit by itself.

use super::flat::{Flat, Kind, Samples, Shade, cover, flatten};
use super::ground::{Ground, Shadow};
use super::raster::{Corner, Drawn, decoded, encoded};
use super::rows::{BodyRow, ViewRow};
use super::surface::{Facet, Hidden, Paint};
use super::{Look, SolidLook, View, mesh, turned};
use crate::collider::{Collider, Shape};
use crate::cpu::rows::Threads;
use crate::error::{Error, Result, check};
use crate::handle::ClothRef;
use crate::look::Looks;
use crate::number::real::{add, xyz};
use crate::stepper::Stepper;

/// Most pixels on a side of a picture.
pub const MAX_SIDE: u32 = 8192;
/// Rows of pixels that are worked on at a time.
const BAND: usize = 16;

/// A painter of pictures of one size.
pub struct Software {
    width: u32,
    height: u32,
    threads: Threads,
    looks: Looks,
    facets: Vec<Facet>,
    paints: Vec<Paint>,
    white: Paint,
    /// Cloths and colliders that are left out.
    pub hidden: Hidden,
    /// How colliders are drawn.
    pub solid_look: SolidLook,
    /// The ground with its shadow; none by default.
    pub ground: Option<Ground>,
}

/// The particles of a cloth, as [`Stepper::positions`], [`Stepper::previous`], [`Stepper::normals`] and [`Stepper::holes`] return them, or as
/// they are read back from a device.
#[derive(Clone, Copy, Debug, Default)]
pub struct SheetView<'a> {
    /// Positions \[m\] now.
    pub now: &'a [[f32; 4]],
    /// Positions one step before.
    pub before: &'a [[f32; 4]],
    /// Unit normals now.
    pub normals: &'a [[f32; 4]],
    /// Triangles that cuts have taken away.
    pub holes: Option<&'a [u32]>,
}

/// Triangles of a picture and their colours.
struct Contents<'a> {
    size: [f32; 2],
    flats: Vec<Flat>,
    shades: Vec<Shade<'a>>,
    /// Triangles that cast a shadow, if there is a ground.
    casting: Option<Vec<[[f32; 3]; 3]>>,
}

impl Contents<'_> {
    /// Adds a triangle in the last shade.
    fn add(&mut self, t: [Corner; 3]) {
        self.add_in(self.shades.len().saturating_sub(1), t);
    }

    fn add_in(&mut self, shade: usize, t: [Corner; 3]) {
        let Some(of) = self.shades.get(shade) else { return };
        if let Some(casting) = self.casting.as_mut().filter(|_| matches!(of.kind, Kind::Plain | Kind::Painted(_))) {
            casting.push(t.map(|c| c.at));
        }
        flatten(t, (shade, of), self.size, &mut self.flats);
    }
}

impl Software {
    /// Errors on sides outside 1 to 8192 and where no threads can be started; `threads` as in [`crate::Options`].
    pub fn new(width: u32, height: u32, threads: usize) -> Result<Self> {
        for side in [width, height] {
            check("a side of a picture [pixels]", side.into(), "1 to 8192", |s| {
                (1.0..=f64::from(MAX_SIDE)).contains(&s)
            })?;
        }
        let (threads, white) = (Threads::new(threads)?, Paint::default());
        let (looks, hidden, facets, paints, solid_look) = Default::default();
        Ok(Software { width, height, threads, looks, hidden, facets, paints, white, solid_look, ground: None })
    }

    /// How a cloth is drawn from now on; an index is that of the cloth when it is drawn.
    pub fn set_look(&mut self, cloth: impl Into<ClothRef>, look: Look) {
        self.looks.set(cloth.into(), look);
    }

    /// The paints of facets from now on.
    pub fn set_paints(&mut self, paints: Vec<Paint>) {
        self.paints = paints;
    }

    /// Draws these triangles from now on, in place of those of the last call.
    pub fn set_surface(&mut self, facets: Vec<Facet>) {
        self.facets = facets;
    }

    /// The picture, a row after the other from the top, sRGB and opaque. Takes a stepper on the CPU backend; `fraction`
    /// as in [`crate::Progress`]. Errors on other steppers, if a cloth of them is drawn, and on texture coordinates that do not fit their
    /// cloth. Time is linear in pixels and triangles; the result does not depend on the threads.
    pub fn picture(&self, stepper: &Stepper, view: &View, fraction: f32) -> Result<Vec<[u8; 4]>> {
        let sheet = |index: usize| {
            let lists = (stepper.positions(index), stepper.previous(index), stepper.normals(index));
            let (Some(now), Some(before), Some(normals)) = lists else { return SheetView::default() };
            SheetView { now, before, normals, holes: stepper.holes(index) }
        };
        let sheets: Vec<_> = (0..stepper.scene().cloths.len()).map(sheet).collect();
        if (0..sheets.len()).any(|c| sheets[c].now.is_empty() && !self.hidden.cloths.contains(&c)) {
            return Err(Error::GpuOnly("Software"));
        }
        self.picture_of(stepper, &sheets, view, fraction)
    }

    /// As [`Software::picture`] on any backend, from the particles of all cloths; those of hidden cloths may be empty. Errors on lists that
    /// do not fit their cloth.
    pub fn picture_of(
        &self,
        stepper: &Stepper,
        sheets: &[SheetView],
        view: &View,
        fraction: f32,
    ) -> Result<Vec<[u8; 4]>> {
        let size = [self.width as f32, self.height as f32];
        let casting = self.ground.map(|_| Vec::new());
        let mut all = Contents { size, flats: Vec::new(), shades: Vec::new(), casting };
        let shown = |(c, _): &(usize, _)| !self.hidden.cloths.contains(c);
        for (index, cloth) in stepper.scene().cloths.iter().enumerate().filter(shown) {
            let SheetView { now, before, normals, holes } = sheets.get(index).copied().unwrap_or_default();
            let look = self.looks.of(index, stepper.handles()[index]);
            let (uv, expected) = (look.uv.as_deref(), cloth.len());
            let lengths = [("positions", now.len()), ("positions", before.len()), ("normals", normals.len())];
            let lengths = lengths.into_iter().chain(uv.map(|uv| ("texture coordinates", uv.len())));
            if let Some((what, found)) = lengths.into_iter().find(|(_, found)| *found != expected) {
                return Err(Error::Length { cloth: cloth.name().to_owned(), what, found, expected });
            }
            let row = ViewRow::cloth(view, &look, look.jump(cloth.grids()), fraction);
            let [front, back] = [row.front, row.back].map(xyz);
            all.shades.push(Shade { view: row, front, back, fade: 0.0, kind: Kind::Plain });
            let drawn = Drawn { now, before, normals, holes, uv };
            for grid in cloth.grids() {
                let (first, width, height) = (grid.first as usize, grid.width as usize, grid.height as usize);
                drawn.triangles(first, width, height, &row, |t| all.add(t));
            }
        }
        let shown = stepper.scene().colliders.iter().enumerate();
        shown.filter(|(c, _)| !self.hidden.colliders.contains(c)).for_each(|(_, c)| self.solid(c, view, &mut all));
        self.surface(view, &mut all);
        self.ground(view, &mut all);
        Ok(self.paint(&all, view))
    }

    fn solid<'a>(&'a self, collider: &Collider, view: &View, all: &mut Contents<'a>) {
        let (row, body) = (ViewRow::solids(view), BodyRow::new(collider, self.solid_look.color));
        let color = xyz(body.color);
        let kind = if collider.shape == Shape::HalfSpace { Kind::Floor } else { Kind::Plain };
        all.shades.push(Shade { view: row, front: color, back: color, fade: body.fade, kind });
        for triangle in mesh::of(&collider.shape, self.solid_look.inset).as_chunks::<3>().0 {
            let corner = |v: &mesh::Vertex| Corner {
                at: add(turned(body.rotation, xyz(v[0])), body.center),
                normal: turned(body.rotation, xyz(v[1])),
                uv: [v[0][3], v[1][3]],
                color: [1.0; 4],
            };
            all.add([0, 1, 2].map(|c| corner(&triangle[c])));
        }
    }

    fn surface<'a>(&'a self, view: &View, all: &mut Contents<'a>) {
        let row = ViewRow::solids(view);
        let first = all.shades.len();
        for paint in self.paints.iter().chain([&self.white]) {
            let white = [1.0; 3];
            all.shades.push(Shade { view: row, front: white, back: white, fade: 0.0, kind: Kind::Painted(paint) });
        }
        for f in &self.facets {
            let corner = |c: usize| Corner { at: f.corners[c], normal: f.normals[c], uv: f.uv[c], color: f.colors[c] };
            all.add_in(first + f.paint.min(self.paints.len()), [0, 1, 2].map(corner));
        }
    }

    fn ground<'a>(&'a self, view: &View, all: &mut Contents<'a>) {
        let Some(ground) = self.ground.as_ref().filter(|_| !all.shades.iter().any(|s| matches!(s.kind, Kind::Floor)))
        else {
            return;
        };
        let (view_row, white) = (ViewRow::solids(view), [1.0; 3]);
        all.shades.push(Shade { view: view_row, front: white, back: white, fade: 0.0, kind: Kind::Ground(ground) });
        let corner = |at| Corner { at, normal: [0.0, 1.0, 0.0], uv: [0.0; 2], color: [1.0; 4] };
        ground.triangles(view).into_iter().for_each(|t| all.add(t.map(corner)));
    }

    fn paint(&self, all: &Contents, view: &View) -> Vec<[u8; 4]> {
        let width = self.width as usize;
        let mut pixels = vec![[0, 0, 0, 255]; width * self.height as usize];
        let background = view.background.map(decoded);
        let shadow = self.ground.zip(all.casting.as_ref());
        let shadow = shadow.and_then(|(ground, of)| Shadow::new(of, ground.height, &ViewRow::solids(view)));
        self.threads.chunks(&mut pixels, width * BAND, |band, pixels| {
            let top = band * BAND;
            let mut samples: Vec<Samples> = vec![[(f32::INFINITY, background); 4]; pixels.len()];
            for flat in &all.flats {
                cover(flat, &all.shades, shadow.as_ref(), (top, width), &mut samples);
            }
            for (pixel, samples) in pixels.iter_mut().zip(&samples) {
                for (c, number) in pixel[..3].iter_mut().enumerate() {
                    let light = samples.iter().map(|s| s.1[c].clamp(0.0, 1.0)).sum::<f32>() / 4.0;
                    *number = (encoded(light) * 255.0 + 0.5) as u8;
                }
            }
        });
        pixels
    }
}
