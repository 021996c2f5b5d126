//! Sample garments.
