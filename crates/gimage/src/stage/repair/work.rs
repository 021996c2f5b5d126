//! The mesh under repair: every triangle keeps its attributes and remembers which triangle of the input it was.

use crate::base::mesh::{Mesh, NONE};
use crate::base::words;
use crate::record::{Finding, MAX_EXAMPLES, Severity};

/// The mesh under repair.
pub(super) struct Work {
    pub mesh: Mesh,
    /// For each triangle, its index in the input.
    pub source: Vec<u32>,
    pub findings: Vec<Finding>,
}

impl Work {
    /// Takes the mesh in; lists of the wrong length are filled up, so that later steps need not look.
    pub fn new(mut mesh: Mesh) -> Self {
        let n = mesh.triangles.len();
        mesh.triangle_part.resize(n, 0);
        for channel in &mut mesh.channels {
            channel.corners.resize(3 * n, NONE);
        }
        Work { mesh, source: (0..n as u32).collect(), findings: Vec::new() }
    }

    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.mesh.triangles.len()
    }

    /// Keeps the triangles `keep` says, in their order; returns how many went.
    pub fn retain(&mut self, keep: &[bool]) -> usize {
        let kept: Vec<usize> = (0..self.len()).filter(|&t| keep[t]).collect();
        let gone = self.len() - kept.len();
        if gone == 0 {
            return 0;
        }
        let mesh = &mut self.mesh;
        for (to, &from) in kept.iter().enumerate() {
            mesh.triangles[to] = mesh.triangles[from];
            mesh.triangle_part[to] = mesh.triangle_part[from];
            self.source[to] = self.source[from];
            for channel in &mut mesh.channels {
                channel.corners.copy_within(3 * from..3 * from + 3, 3 * to);
            }
        }
        mesh.triangles.truncate(kept.len());
        mesh.triangle_part.truncate(kept.len());
        self.source.truncate(kept.len());
        for channel in &mut mesh.channels {
            channel.corners.truncate(3 * kept.len());
        }
        gone
    }

    /// Appends a copy of triangle `t`, attributes and all; returns its index.
    pub fn duplicate(&mut self, t: usize) -> usize {
        let mesh = &mut self.mesh;
        mesh.triangles.push(mesh.triangles[t]);
        mesh.triangle_part.push(mesh.triangle_part[t]);
        self.source.push(self.source[t]);
        for channel in &mut mesh.channels {
            channel.corners.extend_from_within(3 * t..3 * t + 3);
        }
        mesh.triangles.len() - 1
    }

    /// Turns triangle `t` over.
    pub fn reverse(&mut self, t: usize) {
        self.mesh.triangles[t].swap(1, 2);
        for channel in &mut self.mesh.channels {
            channel.corners.swap(3 * t + 1, 3 * t + 2);
        }
    }

    /// Replaces the vertices of all triangles.
    pub fn rename(&mut self, mut name: impl FnMut(u32) -> u32) {
        for v in self.mesh.triangles.iter_mut().flatten() {
            *v = name(*v);
        }
    }

    /// Which vertices a triangle uses.
    pub fn used(&self) -> Vec<bool> {
        let mut used = vec![false; self.mesh.positions.len()];
        for &v in self.mesh.triangles.iter().flatten() {
            used[v as usize] = true;
        }
        used
    }

    /// Words for a triangle, by its index in the input.
    pub fn triangle_words(&self, t: usize) -> String {
        format!("triangle {}", self.source[t])
    }

    /// Words for a vertex.
    pub fn vertex_words(&self, v: u32) -> String {
        format!("vertex {v} at {}", words::point(self.mesh.positions[v as usize]))
    }

    /// Records a finding, unless it never happened.
    pub fn report(
        &mut self,
        severity: Severity,
        kind: &'static str,
        count: usize,
        mut examples: Vec<String>,
        message: String,
    ) {
        if count > 0 {
            examples.truncate(MAX_EXAMPLES);
            self.findings.push(Finding { severity, stage: "repair", kind, count: count as u64, examples, message });
        }
    }
}
