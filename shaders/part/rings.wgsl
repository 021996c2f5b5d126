// Seam rings: ring r is members[starts[r]] up to, not including, members[starts[r + 1]].
@group(0) @binding(5) var<storage, read> starts: array<u32>;
@group(0) @binding(6) var<storage, read> members: array<u32>;
