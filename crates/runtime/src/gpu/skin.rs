//! Joints that move on the GPU: one dispatch over the particles of a cloth, copied to the lists that steps read.

use bytemuck::cast_slice;
use wgpu::BufferUsages;

use super::upload::upload;
use super::{Gpu, begin};
use crate::cloth::{Cloth, Poses, Rows, Skin};
use crate::passes::Pass;
use crate::shaders::{Slot, list};
use crate::world::World;

/// Bytes of the upload for a number of joints, at most.
pub(super) fn bytes(joints: usize) -> usize {
    2 * joints * size_of::<[[f32; 4]; 4]>() + 16
}

/// The influences of all particles as shaders/skin.wgsl reads them, for points that are somewhere at rest.
fn influences(skin: &Skin, at_rest: impl Iterator<Item = [f32; 3]>) -> Vec<[u32; 4]> {
    let mut rows = Vec::with_capacity(skin.rest.len() * (1 + 2 * skin.sets));
    for (k, rest) in at_rest.enumerate() {
        let [x, y, z] = rest.map(f32::to_bits);
        rows.push([x, y, z, 0]);
        let own = &skin.influences[k * skin.sets..(k + 1) * skin.sets];
        rows.extend(own.iter().flat_map(|i| [i.joints, i.weights.map(f32::to_bits)]));
    }
    rows
}

impl Gpu {
    /// Records that the joints of a cloth move from where the frame begins, if that is given, to where it ends.
    pub(super) fn skin(
        &mut self,
        world: &World,
        encoder: &mut wgpu::CommandEncoder,
        cloth: usize,
        (from, to): (Option<&[Rows]>, &[Rows]),
        rate: f32,
    ) {
        let of = &world.scene.cloths[cloth];
        let Some(skin) = of.skin() else { return };
        self.make_skin(world, cloth, skin);
        let mut numbers = Poses::new(of.skinning, to).list();
        numbers.extend(from.map_or_else(|| numbers.clone(), |from| Poses::new(of.skinning, from).list()));
        numbers.push([rate, 0.0, 0.0, 0.0]);
        let numbers = self.list("joints", cast_slice(&numbers));
        let what = Pass::Skin { sets: skin.sets as u32, skinning: of.skinning };
        let mut pass = begin(encoder, "joints");
        self.once(world, &mut pass, cloth, what, &[(Slot::Action, &numbers)], list(of.len()));
        if of.backstops.is_some() {
            self.make_backs(world, cloth, skin);
            let own = [Slot::BackInfluences, Slot::BackSkinned].map(|slot| self.cloths[cloth].others[&slot].clone());
            let more = [(Slot::Action, &numbers), (Slot::Influences, &own[0]), (Slot::Skinned, &own[1])];
            self.once(world, &mut pass, cloth, what, &more, list(of.len()));
        }
        drop(pass);
        self.copy_skin(world, encoder, cloth, of);
    }

    /// Its buffers, once. Instances of a cloth share the influences.
    fn make_skin(&mut self, world: &World, cloth: usize, skin: &Skin) {
        if self.cloths[cloth].others.contains_key(&Slot::Skinned) {
            return;
        }
        let same = |(_, other): &(usize, &Cloth)| other.skin().is_some_and(|s| std::ptr::eq(s, skin));
        let others = world.scene.cloths.iter().enumerate().filter(same);
        let known = others.filter_map(|(c, _)| self.cloths.get(c)?.others.get(&Slot::Influences).cloned()).next();
        let none = BufferUsages::empty();
        let influences = known.unwrap_or_else(|| {
            upload(&self.device, "influences", &influences(skin, skin.rest.iter().copied()), none).into()
        });
        let (run, of) = (&world.runs[cloth], &world.scene.cloths[cloth]);
        let rows = [run.targets(of), run.drifts(of)].concat();
        let skinned = upload(&self.device, "skinned", &rows, BufferUsages::COPY_SRC).into();
        self.cloths[cloth].others.extend([(Slot::Influences, influences), (Slot::Skinned, skinned)]);
    }

    /// The same for the spheres of its backstops, which move as its particles.
    fn make_backs(&mut self, world: &World, cloth: usize, skin: &Skin) {
        if self.cloths[cloth].others.contains_key(&Slot::BackSkinned) {
            return;
        }
        let (run, of) = (&world.runs[cloth], &world.scene.cloths[cloth]);
        let centers = of.spheres().into_iter().map(|[x, y, z, _]| [x, y, z]);
        let influences = upload(&self.device, "back influences", &influences(skin, centers), BufferUsages::empty());
        let rows = [run.spheres(of), vec![[0.0; 4]; of.len()]].concat();
        let skinned = upload(&self.device, "back skinned", &rows, BufferUsages::COPY_SRC);
        let lists = [(Slot::BackInfluences, influences.into()), (Slot::BackSkinned, skinned.into())];
        self.cloths[cloth].others.extend(lists);
    }

    /// Records copies of the targets, of the spheres and of their speeds to the lists of the cloth, its own and those of its arena.
    fn copy_skin(&self, world: &World, encoder: &mut wgpu::CommandEncoder, cloth: usize, of: &Cloth) {
        let bytes = 16 * of.len() as u64;
        let lists =
            [(Slot::Skinned, [Slot::Targets, Slot::Drifts]), (Slot::BackSkinned, [Slot::Backs, Slot::BackDrifts])];
        for (made, slots) in lists {
            let Some(skinned) = self.cloths[cloth].others.get(&made) else { continue };
            for (n, slot) in slots.into_iter().enumerate() {
                for span in self.vectors(world, cloth, slot) {
                    let from = skinned.offset + n as u64 * bytes;
                    encoder.copy_buffer_to_buffer(&skinned.buffer, from, &span.buffer, span.offset, bytes);
                }
            }
        }
    }
}
