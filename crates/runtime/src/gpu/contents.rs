//! Data of cloths that shaders only read, for one cloth or several that lie one after the other.

use std::collections::HashMap;

use bytemuck::{Pod, Zeroable, cast_slice};
use wgpu::{Buffer, BufferUsages};

use super::levels::Coarse;
use super::upload::upload;
use super::worn;
use crate::cloth::{Cloth, Grid, Rest};
use crate::cpu::fabric::stretch::UNBOUNDED;
use crate::fused::room_of;
use crate::layout::{GridRow, JobRow};
use crate::levels;
use crate::passes::{Soft, has_levels, soft_of};
use crate::shaders::{HEAD, LISTED, Slot};
use crate::world::World;

/// Lists as shaders lay them out, but for [`Grids`], and where each cloth lies in them.
#[derive(Default)]
pub(super) struct Contents {
    lists: HashMap<Slot, Vec<u8>>,
    /// Where each cloth lies in the buffers, without numbers of a step.
    pub jobs: Vec<JobRow>,
    /// Coarser grids of cloths that have any.
    coarse: Coarse,
}

impl Contents {
    /// Those of an index list of cloths; instances of a cloth share the images of the first.
    pub fn new(world: &World, cloths: &[usize]) -> Self {
        let (mut all, mut end) = (Contents::default(), 0);
        for (row, (&index, first)) in cloths.iter().zip(firsts(world, cloths)).enumerate() {
            let same = |(_, other): &(usize, &usize)| world.runs[**other].is_instance_of(&world.runs[index]);
            let known = cloths[..row].iter().enumerate().find(same).map(|(other, _)| other);
            let image = known.map_or(end, |other| all.jobs[other].image);
            all.add(world, index, (row as u32, first), (image, known));
            end += if known.is_none() { room_of(world.scene.cloths[index].len()) as u32 } else { 0 };
        }
        all.close()
    }

    /// Those of cloths whose rows of faults and first particles are given beside their indices. Each has images of its own, which cuts
    /// may change.
    pub fn placed(world: &World, places: impl Iterator<Item = (usize, u32, u32)>) -> Self {
        let mut all = Contents::default();
        places.for_each(|(index, row, first)| all.add(world, index, (row, first), (first, None)));
        all.close()
    }

    /// Adds what lies behind the last cloth.
    fn close(mut self) -> Self {
        if let Some(last) = self.jobs.last() {
            let end = self.lists.get(&Slot::Members).map_or(0, |m| m.len() as u32 / 4);
            if last.ring + last.rings > 0 {
                self.add_rows(Slot::Starts, &[end]);
            }
        }
        self.lists.extend(self.coarse.listed());
        self
    }

