//! Converts a garment mesh to a bundle of geometry images.
//!
//! [`pipeline::build`] runs all stages: [`import`] reads a file to a [`mesh::Mesh`], [`repair`] makes it an oriented manifold,
//! [`component`] separates pieces from accessories; each piece is then cut to a disk, mapped to a rectangle, resampled, and
//! compared with its surface ([`gate`]). [`options::BuildOptions`] has all settings, [`reconstruct`] converts a bundle back to a
//! mesh.
//!
//! ```no_run
//! use gimage::{options::BuildOptions, pipeline, progress::Quiet};
//!
//! let built = pipeline::build("shirt.glb".as_ref(), &BuildOptions::default(), &Quiet)?;
//! gimage_bundle::dir::write_dir(&built.bundle, "shirt.gim".as_ref(), false)?;
//! # Ok::<(), gimage::Error>(())
//! ```
//!
//! The stages in [`stage`] each take plain data and return plain data, so that they can be run one by one:
//!
//! ```
//! use gimage::options::{BuildOptions, ImageSize};
//! use gimage::stage::assemble::{Piece, assemble};
//! use gimage::stage::image::{ImageOptions, finish};
//! use gimage::stage::parameterize::{Source, map};
//! use gimage::stage::{component, cut, layout, repair};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // A sleeve: 24 columns of quads around, 8 rows along it.
//! let mut mesh = gimage::Mesh::default();
//! for k in 0..24 * 9 {
//!     let (sin, cos) = (f64::from(k % 24) / 24.0 * std::f64::consts::TAU).sin_cos();
//!     mesh.positions.push([0.1 * cos, 0.05 * f64::from(k / 24), 0.1 * sin]);
//! }
//! for k in 0..24 * 8 {
//!     let next = k / 24 * 24 + (k + 1) % 24;
//!     mesh.triangles.extend([[k, k + 24, next], [next, k + 24, next + 24]]);
//! }
//!
//! let mut options = BuildOptions::default();
//! options.image.size = ImageSize::Texels(400);
//! let mesh = repair::repair(mesh, &options.repair)?.mesh;
//! let parts = component::split(&mesh, &options.component);
//! let component = &parts.pieces[0];
//! let surface = component::extract(&mesh, component);
//!
//! // From here on, one surface: cut, layout, map, texels.
//! let settings = ImageOptions::new(&options, Some(400));
//! let cuts = cut::cuts(&component.name, &surface, None, &settings)?;
//! let (k, layout) = layout::choose(&cuts, settings.size, settings.search).ok_or("too few texels")?;
//! let loops = cut::Loops::new(&surface).ok_or("not a manifold")?;
//! let source = Source { name: &component.name, surface: &surface, rim: &loops.rim };
//! let map = map(&source, &cuts[k].disk, &cuts[k].border, &layout, None, &settings)?;
//! let image = finish(&source, &loops, &cuts[k].cut, map, &settings)?;
//! assert!(image.closed, "the image welds to a tube");
//!
//! let mut bundle = gimage_bundle::Bundle::new("an example");
//! let pieces = [Piece { component, surface, image }];
//! assemble(&mut bundle, &mesh, &pieces, &[], &[], &options, &|| ())?;
//! bundle.count()?;
//! assert!(gimage_bundle::validate(&bundle).is_empty());
//! # Ok(())
//! # }
//! ```

mod base;
pub mod error;
pub mod options;
pub mod pipeline;
pub mod progress;
pub mod record;
pub mod report;
pub mod stage;

pub use base::{closest, grid, halfedge, mesh, surface, topology};
pub use stage::assemble::{backstops, blends, limits, mass, pins, springs};
pub use stage::image::{judge, ladder};
pub use stage::measure::stretch;
pub use stage::{
    blend, caps, colliders, component, contents, export, gate, hold, import, measure, reconstruct, render, repair,
    select, shell, stitch, strands,
};

pub use error::{Error, Result};
pub use mesh::Mesh;
