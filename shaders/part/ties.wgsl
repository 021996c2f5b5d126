// Nodes at a seam move as those on its other side do. Row n is first and end of the ties of level n + 1, and the end of
// those between duplicates of one point, which come first; a tie is up to four nodes. One workgroup has all grids of a cloth.

const NO_NODE: u32 = 0xffffffffu;

// All take the mean of their displacements by mass, or stay where one is pinned.
fn tie(head: vec4<u32>, local: u32, n: u32) {
  let row = ties_at(head.z + n - 1u);
  for (var t = row.x + local; t < ties_end(row); t += threads) {
    let these = ties_at(head.z + t);
    var sum = vec3<f32>(0.0);
    var mass = 0.0;
    var pinned = false;
    for (var m = 0u; m < 4u; m++) {
      if (these[m] != NO_NODE) {
        let at = nodes[2u * (head.w + these[m])];
        let weight = 1.0 / max(at.w, 1e-30);
        sum = sum + (at.xyz - nodes[2u * (head.w + these[m]) + 1u].xyz) * weight;
        mass = mass + weight;
        pinned = pinned || at.w <= 0.0;
      }
    }
    let by = select(sum * (1.0 / max(mass, 1e-30)), vec3<f32>(0.0), pinned);
    for (var m = 0u; m < 4u; m++) {
      if (these[m] != NO_NODE) {
        let k = 2u * (head.w + these[m]);
        nodes[k] = vec4<f32>(nodes[k + 1u].xyz + by, nodes[k].w);
      }
    }
  }
  storageBarrier();
}
