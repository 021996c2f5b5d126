// The next duplicate of every particle; itself off the seams.
@group(0) @binding(41) var<storage, read> mates: array<u32>;

fn mate(k: u32) -> u32 {
  return mates[k];
}
