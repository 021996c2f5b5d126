// Keeps all units of a device busy for a moment, so that its clock is at its working speed.

@group(0) @binding(0) var<storage, read_write> sums: array<f32>;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    var sum = f32(id.x);
    for (var k = 0u; k < 20000u; k += 1u) {
        sum = fma(sum, 0.999, 0.001);
    }
    sums[id.x] = sum;
}
