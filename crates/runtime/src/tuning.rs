//! Sizes of workgroups and of tiles that suit a device.

/// Sizes of workgroups and of tiles that [`crate::Stepper::tune`] found to be the fastest on a device. A host keeps them with the name of the
/// device and its driver, and gives them to [`crate::Options::tuning`]. A size that is `None` follows from the limits of the device.
/// Sizes do not change results.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "scene-file", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "scene-file", serde(default))]
pub struct Tuning {
    /// Most threads of a workgroup that runs the whole frame of a cloth. 64 or more; fewer count as 64.
    pub whole_threads: Option<u32>,
    /// Most particles of a cloth that runs its whole frame in one workgroup where a scene starts with few cloths, up to
    /// four. A larger one runs by tiles, on which more of the device works.
    pub whole_particles: Option<u32>,
    /// Most threads of a workgroup that runs a tile. 64 or more; fewer count as 64.
    pub tile_threads: Option<u32>,
    /// Most particles of a tile, those around what it owns included. 256 or more; fewer count as 256, and more than the memory of
    /// a workgroup holds as what it holds.
    pub tile_particles: Option<u32>,
}

/// Fewest threads of a workgroup.
pub(crate) const MIN_THREADS: u32 = 64;
/// Fewest particles of a tile that is limited.
const MIN_PARTICLES: u32 = 256;

impl Tuning {
    /// None: all sizes follow from limits.
    pub(crate) const NONE: Tuning =
        Tuning { whole_threads: None, whole_particles: None, tile_threads: None, tile_particles: None };

    /// Most threads for a whole frame, where a device has a number of them.
    pub(crate) fn for_whole(&self, threads: u32) -> u32 {
        self.whole_threads.unwrap_or(threads).clamp(MIN_THREADS, threads.max(MIN_THREADS))
    }

    /// Most threads for a tile, of `threads` that a device has, by default `usual`.
    pub(crate) fn for_tile(&self, threads: u32, usual: u32) -> u32 {
        self.tile_threads.unwrap_or(usual).clamp(MIN_THREADS, threads.max(MIN_THREADS))
    }

    /// Most particles of a tile, if they are limited.
    pub(crate) fn particles(&self) -> Option<u32> {
        self.tile_particles.map(|n| n.max(MIN_PARTICLES))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_numbers_are_brought_within_those_of_a_device() {
        let of =
            |n: u32| Tuning { whole_threads: Some(n), tile_threads: Some(n), tile_particles: Some(n), ..Tuning::NONE };
        for (n, expected) in [(0, (64, 64, 256)), (128, (128, 128, 256)), (u32::MAX, (512, 512, u32::MAX))] {
            let tuning = of(n);
            let found = (tuning.for_whole(512), tuning.for_tile(512, 512), tuning.particles().unwrap_or(0));
            assert_eq!(found, expected, "{n}");
        }
        assert_eq!((Tuning::NONE.for_whole(64), Tuning::NONE.for_tile(1024, 512)), (64, 512));
        assert_eq!(Tuning::NONE, Tuning::default());
    }

    #[cfg(feature = "scene-file")]
    #[test]
    fn a_host_can_keep_it_as_json() {
        let tuning = Tuning { whole_threads: Some(256), ..Tuning::NONE };
        let text = serde_json::to_string(&tuning).unwrap();
        assert_eq!(serde_json::from_str::<Tuning>(&text).unwrap(), tuning);
        assert_eq!(serde_json::from_str::<Tuning>("{}").unwrap(), Tuning::NONE);
    }
}
