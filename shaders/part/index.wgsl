// The element of a thread where elements are in a list: workgroups of 64 in rows, because x alone is limited to 65,535.
fn element(workgroup: vec3<u32>, rows: vec3<u32>, local: u32) -> u32 {
  return (workgroup.y * rows.x + workgroup.x) * 64u + local;
}