    /// `like`: the number of a cloth before that it is an instance of.
    fn add(&mut self, world: &World, index: usize, (row, first): (u32, u32), (image, like): (u32, Option<usize>)) {
        let (cloth, held) = (&world.scene.cloths[index], &world.runs[index].tethers);
        let count = |list: &Self, slot, size: usize| list.lists.get(&slot).map_or(0, |l| l.len() / size) as u32;
        let has_levels = has_levels(cloth, &world.control.options);
        if has_levels {
            self.coarse.add(cloth, like);
        }
        self.jobs.push(JobRow {
            first,
            count: cloth.len() as u32,
            grid: self.jobs.last().map_or(0, |last| last.grid + last.grids),
            grids: cloth.grids().len() as u32,
            ring: count(self, Slot::Starts, 4),
            rings: cloth.ring_count() as u32,
            row,
            image,
            levels: if has_levels { levels::most(cloth) } else { 0 },
            ..Zeroable::zeroed()
        });
        for slot in Slot::ALL {
            if let Some(each) = slot.row(cloth, held.per_particle) {
                let (begin, bytes) = match slot {
                    // Teleports and joints may have moved them.
                    Slot::Targets => (first, cast_slice(&world.runs[index].targets(cloth)).to_vec()),
                    Slot::Drifts => (first, cast_slice(&world.runs[index].drifts(cloth)).to_vec()),
                    Slot::Backs => (first, cast_slice(&world.runs[index].spheres(cloth)).to_vec()),
                    Slot::BackDrifts => (first, vec![0; 16 * cloth.len()]),
                    Slot::SurfacePlanes => (first, cast_slice(&worn::none(cloth)).to_vec()),
                    other if like.is_none() => (image, other.texels(cloth, held)),
                    _ => continue,
                };
                // Gaps between cloths are not read.
                let list = self.lists.entry(*slot).or_default();
                list.resize(begin as usize * each, 0);
                list.extend(bytes);
            }
        }
        if let Some(membrane) = cloth.membrane() {
            let [weft, warp, shear] = membrane.soft;
            // By rows, some of which may belong to cloths that have left.
            self.lists.entry(Slot::Yielding).or_default().resize(16 * row as usize, 0);
            self.add_rows(Slot::Yielding, &[[weft, warp, shear, 0.0]]);
        }
        if cloth.ring_count() > 0 {
            let (starts, members) = cloth.rings();
            let so_far = count(self, Slot::Members, 4);
            let starts: Vec<u32> = starts[..starts.len() - 1].iter().map(|s| s + so_far).collect();
            self.add_rows(Slot::Starts, &starts);
            self.add_rows(Slot::Members, &members.iter().map(|m| m + first).collect::<Vec<u32>>());
        }
    }

    fn add_rows<T: Pod>(&mut self, slot: Slot, rows: &[T]) {
        self.lists.entry(slot).or_default().extend_from_slice(cast_slice(rows));
    }

    /// The nodes of coarser grids, which frames write; none without any.
    pub fn nodes(&self, device: &wgpu::Device) -> Option<Buffer> {
        self.coarse.nodes(device)
    }

    /// Their buffers.
    pub fn upload(&self, device: &wgpu::Device) -> HashMap<Slot, Buffer> {
        // Lists that a cut changes are copied.
        let buffer =
            |(slot, bytes): (&Slot, &Vec<u8>)| (*slot, upload(device, slot.name(), bytes, BufferUsages::COPY_SRC));
        self.lists.iter().filter(|(_, bytes)| !bytes.is_empty()).map(buffer).collect()
    }

    /// All of them one after the other as [`Slot::Lists`] has them, for buffers with room for a number of particles, with room for grids
    /// and jobs; and where each begins \[bytes\].
    pub fn joined(&self, room: usize) -> (Vec<u8>, HashMap<Slot, u64>) {
        let (mut bytes, mut places) = (vec![0; 4 * HEAD], HashMap::new());
        let mut head = [0u32; HEAD];
        let grids = self.jobs.iter().map(|job| job.grids as usize).sum::<usize>();
        for ((slot, _), begins) in LISTED.iter().zip(&mut head) {
            *begins = (bytes.len() / 16) as u32;
            places.insert(*slot, bytes.len() as u64);
            match slot {
                Slot::Jobs => bytes.resize(bytes.len() + self.jobs.len() * size_of::<JobRow>(), 0),
                Slot::Grids => bytes.resize(bytes.len() + grids * size_of::<GridRow>(), 0),
                _ => bytes.extend(self.lists.get(slot).into_iter().flatten()),
            }
            bytes.resize(bytes.len().next_multiple_of(16), 0);
        }
        head[HEAD - 1] = room as u32;
        bytes[..4 * HEAD].copy_from_slice(cast_slice(&head));
        (bytes, places)
    }
}

/// Where the particles of cloths begin that lie one after the other.
pub(super) fn firsts(world: &World, cloths: &[usize]) -> Vec<u32> {
    let rooms = cloths.iter().map(|c| room_of(world.scene.cloths[*c].len()) as u32);
    let next = |end: &mut u32, room| Some(std::mem::replace(end, *end + room));
    rooms.scan(0, next).collect()
}

