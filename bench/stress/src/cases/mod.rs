//! The cases, by what is done to the cloth.

mod fault;
mod invariant;
mod material;
mod start;
mod time;
mod world;

use gimage_runtime::Result;

use crate::case::Case;

/// All of them; `steps` are made where a cloth rests for long.
pub fn all(steps: u32) -> Result<Vec<Case>> {
    let mut all = time::cases(steps)?;
    all.extend(material::cases()?);
    all.extend(start::cases()?);
    all.extend(world::cases()?);
    all.extend(invariant::cases()?);
    all.extend(fault::cases()?);
    Ok(all)
}
