//! States as bytes, for files and networks: little-endian, the same on all machines.

use gimage_bundle::MAX_ANCHORS;

use super::snapshot::CONTROL_NUMBERS;
use super::{ClothState, ControlState, Head, Layout, Snapshot};
use crate::error::{Error, Result};
use crate::scene::Pose;

/// The first bytes of a state and of a snapshot; the last one is the version.
const STATE: [u8; 8] = *b"gimSta\0\x01";
const SNAPSHOT: [u8; 8] = *b"gimSna\0\x02";
/// Most steps in a frame, as in [`crate::Options`].
const MAX_SUBSTEPS: u32 = 4096;

impl ClothState {
    /// The state as bytes: the arrays as they are, after about 100 bytes. [`ClothState::from_bytes`] of this version reads
    /// them.
    pub fn to_bytes(&self) -> Vec<u8> {
        let Head { grids, step, asleep, calm, home, layout } = &self.head;
        let mut out = Vec::with_capacity(128 + 4 * self.words.len());
        out.extend(STATE);
        out.extend((grids.len() as u32).to_le_bytes());
        out.extend(grids.as_flattened().iter().flat_map(|n| n.to_le_bytes()));
        out.extend([*step, *calm].iter().flat_map(|x| x.to_le_bytes()));
        out.extend(home.position.iter().chain(&home.rotation).flat_map(|x| x.to_le_bytes()));
        let flags = [*asleep, layout.good, layout.lost, layout.cut, layout.rest];
        out.extend(flags.map(u8::from));
        out.extend((layout.slots as u32).to_le_bytes());
        out.extend(self.words.iter().flat_map(|w| w.to_le_bytes()));
        out
    }

    /// Reads what [`ClothState::to_bytes`] has written. Errors on other bytes, and on bytes that are missing or left over; it
    /// never panics, and allocates no more than the bytes hold. Whether the state fits a cloth, [`crate::Stepper::set_state`]
    /// checks.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let mut reader = Reader { what: "state", rest: bytes };
        let state = reader.state()?;
        reader.end()?;
        Ok(state)
    }
}

impl Snapshot {
    /// The snapshot as bytes: about 400 bytes, then the bytes of each state.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = SNAPSHOT.to_vec();
        out.extend(self.control.numbers().iter().flat_map(|x| x.to_le_bytes()));
        let counts = [self.control.substeps, self.control.polish, self.cloths.len() as u32];
        out.extend(counts.iter().flat_map(|n| n.to_le_bytes()));
        self.cloths.iter().for_each(|state| out.extend(state.to_bytes()));
        out
    }

    /// Reads what [`Snapshot::to_bytes`] has written, as [`ClothState::from_bytes`] reads a state.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let mut reader = Reader { what: "snapshot", rest: bytes };
        reader.magic(SNAPSHOT)?;
        let mut numbers = [0.0; CONTROL_NUMBERS];
        for x in &mut numbers {
            *x = reader.f64()?;
        }
        let (substeps, polish, count) = (reader.u32()?, reader.u32()?, reader.u32()?);
        let control = ControlState::from_numbers(numbers, substeps, polish);
        let [time, step, left] = control.clock;
        let timed = time >= 0.0 && step > 0.0 && left >= 0.0 && numbers[..3].iter().all(|x| x.is_finite());
        let [lasting, _, stirred] = control.follow;
        // NaN where the host gave a number.
        let is_count = |x: f64| (0.0..=f64::from(MAX_SUBSTEPS)).contains(&x);
        let followed = is_count(stirred) && (lasting.is_nan() || is_count(lasting));
        let counted = followed && (1..=MAX_SUBSTEPS).contains(&substeps) && polish <= MAX_SUBSTEPS;
        if !timed || !counted || !control.due.is_finite() {
            return Err(reader.bad("a number of the clock is out of range"));
        }
        // Each state takes bytes, so the count ends with them.
        let mut cloths = Vec::new();
        for _ in 0..count {
            cloths.push(reader.state()?);
        }
        reader.end()?;
        Ok(Snapshot { control, cloths })
    }
}

/// Reads numbers from the front of a list of bytes.
struct Reader<'a> {
    what: &'static str,
    rest: &'a [u8],
}

