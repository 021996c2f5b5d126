//! glTF 2.0: the pieces in the order in which they are used.

use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;

use super::accessor::Accessors;
use super::buffers::Buffers;
use super::builder::{Builder, Follows};
use super::document::Document;
use super::findings::Findings;
use super::matrix::Matrix;
use super::moving::Moving;
use super::nodes::{Forest, Placed};
use super::origin::Origin;
use super::pieces::Selector;
use super::primitive::{self, Raw};
use super::scene::{self, Scene};
use super::skin::Bones;
use super::source::Source;
use super::{ImportOptions, Resolver, instancing, matrix, stand};
use crate::base::mesh::{Mesh, Part, Semantic};
use crate::error::{Error, Result};
use crate::record::Severity;

/// The result of reading a file.
pub(crate) struct Loaded {
    pub mesh: Mesh,
    pub scene: Scene,
    /// Where each part of the mesh came from.
    pub origins: Vec<Origin>,
}

/// The mesh of a glTF file, given its JSON and its binary chunk.
pub(crate) fn load(
    path: &Path,
    json: &[u8],
    bin: Option<&[u8]>,
    resolver: &Resolver,
    options: &ImportOptions,
    source: &mut Source,
    findings: &mut Findings,
) -> Result<Loaded> {
    let doc = Document::parse(path, json, source)?;
    let buffers = Buffers::new(&doc, bin, resolver, options.max_bytes);
    let max_count = options.max_vertices.max(options.max_triangles.saturating_mul(3));
    let accessors = Accessors { doc: &doc, buffers: &buffers, max_count };
    let forest = Forest::new(&doc)?;
    let mut placed = forest.placed(&doc, findings)?;
    let standing = stand::standing(&accessors, &forest, &placed);
    for p in &mut placed {
        p.world = p.node.and_then(|node| standing.get(&node)).copied().unwrap_or(p.world);
    }
    let message =
        "Skinned meshes stand as their joints pose them and not as their nodes are placed, which viewers ignore.";
    findings.add(Severity::Note, "placed-by-joints", standing.len(), message, || {
        let node = standing.keys().min().copied().unwrap_or_default();
        format!("node {node} `{}`", doc.node_name(node))
    });
    note_what_is_left(&doc, &placed, findings);

    note_morphs(&doc, &placed, findings);

    let mut selector = Selector::new(&options.pieces);
    let mut bones = Bones::new(&accessors, &forest, options.unit);
    let mut builder = Builder::new(path, options);
    let moving = Moving::new(&doc);
    // A mesh is read once, however many nodes place it; it is forgotten after its last.
    let mut uses: HashMap<usize, usize> = HashMap::new();
    placed.iter().for_each(|p| *uses.entry(p.mesh).or_default() += 1);
    let mut origins = Vec::new();
    let mut cache: HashMap<(usize, usize), Option<Rc<Raw>>> = HashMap::new();
    for p in &placed {
        let left = uses.entry(p.mesh).or_default();
        *left -= 1;
        let last = *left == 0;
        let mut kept = Vec::new();
        for k in 0..doc.root.meshes[p.mesh].primitives.len() {
            let part = part(&doc, p, k);
            if !selector.keeps(&part) {
                continue;
            }
            let key = (p.mesh, k);
            let raw = match cache.remove(&key) {
                Some(raw) => raw,
                None => {
                    let (v, t) = (options.max_vertices, options.max_triangles);
                    primitive::load(&accessors, p.mesh, k, v, t, findings)?.map(Rc::new)
                }
            };
            kept.extend(raw.clone().map(|raw| (raw, part)));
            if !last {
                cache.insert(key, raw);
            }
        }
        if kept.is_empty() {
            continue;
        }
        let (list, is_instanced) = instances(&accessors, p, findings)?;
        for instance in list {
            let world = matrix::mul(&p.world, &instance);
            let weighted = |r: &Raw| r.attributes.iter().any(|a| matches!(a.semantic, Semantic::Weights(_)));
            let joints = match p.skin {
                Some(skin) if kept.iter().any(|(raw, _)| weighted(raw)) => {
                    let joints = bones.add(skin, &world)?;
                    let message = "A skinned mesh is scaled flat in the scene, so it cannot follow its joints.";
                    let flat = usize::from(joints.is_none());
                    findings.add(Severity::Warning, "flat-skinned-node", flat, message, || part_name(&doc, p));
                    joints
                }
                _ => None,
            };
            let holder = if p.skin.is_none() { p.node.and_then(|n| moving.holder(&forest, n)) } else { None };
            let held = holder.map_or(Ok(None), |node| bones.hold(node))?;
            let follows = match (&joints, held) {
                (Some(map), _) => Follows::Skin(map),
                (None, Some(joint)) => Follows::Joint(joint),
                (None, None) => Follows::Nothing,
            };
            for (raw, part) in &kept {
                let vertices = builder.place(raw, &world, part.clone(), follows, findings)?;
                let primitive = part.primitive as usize;
                let instance = is_instanced.then_some(instance);
                origins.push(Origin { node: p.node, mesh: p.mesh, primitive, instance, vertices });
            }
        }
    }
    selector.finish()?;
    source.outside = buffers.outside();
    let colliders = bones.colliders(findings);
    let mut mesh = builder.finish();
    if mesh.triangles.is_empty() {
        return Err(empty(path, &doc, findings));
    }
    if mesh.channels.iter().any(|c| matches!(c.semantic, Semantic::Joints(_))) {
        mesh.skeleton = bones.finish();
    }
    let mut scene = scene::scene(&doc);
    scene.colliders = colliders;
    Ok(Loaded { mesh, scene, origins })
}

