//! Numbers of the CPU backend: f32 and f64 under one name, vector instructions, and aligned lists.

pub(crate) mod aligned;
pub(crate) mod lanes;
pub(crate) mod noise;
pub(crate) mod real;
pub(crate) mod turn;
