// Nodes of one level at a seam move as those on its other side do, where tiles have limited its lengths. One workgroup.
@group(0) @binding(21) var<storage, read_write> nodes: array<vec4<f32>>;

// The level, from 1 for the finest.
override level: u32 = 1u;

const GROUP: u32 = 256u;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) local: u32) {
  tie(local, level);
}
