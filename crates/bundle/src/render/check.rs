//! The rules of `render.glb`.

use crate::bundle::Bundle;
use crate::error::Result;
use crate::particle::Particle;
use crate::render::{BLEND, COORD, JOINTS, OFFSET, RENDER_FILE, RenderFile, RenderPrimitive, WEIGHTS, damaged};
use crate::surface::SurfacePoint;
use crate::validate::{Fault, FaultKind};

/// The broken rules of the file of a bundle, of each primitive the first.
pub(crate) fn check_render(bundle: &Bundle, particles: &[Particle]) -> Vec<Fault> {
    let fault = |kind, message| Fault { file: RENDER_FILE.into(), piece: None, texel: None, kind, message };
    let (bytes, entry) = match (&bundle.render, &bundle.manifest.render) {
        (None, None) => return Vec::new(),
        (Some(bytes), Some(entry)) => (bytes, entry),
        (Some(_), None) => return vec![fault(FaultKind::Manifest, "the manifest has no `render`".into())],
        (None, Some(_)) => return vec![fault(FaultKind::Manifest, "the manifest has `render`, but no file".into())],
    };
    let primitives = match RenderFile::parse(bytes).and_then(|file| file.primitives()) {
        Ok(primitives) => primitives,
        Err(error) => return vec![fault(FaultKind::Render, error.to_string())],
    };
    let faulty = |p: &RenderPrimitive| check_primitive(bundle, particles, p).err();
    let mut found: Vec<Fault> =
        primitives.iter().filter_map(faulty).map(|e| fault(FaultKind::Render, e.to_string())).collect();
    let bound = primitives.iter().flat_map(|p| &p.coords).filter(|c| c[0] >= 0.0).count() as u64;
    if bound != entry.bound {
        found.push(fault(FaultKind::Count, format!("render.bound is {}, but the file binds {bound}", entry.bound)));
    }
    found
}

fn check_primitive(bundle: &Bundle, particles: &[Particle], p: &RenderPrimitive) -> Result<()> {
    for (v, (coord, offset)) in p.coords.iter().zip(&p.offsets).enumerate() {
        let bad =
            |problem: String| Err(damaged(format!("mesh {}, primitive {}, vertex {v}", p.mesh, p.index), problem));
        if !coord.iter().chain(offset).all(|x| x.is_finite()) {
            return bad(format!("{COORD} or {OFFSET} is not finite"));
        }
        let [piece, u, v] = *coord;
        if piece == -1.0 {
            continue;
        }
        let entry = Some(piece).filter(|p| *p >= 0.0 && p.fract() == 0.0);
        let Some(entry) = entry.and_then(|p| bundle.manifest.pieces.get(p as usize)) else {
            return bad(format!("{piece} is not the index of a piece"));
        };
        let first = entry.first_particle as usize;
        let exists = |k: u32| particles.get(first + k as usize).is_some_and(|p| p.exists());
        if SurfacePoint::at((entry.width, entry.height), exists, [u, v]).is_none() {
            return bad(format!("({u}, {v}) is not on the surface of piece {}", entry.name));
        }
    }
    if let Some((v, share)) = p.blends.iter().enumerate().find(|(_, share)| !(0.0..=1.0).contains(*share)) {
        let element = format!("mesh {}, primitive {}, vertex {v}", p.mesh, p.index);
        return Err(damaged(element, format!("{BLEND} is {share}, not a share from 0 to 1")));
    }
    let joints = bundle.manifest.skeleton.as_ref().map_or(0, |s| s.joints.len());
    for (v, own) in p.influences.chunks(p.sets.max(1)).enumerate() {
        let bad =
            |problem: String| Err(damaged(format!("mesh {}, primitive {}, vertex {v}", p.mesh, p.index), problem));
        if own.iter().flat_map(|(j, _)| j).any(|j| *j as usize >= joints) {
            return bad(format!("{JOINTS} has an index that is not that of one of the {joints} joints"));
        }
        let weights = || own.iter().flat_map(|(_, w)| w);
        let sum: f64 = weights().map(|w| f64::from(*w)).sum();
        if weights().any(|w| w.is_nan() || *w < 0.0) || (sum - 1.0).abs() > 1e-3 {
            return bad(format!("{WEIGHTS} sum to {sum:.4}, or one is negative"));
        }
    }
    Ok(())
}
