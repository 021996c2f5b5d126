// Whether a place is a number and within all bounds, by its bits: those of NaN and of infinity are greater than those of every
// number. A compiler that takes it for granted that there is no NaN may drop a comparison of numbers.
fn sane(p: vec4<f32>) -> bool {
  let bits = bitcast<vec3<u32>>(p.xyz) & vec3<u32>(0x7fffffffu);
  return all(bits <= vec3<u32>(bitcast<u32>(FARTHEST)));
}
