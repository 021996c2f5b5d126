// Triangles that were cut out: bit 0 of a texel is the one below its quad's diagonal, bit 1 the one above.
@group(0) @binding(10) var<storage, read> holes: array<u32>;

fn hole(k: u32, bit: u32) -> bool {
  return (holes[k] >> bit & 1u) == 1u;
}