/// Grids of cloths as they were uploaded last.
pub(super) struct Grids {
    /// [`GridRow::soft`] of each cloth.
    softs: Vec<f32>,
}

impl Grids {
    /// New grids, where steps have other bounds of diagonals than those that were uploaded last, or cloths have left. Recorded
    /// frames that use the last ones may not have been submitted yet. `places` has index, first particle and first grid of each
    /// cloth.
    pub fn follow(
        last: &mut Option<Grids>,
        world: &World,
        places: impl Iterator<Item = (usize, u32, u32)> + Clone,
    ) -> Option<Vec<GridRow>> {
        let dt = world.control.clock.dt;
        let softs = || places.clone().map(|(c, ..)| soft_row(&world.scene.cloths[c], dt));
        if last.as_ref().is_some_and(|l| softs().eq(l.softs.iter().copied())) {
            return None;
        }
        let softs: Vec<_> = softs().collect();
        let mut rows: Vec<GridRow> = Vec::new();
        for ((cloth, first, grid), soft) in places.zip(&softs) {
            // No cloth reads the rows of one that has left.
            rows.resize(grid as usize, GridRow::zeroed());
            rows.extend(grid_rows(&world.scene.cloths[cloth], first, *soft));
        }
        *last = Some(Grids { softs });
        Some(rows)
    }
}

/// [`GridRow::soft`] of a cloth in steps of `dt` \[s\].
fn soft_row(cloth: &Cloth, dt: f64) -> f32 {
    if cloth.membrane().is_some() || soft_of(cloth) != Soft::None {
        return cloth.softness();
    }
    // One shader for all hard springs, so that cloths of all sizes share a dispatch.
    let bound = cloth.bound(dt);
    if bound > 0.0 { bound } else { UNBOUNDED as f32 }
}

/// The grids of a cloth whose particles begin at `first`, `soft` being that of [`soft_row`].
fn grid_rows(cloth: &Cloth, first: u32, soft: f32) -> Vec<GridRow> {
    let constant = |g: usize| if let Rest::Constant(r) = cloth.rest() { r[g] } else { [0.0; 4] };
    let row = |(g, grid): (usize, &Grid)| GridRow {
        first: first + grid.first,
        width: grid.width,
        height: grid.height,
        soft,
        rest: constant(g),
    };
    cloth.grids().iter().enumerate().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fused::HEADS;
    use crate::options::Options;
    use crate::shaders::listed;

    #[test]
    fn joined_lists_take_no_more_than_is_counted() {
        let mut scene = crate::scene::builtin("s1", 9).unwrap();
        scene.cloths.extend(crate::scene::builtin("s1k", 12).unwrap().cloths);
        let mut limited = crate::Flat::square("limited", 7).cloth().unwrap();
        limited.limits = Some(vec![0.1; limited.len()].into());
        let mut made = crate::Flat::square("made", 10).cloth().unwrap();
        made.set_material(&crate::Material::default()).unwrap();
        scene.cloths.extend([limited, made]);
        let world = World::new(scene, Options::default()).unwrap();
        for cloths in [&[0, 0, 0][..], &[1, 1], &[2, 2], &[3, 3, 3]] {
            let counted = |c: &usize| {
                let cloth = &world.scene.cloths[*c];
                listed(cloth, world.runs[*c].tethers.per_particle, room_of(cloth.len())) as u64
            };
            let (bytes, places) = Contents::new(&world, cloths).joined(0);
            assert!(bytes.len() as u64 <= HEADS + cloths.iter().map(counted).sum::<u64>(), "{cloths:?}");
            let head: &[u32] = cast_slice(&bytes[..4 * HEAD]);
            for (n, (slot, _)) in LISTED.iter().enumerate() {
                assert_eq!(16 * u64::from(head[n]), places[slot], "{slot:?}");
            }
        }
    }
}
