// Nodes of one level at a seam move as those on its other side do, where tiles have limited its lengths. One workgroup a cloth.

// The level, from 1 for the finest.
override level: u32 = 1u;

fn tie_level(mine: vec2<u32>, tile: vec2<u32>, most: u32, local: u32) {
  tie(levels_at(mine.x), local, level);
}
