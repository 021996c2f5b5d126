//! Images that cloths share: cloths of one bundle have one copy of everything that does not depend on where they are.

use std::sync::{Arc, OnceLock};

use crate::choose::Hold;
use crate::cloth::{Cloth, Tethers};
use crate::coarser::{Coarser, Table};
use crate::error::Result;

/// Data that instances of a cloth share once it is prepared for the solver.
pub struct Images {
    /// The cloth as the host gave it.
    given: Cloth,
    /// The same, prepared.
    made: Cloth,
    hold: Hold,
    tethers: Arc<Tethers>,
    /// The coarser image, and what its instances share, once they are asked for.
    coarser: OnceLock<Coarser>,
    below: OnceLock<Arc<Images>>,
    /// How motion is carried between the two on the device, once that is asked for.
    table: OnceLock<Arc<Table>>,
}

impl Images {
    /// Those of a cloth that the host gave as `given`: known ones if they are the same, or its own.
    pub fn of<'a>(
        cloth: &mut Cloth,
        given: Cloth,
        hold: Hold,
        mut known: impl Iterator<Item = &'a Arc<Images>>,
    ) -> Arc<Self> {
        let same = |images: &&Arc<Images>| images.hold == hold && given.has_images_of(&images.given);
        if let Some(images) = known.find(same) {
            cloth.share(&images.made);
            return images.clone();
        }
        let tethers = Arc::new(super::cloth_run::hang(cloth, hold));
        let (coarser, below, table) = Default::default();
        Arc::new(Images { given, made: cloth.clone(), hold, tethers, coarser, below, table })
    }

    /// The coarser image, made once. Errors as [`Cloth::coarser`].
    pub fn coarser(&self) -> Result<Coarser> {
        if let Some(coarser) = self.coarser.get() {
            return Ok(coarser.clone());
        }
        let coarser = self.given.coarser()?;
        Ok(self.coarser.get_or_init(|| coarser).clone())
    }

    /// Images that instances of the coarser image share.
    pub fn below(&self) -> Option<&Arc<Images>> {
        self.below.get()
    }

    /// Keeps it for those that come later.
    pub fn keep_below(&self, images: Option<&Arc<Images>>) {
        images.into_iter().for_each(|images| _ = self.below.get_or_init(|| images.clone()));
    }

    /// How motion is carried to the coarser image, made once; the same for all instances.
    pub fn table(&self, make: impl FnOnce() -> Table) -> Arc<Table> {
        self.table.get_or_init(|| Arc::new(make())).clone()
    }

    /// Tethers of the instances.
    pub fn tethers(&self) -> &Arc<Tethers> {
        &self.tethers
    }
}
