//! Which cloth of a stepper a call is about.

use std::sync::atomic::{AtomicU64, Ordering};

/// A cloth of a stepper, for as long as the cloth is there.
///
/// [`crate::Stepper::add_cloth`] returns it, and [`crate::Stepper::handle`] returns that of any cloth. Every call on a stepper that
/// takes a cloth takes its handle or its index ([`ClothRef`]). A handle stays valid while other cloths come and go. The
/// handle of a removed cloth, or of a cloth of another stepper, is [`crate::Error::NoCloth`] and never names another cloth:
/// no two cloths of a process have the same handle. Cloths of a stepper have handles in ascending order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ClothHandle(u64);

impl ClothHandle {
    /// A handle that no cloth has had before.
    pub(crate) fn fresh() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        ClothHandle(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// The cloth that a call is about: pass an index or a handle.
///
/// An index is a place in the list of cloths of [`crate::Stepper::scene`]. It is the shorter name where the cloths of a scene stay: it is
/// known before the stepper is made, and files have it. When a cloth is removed, the indices of the cloths after it fall by
/// one, so a host that removes cloths keeps handles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ClothRef {
    /// Its place in the list of cloths now.
    Index(usize),
    /// Its handle.
    Handle(ClothHandle),
}

impl From<usize> for ClothRef {
    fn from(index: usize) -> Self {
        ClothRef::Index(index)
    }
}

impl From<ClothHandle> for ClothRef {
    fn from(handle: ClothHandle) -> Self {
        ClothRef::Handle(handle)
    }
}

/// Keeps an index with its cloth when the cloth at `gone` leaves the list; false if it is that cloth.
pub(crate) fn follow(index: &mut usize, gone: usize) -> bool {
    let stays = *index != gone;
    *index -= usize::from(*index > gone);
    stays
}
