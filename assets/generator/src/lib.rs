//! The sample garments in `assets/`.
//!
//! Each garment is a set of flat sewing panels, triangulated, sewn, and draped over a simple figure. The result does
//! not depend on the platform: see [`math`].

pub mod body;
pub mod delaunay;
pub mod drape;
pub mod glb;
pub mod layers;
pub mod math;
pub mod panel;
pub mod sew;
pub mod surface;

mod belt_loop;
mod cape;
mod dress;
pub mod figure;
mod skirt;
mod sleeve;
mod trousers;
mod tshirt;

pub use cape::cape;
pub use dress::dress;
pub use figure::{figure, figure_in_cape};
pub use skirt::skirt;
pub use sleeve::sleeve;
pub use trousers::trousers;
pub use tshirt::tshirt;

/// Makes the bytes of a garment.
type Maker = fn() -> Vec<u8>;

/// Every garment that is a file of its own: the name of the file, and the bytes. The [`figure`] has its own maker.
pub fn all() -> Vec<(&'static str, Vec<u8>)> {
    let makers: [(&str, Maker); 6] = [
        ("tshirt.glb", tshirt),
        ("skirt.glb", skirt),
        ("trousers.glb", trousers),
        ("cape.glb", cape),
        ("dress.glb", dress),
        ("sleeve.glb", sleeve),
    ];
    // Draping takes seconds and the garments do not depend on each other.
    std::thread::scope(|scope| {
        let running = makers.map(|(name, make)| (name, scope.spawn(make)));
        let finish = |(name, thread): (_, std::thread::ScopedJoinHandle<Vec<u8>>)| (name, thread.join().expect(name));
        running.into_iter().map(finish).collect()
    })
}
