//! A map -> the texels of an image: sampled on the surface, fitted to it, and sealed.

pub(crate) mod fit;
pub(crate) mod resample;
pub(crate) mod seal;
