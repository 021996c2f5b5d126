//! Pieces and accessories.
