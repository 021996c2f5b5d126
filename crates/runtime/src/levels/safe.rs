//! Numbers of the rule by which no triangle of cloth crosses another one on the GPU, shared by shaders and their twins.

/// Rounds in a step; a further one does nothing where no particle has farther to go.
pub const ROUNDS: u32 = 4;
/// The longest way of a particle in a round, as a share of the distance of neighbours.
pub const MAX_WAY: f64 = 0.4;
/// Least gap of features, as a share of the distance of neighbours.
pub const FLOOR_SHARE: f64 = 0.01;
/// How much larger the ball of a particle is than its way, as a share of that distance: room to slide over edges.
pub const ASIDE: f64 = 0.02;
/// Rounding of a position, over its largest coordinate: some units in the last place of f32.
pub const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;

/// Least square of the area of a cell, over the product of those of its edges: slivers are not even.
pub const EVEN_AREA2: f64 = 1e-3;
/// By how much both columns of a derivative change, over the change of a point: an edge has two of these.
pub const EVEN_CHANGE: f64 = 2.0 * 1.4143;
/// Least distance of features without a common point in columns and rows.
pub const EVEN_APART: f64 = 0.7;
/// Room for rounding of derivatives.
pub const EVEN_ROOM: f64 = 1e-3;

/// Share of a gap that two features may use up in a round.
pub const GAP_SHARE: f64 = 0.8;
/// Room beside a plane, and the distance of features that touch, over the size of both.
pub const PLANE_ERROR: f64 = 4e-7;
pub const TOUCH: f64 = 2e-6;

/// Half-spaces of a particle; further ones become one with others. A multiple of 4.
pub const MAX_PLANES: usize = 12;
/// By how much less room two half-spaces may leave that become one, as a share of the distance of neighbours.
pub const MERGES: f64 = 1e-4;
/// Rounds of projection onto half-spaces, one after the other.
pub const PROJECTIONS: usize = 4;
/// Halvings of the way that rounding may take.
pub const HALVINGS: usize = 6;
/// Turns of the loop over all that a particle may meet; one that needs more stays where it is. Software adapters end all loops of a thread after
/// 65,535 turns.
pub const MAX_TURNS: usize = 16_384;
