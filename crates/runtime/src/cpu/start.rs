//! Where the particles of a cloth are at its start.

use super::body::view;
use super::rows::Threads;
use super::{normals, seam_normals};
use crate::choose::Settings;
use crate::cloth::Cloth;
use crate::number::real::Real;
use crate::options::Solver;

/// Positions, positions one step before and normals; the fourth component of a position is the inverse mass.
pub struct Start<T> {
    pub now: Vec<[T; 4]>,
    pub before: Vec<[T; 4]>,
    pub normals: Vec<[T; 4]>,
}

impl<T: Real> Start<T> {
    /// Those of a cloth that moves with its velocity, as if its last step had taken `dt` \[s\]; normals only where they are asked
    /// for, else 0.
    pub fn new(cloth: &Cloth, options: &Settings, dt: f64) -> Self {
        let shares = inverse_masses(cloth, options.solver);
        let place = |k: usize, ago: f64| {
            let (p, w) = (cloth.positions()[k].map(f64::from), f64::from(shares[k]));
            let ago = if w > 0.0 { ago } else { 0.0 };
            let at = [0, 1, 2].map(|c| T::of(p[c] - f64::from(cloth.velocity[c]) * ago));
            [at[0], at[1], at[2], T::of(w)]
        };
        let now: Vec<_> = (0..cloth.len()).map(|k| place(k, 0.0)).collect();
        let before = (0..cloth.len()).map(|k| place(k, dt)).collect();
        let mut all = vec![[T::of(0.0); 4]; cloth.len()];
        if options.normals {
            // Cloth that is drawn before the first frame has a front and a back too.
            let threads = Threads::one();
            for g in cloth.grids() {
                normals::run(&threads, view(&now, &[], g), &mut all[g.range()]);
            }
            let (starts, members) = cloth.rings();
            seam_normals::run(&mut all, starts, members);
        }
        Start { now, before, normals: all }
    }
}

/// The fourth component of every position. Under XPBD a duplicate stands for its share of the point's mass: else forces
/// on it would count half when the mean is taken.
pub(crate) fn inverse_masses(cloth: &Cloth, solver: Solver) -> Vec<f32> {
    let mut all: Vec<f32> = (0..cloth.len()).map(|k| cloth.inverse_mass(k)).collect();
    let (starts, members) = cloth.rings();
    for ring in starts.windows(2).filter(|_| solver == Solver::Xpbd) {
        let members = &members[ring[0] as usize..ring[1] as usize];
        members.iter().for_each(|k| all[*k as usize] *= members.len() as f32);
    }
    all
}