impl Reader<'_> {
    fn bad(&self, problem: &'static str) -> Error {
        Error::StateBytes { what: self.what, problem }
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N]> {
        let (first, rest) = self.rest.split_first_chunk().ok_or_else(|| self.bad("they end too early"))?;
        self.rest = rest;
        Ok(*first)
    }

    fn u32(&mut self) -> Result<u32> {
        self.take().map(u32::from_le_bytes)
    }

    fn f32(&mut self) -> Result<f32> {
        self.take().map(f32::from_le_bytes)
    }

    fn f64(&mut self) -> Result<f64> {
        self.take().map(f64::from_le_bytes)
    }

    fn flag(&mut self) -> Result<bool> {
        match self.take()? {
            [0] => Ok(false),
            [1] => Ok(true),
            _ => Err(self.bad("a flag is neither 0 nor 1")),
        }
    }

    fn magic(&mut self, expected: [u8; 8]) -> Result<()> {
        if self.take()? == expected { Ok(()) } else { Err(self.bad("they begin otherwise")) }
    }

    fn end(&self) -> Result<()> {
        if self.rest.is_empty() { Ok(()) } else { Err(self.bad("bytes are left over")) }
    }

    fn state(&mut self) -> Result<ClothState> {
        self.magic(STATE)?;
        let mut grids = Vec::new();
        for _ in 0..self.u32()? {
            grids.push([self.u32()?, self.u32()?]);
        }
        let (step, calm) = (self.f64()?, self.f64()?);
        let position = [self.f32()?, self.f32()?, self.f32()?];
        let rotation = [self.f32()?, self.f32()?, self.f32()?, self.f32()?];
        let [asleep, good, lost, cut, rest] = [(); 5].map(|()| self.flag());
        let (asleep, good, lost, cut, rest) = (asleep?, good?, lost?, cut?, rest?);
        let slots = self.u32()? as usize;
        let numbers = [position.as_slice(), &rotation].concat();
        let timed = step > 0.0 && step.is_finite() && calm >= 0.0 && calm.is_finite();
        if !timed || numbers.iter().any(|x| !x.is_finite()) {
            return Err(self.bad("a number is out of range"));
        }
        if (rest && !cut) || (slots > 0 && !rest) || slots > MAX_ANCHORS {
            return Err(self.bad("its parts do not go together"));
        }
        let particles = grids.iter().try_fold(0u64, |sum, [w, h]| sum.checked_add(u64::from(*w) * u64::from(*h)));
        // No part has more bytes per particle than all of them, so that this cannot overflow.
        let particles = particles.filter(|n| *n <= self.rest.len() as u64);
        let particles = particles.ok_or_else(|| self.bad("they end too early"))? as usize;
        let layout = Layout { particles, good, lost, cut, rest, slots };
        let lists = self.rest.split_at_checked(4 * layout.words());
        let (lists, rest) = lists.ok_or_else(|| self.bad("they end too early"))?;
        self.rest = rest;
        let words = lists.as_chunks().0.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect();
        let home = Pose { position, rotation };
        Ok(ClothState::new(Head { grids, step, asleep, calm, home, layout }, words))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state() -> ClothState {
        let layout = Layout { particles: 6, good: true, lost: true, cut: true, rest: true, slots: 2 };
        let home = Pose { position: [1.0, 2.0, 3.0], rotation: [0.5; 4] };
        let head = Head { grids: vec![[3, 2]], step: 0.002, asleep: true, calm: 0.5, home, layout };
        ClothState::new(head, (0..layout.words() as u32).collect())
    }

    #[test]
    fn bytes_are_read_as_they_were_written() {
        let state = state();
        assert_eq!(ClothState::from_bytes(&state.to_bytes()).unwrap(), state);
        let control = ControlState { clock: [1.0, 0.002, 0.001], substeps: 4, polish: 2, ..ControlState::default() };
        let chooser = std::array::from_fn(|n| if n == 0 { f64::NAN } else { n as f64 });
        let control = ControlState { chooser, ..control };
        let snapshot = Snapshot { control, cloths: vec![state.clone(), state] };
        assert_eq!(Snapshot::from_bytes(&snapshot.to_bytes()).unwrap(), snapshot);
        assert_eq!(snapshot.time(), 1.0);
    }

    #[test]
    fn every_truncation_and_spoilt_byte_is_an_error_or_another_state() {
        let control = ControlState { clock: [1.0, 0.002, 0.001], substeps: 4, ..ControlState::default() };
        let whole = Snapshot { control, cloths: vec![state()] };
        let bytes = whole.to_bytes();
        for end in 0..bytes.len() {
            assert!(Snapshot::from_bytes(&bytes[..end]).is_err(), "{end}");
        }
        let mut refused = 0;
        for at in 0..bytes.len() {
            for bit in 0..8 {
                let mut spoilt = bytes.clone();
                spoilt[at] ^= 1 << bit;
                match Snapshot::from_bytes(&spoilt) {
                    Ok(other) => assert_ne!(other, whole, "{at}"),
                    Err(Error::StateBytes { .. }) => refused += 1,
                    Err(other) => panic!("{other}"),
                }
            }
        }
        assert!(refused > 100, "{refused}");
        let longer = [&bytes[..], &[0]].concat();
        assert!(Snapshot::from_bytes(&longer).unwrap_err().to_string().contains("left over"));
    }
}