/// The transforms by which a node places its mesh, in its own space, and whether the file lists them.
fn instances(accessors: &Accessors<'_>, placed: &Placed, findings: &mut Findings) -> Result<(Vec<Matrix>, bool)> {
    let Some(list) = placed.node.map_or(Ok(None), |n| instancing::instances(accessors, n))? else {
        return Ok((vec![matrix::IDENTITY], false));
    };
    let message = "Each instance of an instanced mesh became a copy.";
    findings.add(Severity::Note, "instances", list.len(), message, || part_name(accessors.doc, placed));
    Ok((list, true))
}

fn part(doc: &Document, placed: &Placed, primitive: usize) -> Part {
    let material = doc.root.meshes[placed.mesh].primitives[primitive].material.map(|m| m.value());
    let name = |m: usize| doc.materials.get(m).cloned().unwrap_or_else(|| format!("material {m}"));
    Part {
        node: placed.node.map(|n| doc.node_name(n)).unwrap_or_default(),
        mesh: doc.mesh_name(placed.mesh),
        primitive: primitive as u32,
        material: material.map(name).unwrap_or_default(),
        ..Part::default()
    }
}

fn part_name(doc: &Document, placed: &Placed) -> String {
    placed.node.map_or_else(|| doc.mesh_name(placed.mesh), |n| format!("node {n} `{}`", doc.node_name(n)))
}

fn note_what_is_left(doc: &Document, placed: &[Placed], findings: &mut Findings) {
    let mut shown = vec![false; doc.root.meshes.len()];
    placed.iter().for_each(|p| shown[p.mesh] = true);
    let message = "Meshes that are not in the scene were left out.";
    for (m, _) in shown.iter().enumerate().filter(|(_, s)| !**s) {
        findings.add(Severity::Note, "mesh-not-in-scene", 1, message, || format!("mesh {m} `{}`", doc.mesh_name(m)));
    }
    if doc.root.nodes.is_empty() && !placed.is_empty() {
        let message = "The file has no scene; each of its meshes was placed at the origin.";
        findings.add(Severity::Note, "no-scene", 1, message, || "file".into());
    }
    let message = "Animations are not kept; the scene is read in its rest pose.";
    findings.add(Severity::Note, "animations", doc.animations.len(), message, || "file".into());
}

/// Tells of meshes that the file shows in another shape than the one that is read.
fn note_morphs(doc: &Document, placed: &[Placed], findings: &mut Findings) {
    let message = "The file shows meshes with morph targets that are not read, so the cloth has another shape: apply them in the file.";
    for p in placed {
        let mesh = &doc.root.meshes[p.mesh];
        let of_node = p.node.and_then(|node| doc.root.nodes[node].weights.as_ref());
        let weights = of_node.or(mesh.weights.as_ref());
        let shown = weights.is_some_and(|weights| weights.iter().any(|w| *w != 0.0));
        let has = mesh.primitives.iter().any(|primitive| primitive.targets.as_ref().is_some_and(|t| !t.is_empty()));
        findings.add(Severity::Note, "hint-morphs", usize::from(shown && has), message, || part_name(doc, p));
    }
}

/// Why there is nothing, from what was left out.
fn empty(path: &Path, doc: &Document, findings: &mut Findings) -> Error {
    let lost = std::mem::take(findings).into_vec();
    let reasons: Vec<String> =
        lost.iter().filter(|f| f.severity != Severity::Note).map(|f| f.message.trim_end_matches('.').into()).collect();
    let problem = match (doc.root.meshes.is_empty(), reasons.is_empty()) {
        (true, _) => "it has no meshes".into(),
        (false, true) => "its scene shows no triangles".into(),
        (false, false) => format!("it has no usable triangles ({})", reasons.join("; ")),
    };
    Error::Empty { path: path.to_path_buf(), problem, hint: "export the garment as triangles".into() }
}
