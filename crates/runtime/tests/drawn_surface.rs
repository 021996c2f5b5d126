//! Textured triangles of a host, their alpha, and the shadow on a ground.

use std::sync::Arc;

use gimage_runtime::draw::{Alpha, Camera, Facet, Ground, Paint, Software, Texture, View};
use gimage_runtime::{Options, Scene, Stepper};

const SIDE: u32 = 32;

/// Two facets: a square of 1 m around the origin whose texture coordinates run from 0 to 1, v down.
fn square() -> Vec<Facet> {
    let corner = [[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [-0.5, 0.5, 0.0]];
    let uv = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    let facet = |t: [usize; 3]| {
        let (normals, colors) = ([[0.0, 0.0, 1.0]; 3], [[1.0; 4]; 3]);
        Facet { corners: t.map(|c| corner[c]), normals, uv: t.map(|c| uv[c]), colors, paint: 0 }
    };
    vec![facet([0, 1, 2]), facet([0, 2, 3])]
}

fn picture(paint: Paint, facets: Vec<Facet>, ground: Option<Ground>, eye: [f32; 3]) -> Vec<[u8; 4]> {
    let stepper = Stepper::on_cpu(Scene::new("surface"), Options::default()).unwrap();
    let mut painter = Software::new(SIDE, SIDE, 1).unwrap();
    painter.ground = ground;
    painter.set_paints(vec![paint]);
    painter.set_surface(facets);
    let view = View { background: [1.0; 3], ..View::new(&Camera { eye, target: [0.0; 3], fov: 0.6 }, 1.0) };
    painter.picture(&stepper, &view, 1.0).unwrap()
}

/// Red and green above, blue and a transparent white below.
fn four() -> Option<Arc<Texture>> {
    let pixels = vec![[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 0]];
    Some(Arc::new(Texture::new(2, 2, pixels).unwrap()))
}

fn at(picture: &[[u8; 4]], x: usize, y: usize) -> [u8; 4] {
    picture[y * SIDE as usize + x]
}

#[test]
fn a_texture_is_sampled_per_pixel() {
    let paint = Paint { color: [1.0; 4], texture: four(), alpha: Alpha::Opaque };
    let drawn = picture(paint, square(), None, [0.0, 0.0, 2.0]);
    let (red, green, blue) = (at(&drawn, 9, 9), at(&drawn, 22, 9), at(&drawn, 9, 22));
    assert!(red[0] > 150 && red[1] < 60 && red[2] < 60, "{red:?}");
    assert!(green[1] > 150 && green[0] < 60 && green[2] < 60, "{green:?}");
    assert!(blue[2] > 150 && blue[0] < 60 && blue[1] < 60, "{blue:?}");
    // Between two texels both show.
    let between = at(&drawn, 16, 9);
    assert!(between[0] > 90 && between[1] > 90, "{between:?}");
}

#[test]
fn a_mask_leaves_a_hole_and_a_blend_lets_part_of_the_ground_through() {
    let paint = |alpha| Paint { color: [1.0; 4], texture: four(), alpha };
    let eye = [0.0, 0.0, 2.0];
    let masked = picture(paint(Alpha::Mask(0.5)), square(), None, eye);
    assert_eq!(at(&masked, 23, 23), [255; 4], "the hole");
    assert!(at(&masked, 9, 22)[0] < 60);
    let half = Paint { color: [0.0, 0.0, 0.0, 0.5], texture: None, alpha: Alpha::Blend };
    let blended = picture(half, square(), None, eye);
    let inner = (12..20).flat_map(|y| (12..20).map(move |x| (x, y)));
    let mean = inner.map(|(x, y)| f64::from(at(&blended, x, y)[0])).sum::<f64>() / 64.0;
    assert!((150.0..220.0).contains(&mean), "{mean}");
}

#[test]
fn a_ground_is_darker_below_an_object() {
    let ground = Some(Ground { height: -0.5, middle: [0.0; 2], radius: 3.0 });
    // Level, 0.2 m above the ground.
    let lying = |f: Facet| Facet { corners: f.corners.map(|[x, y, _]| [0.2 * x, -0.3, -0.2 * y]), ..f };
    let object: Vec<Facet> = square().into_iter().map(lying).collect();
    let eye = [0.0, 1.5, 2.5];
    let with = picture(Paint::plain([0.5; 3]), object, ground, eye);
    let without = picture(Paint::plain([0.5; 3]), Vec::new(), ground, eye);
    let darker = with.iter().zip(&without).filter(|(a, b)| a[0].saturating_add(12) < b[0]).count();
    assert!(darker > 15, "{darker} pixels are darker");
    // The first row is far away, where the ground is background.
    assert_eq!(with[..SIDE as usize], without[..SIDE as usize]);
    assert!(without.iter().any(|p| p[0] < 255), "the ground shows");
}
