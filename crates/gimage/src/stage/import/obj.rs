//! Wavefront OBJ to a mesh: positions stay shared as in the file, corners keep their own texture coordinates and normals.

use std::path::Path;

use super::findings::Findings;
use super::obj_parse::{Corner, Text, parse};
use super::pieces::Selector;
use super::source::Source;
use super::{EXPORT_AGAIN, ImportOptions, builder, malformed, polygon};
use crate::base::mesh::{Channel, Mesh, NONE, Semantic, Skeleton};
use crate::error::{Error, Result};
use crate::record::Severity;

/// Largest polygon that is read; beyond it is surely a mistake.
const MAX_CORNERS: usize = 10_000;

/// The mesh of an OBJ file.
pub(crate) fn load(
    path: &Path,
    bytes: &[u8],
    options: &ImportOptions,
    source: &mut Source,
    findings: &mut Findings,
) -> Result<Mesh> {
    let mut text = parse(path, bytes, options, findings)?;
    source.extras = std::mem::take(&mut text.comments);
    let mut selector = Selector::new(&options.pieces);
    let kept: Vec<bool> = text.parts.iter().map(|p| selector.keeps(p)).collect();
    selector.finish()?;
    let (corners, triangle_part) = triangles(path, &text, &kept, options, findings)?;
    if corners.is_empty() {
        let problem = match (text.positions.is_empty(), text.faces.is_empty()) {
            (true, _) => "it has no vertices",
            (_, true) => "it has vertices and no faces",
            _ => "no face has an area",
        };
        let hint = "export the garment with its faces".into();
        return Err(Error::Empty { path: path.to_path_buf(), problem: problem.into(), hint });
    }
    let mut channels = Vec::new();
    if text.normals.iter().any(|n| n.iter().any(|x| *x != 0.0)) {
        let unit = |n: &[f32; 3]| {
            let length = n.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
            n.map(|x| (f64::from(x) / length) as f32)
        };
        channels.push(channel(Semantic::Normal, text.normals.iter().map(unit).collect(), &corners, 2, findings));
    }
    if !text.uvs.is_empty() {
        // OBJ counts v up from the bottom of the image, glTF down from its top.
        let flipped = text.uvs.iter().map(|&[u, v]| [u, 1.0 - v]).collect();
        channels.push(channel(Semantic::TexCoord(0), flipped, &corners, 1, findings));
    }
    if !text.colors.is_empty() {
        let mut colors = std::mem::take(&mut text.colors);
        colors.resize(text.positions.len(), [f32::NAN; 4]);
        channels.push(channel(Semantic::Color(0), colors, &corners, 0, findings));
    }
    channels.retain(|c| c.corners.iter().any(|&k| k != NONE));

    let mut triangles: Vec<[u32; 3]> = corners.as_chunks::<3>().0.iter().map(|t| t.map(|c| c[0])).collect();
    let used = builder::compact(triangles.as_flattened_mut(), text.positions.len());
    let positions = used.iter().map(|&v| text.positions[v as usize].map(|x| x * options.unit)).collect::<Vec<_>>();
    if positions.iter().flatten().any(|x| !x.is_finite()) {
        let problem = "its vertices in metres overflow".into();
        return Err(Error::Option { option: "unit".into(), problem, hint: "give a smaller unit".into() });
    }
    let mut mesh =
        Mesh { positions, triangles, triangle_part, parts: text.parts, channels, skeleton: Skeleton::default() };
    let parts = builder::compact(&mut mesh.triangle_part, mesh.parts.len());
    mesh.parts = parts.iter().map(|&p| mesh.parts[p as usize].clone()).collect();
    Ok(mesh)
}

/// The corners of all triangles of the kept parts, and their parts.
fn triangles(
    path: &Path,
    text: &Text,
    kept: &[bool],
    options: &ImportOptions,
    findings: &mut Findings,
) -> Result<(Vec<Corner>, Vec<u32>)> {
    let (mut out, mut parts) = (Vec::new(), Vec::new());
    let (mut ring, mut points) = (Vec::new(), Vec::new());
    for (k, face) in text.faces.iter().enumerate() {
        let end = text.faces.get(k + 1).map_or(text.corners.len(), |f| f.start);
        let corners = &text.corners[face.start..end];
        let element = || format!("line {}, face {}", face.line, k + 1);
        if let Some(c) = corners.iter().find(|c| c[0] as usize >= text.positions.len()) {
            let problem = format!("it uses vertex {}, and there are {}", u64::from(c[0]) + 1, text.positions.len());
            return Err(malformed(path, element(), problem, EXPORT_AGAIN));
        }
        if !kept[face.part as usize] {
            continue;
        }
        if corners.len() > MAX_CORNERS {
            let problem = format!("it has {} corners, and at most {MAX_CORNERS} are read", corners.len());
            return Err(malformed(path, element(), problem, "triangulate the face before exporting"));
        }
        ring.clear();
        ring.extend_from_slice(corners);
        ring.dedup_by_key(|c| c[0]);
        while ring.len() > 1 && ring[0][0] == ring[ring.len() - 1][0] {
            ring.pop();
        }
        let repeated = corners.len() - ring.len();
        let message = "Vertices that a face names twice in a row were read once.";
        findings.add(Severity::Repair, "repeated-vertices", repeated, message, element);
        if ring.len() < 3 {
            let message = "Faces with fewer than three different vertices were left out.";
            findings.add(Severity::Repair, "degenerate-faces", 1, message, element);
            continue;
        }
        points.clear();
        points.extend(ring.iter().map(|c| text.positions[c[0] as usize]));
        let (local, quality) = polygon::triangulate(&points);
        let forced = usize::from(quality == polygon::Quality::Forced);
        let message = "Faces that cross themselves or have no area were cut into triangles that may overlap.";
        findings.add(Severity::Warning, "crossed-faces", forced, message, element);
        out.extend(local.iter().flatten().map(|&i| ring[i]));
        parts.resize(out.len() / 3, face.part);
        builder::check_size(path, options, 0, parts.len())?;
    }
    Ok((out, parts))
}

/// A channel from one of the three indices of each corner; values out of range or not finite are left out and reported.
fn channel<const N: usize>(
    semantic: Semantic,
    values: Vec<[f32; N]>,
    corners: &[Corner],
    index: usize,
    findings: &mut Findings,
) -> Channel {
    let sound: Vec<bool> = values.iter().map(|v| v.iter().all(|x| x.is_finite())).collect();
    let (mut outside, mut lost) = (Vec::new(), Vec::new());
    let pick = |(c, corner): (usize, &Corner)| match (corner[index], sound.get(corner[index] as usize)) {
        (NONE, _) => NONE,
        (k, Some(true)) => k,
        (_, Some(false)) => {
            lost.push(c);
            NONE
        }
        (_, None) => {
            outside.push(c);
            NONE
        }
    };
    let picked = corners.iter().enumerate().map(pick).collect();
    let place = |c: usize| format!("triangle {}, corner {}", c / 3, c % 3);
    let message = "Texture coordinates or normals that are not in the file were left out.";
    findings.add(Severity::Repair, "attribute-out-of-range", outside.len(), message, || place(outside[0]));
    if semantic != (Semantic::Color(0)) {
        let message = "Attribute values that are not finite, and normals without a direction, were left out.";
        findings.add(Severity::Repair, "attribute-values", lost.len(), message, || place(lost[0]));
    }
    let values = values.iter().flatten().map(|&v| if v.is_finite() { v } else { 0.0 }).collect();
    Channel { semantic, width: N, values, corners: picked }
}
