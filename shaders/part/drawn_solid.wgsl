// Corners of the colliders' meshes: position and normal in the collider's frame, an instance a collider. Laid out as
// `BodyRow` in crates/runtime/src/draw/rows.rs.
struct Body {
  rotation: vec4<f32>,
  center: vec3<f32>,
  fade: f32,
  color: vec4<f32>,
}
@group(0) @binding(1) var<storage, read> bodies: array<Body>;
@group(0) @binding(2) var<storage, read> mesh: array<vec4<f32>>;

fn turned(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
  let t = cross(q.xyz, v) * 2.0;
  return v + t * q.w + cross(q.xyz, t);
}

fn corner(vertex: u32, instance: u32) -> Corner {
  let body = bodies[instance];
  let p = mesh[2u * vertex];
  let n = mesh[2u * vertex + 1u];
  let at = turned(body.rotation, p.xyz) + body.center;
  let normal = turned(body.rotation, n.xyz);
  return Corner(at, normal, vec2<f32>(p.w, n.w), body.color, vec4<f32>(body.color.xyz, body.fade));
}
