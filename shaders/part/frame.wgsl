// The frame of the drawn surface at the point of a vertex of a bound mesh.
// `action`: how far from the positions one step before to those now (x).
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> before: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read> normals: array<vec4<f32>>;
// Four per vertex: the corners of its triangle, all ones for a vertex that is not bound, and the weight of the second; the weight of
// the third, and the offset; the normal in the frame; the tangent in the frame, and the sign of the bitangent.
@group(0) @binding(65) var<storage, read> bound_vertices: array<vec4<u32>>;

// The square of the length below which an interpolated normal has no direction, and the share of the square of an edge that has to be
// across the normal.
const NO_NORMAL = 1e-6;
const ALONG = 1e-6;

struct VertexFrame {
  tangent: vec3<f32>,
  bitangent: vec3<f32>,
  normal: vec3<f32>,
  // The first corner of the triangle, and the way from there to the point.
  corner: vec3<f32>,
  way: vec3<f32>,
}

fn direction(v: vec3<f32>) -> vec3<f32> {
  let length = sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
  return select(vec3<f32>(0.0), v * (1.0 / length), length > 0.0);
}

fn at(k: u32) -> vec3<f32> {
  let b = before[k].xyz;
  let n = now[k].xyz;
  return select(b + (n - b) * action[0].x, n, action[0].x == 1.0);
}

fn across(edge: vec3<f32>, normal: vec3<f32>) -> vec4<f32> {
  let rest = edge - normal * dot(edge, normal);
  return vec4<f32>(rest, select(0.0, 1.0, dot(rest, rest) > ALONG * dot(edge, edge)));
}

// The axis of the space that is the least along a normal.
fn axis(normal: vec3<f32>) -> vec3<f32> {
  let size = abs(normal);
  if (size.x <= size.y && size.x <= size.z) {
    return vec3<f32>(1.0, 0.0, 0.0);
  }
  return select(vec3<f32>(0.0, 0.0, 1.0), vec3<f32>(0.0, 1.0, 0.0), size.y <= size.z);
}

// That of a vertex that is bound.
fn vertex_frame(n: u32) -> VertexFrame {
  let head = bound_vertices[4u * n];
  let s = bitcast<f32>(head.w);
  let t = bitcast<f32>(bound_vertices[4u * n + 1u].x);
  let a = at(head.x);
  let first = at(head.y) - a;
  let second = at(head.z) - a;
  let na = normals[head.x].xyz;
  let sum = na + (normals[head.y].xyz - na) * s + (normals[head.z].xyz - na) * t;
  var normal = direction(sum);
  if (dot(sum, sum) <= NO_NORMAL) {
    normal = direction(cross(second, first));
  }
  if (dot(normal, normal) == 0.0) {
    normal = vec3<f32>(0.0, 0.0, 1.0);
  }
  var edge = across(first, normal);
  if (edge.w == 0.0) {
    edge = across(second, normal);
  }
  if (edge.w == 0.0) {
    edge = across(axis(normal), normal);
  }
  let tangent = direction(edge.xyz);
  return VertexFrame(tangent, cross(normal, tangent), normal, a, first * s + second * t);
}

fn outward(frame: VertexFrame, v: vec3<f32>) -> vec3<f32> {
  return frame.tangent * v.x + frame.bitangent * v.y + frame.normal * v.z;
}
