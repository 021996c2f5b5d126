//! Textured triangles of a host, their alpha, and the shadow on a ground; the GPU against the CPU.

#[cfg(feature = "gpu")]
use std::sync::Arc;

use crate::support;
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
    let paint = Paint { texture: four(), ..Paint::default() };
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
    let paint = |alpha| Paint { texture: four(), alpha, ..Paint::default() };
    let eye = [0.0, 0.0, 2.0];
    let masked = picture(paint(Alpha::Mask(0.5)), square(), None, eye);
    assert_eq!(at(&masked, 23, 23), [255; 4], "the hole");
    assert!(at(&masked, 9, 22)[0] < 60);
    let half = Paint { color: [0.0, 0.0, 0.0, 0.5], alpha: Alpha::Blend, ..Paint::default() };
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

#[cfg(feature = "gpu")]
mod devices {
    use gimage_runtime::draw::{Draw, Target, Wrap};
    use gimage_runtime::{Backend, read_back_picture, wgpu};

    use super::*;

    const SIDE: u32 = 96;
    const BACKGROUND: [f32; 3] = [0.1, 0.2, 0.3];

    fn view(eye: [f32; 3]) -> View {
        View { background: BACKGROUND, ..View::new(&Camera { eye, target: [0.0; 3], fov: 0.6 }, 1.0) }
    }

    fn here(paints: &[Paint], facets: &[Facet], eye: [f32; 3]) -> Vec<[u8; 4]> {
        let stepper = Stepper::on_cpu(Scene::new("surface"), Options::default()).unwrap();
        let mut painter = Software::new(SIDE, SIDE, 1).unwrap();
        painter.set_paints(paints.to_vec());
        painter.set_surface(facets.to_vec());
        painter.picture(&stepper, &view(eye), 1.0).unwrap()
    }

    fn there(
        (device, queue): &(wgpu::Device, wgpu::Queue),
        paints: &[Paint],
        facets: &[Facet],
        (eye, samples): ([f32; 3], u32),
    ) -> Vec<[u8; 4]> {
        let options = Options { backend: Backend::Gpu, ..Options::default() };
        let stepper = Stepper::new(Scene::new("surface"), options, Some((device, queue))).unwrap();
        let texture = |format, samples, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let (color, depth) = (wgpu::TextureFormat::Rgba8UnormSrgb, wgpu::TextureFormat::Depth32Float);
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let picture = texture(color, 1, attachment | wgpu::TextureUsages::COPY_SRC);
        let resolved = picture.create_view(&Default::default());
        let many = texture(color, samples, attachment).create_view(&Default::default());
        let depths = texture(depth, samples, attachment).create_view(&Default::default());
        let less = Some((depth, wgpu::CompareFunction::Less));
        let mut draw = Draw::new(device, queue, Target { color, depth: less, samples });
        draw.set_paints(paints.to_vec());
        draw.set_surface(facets);
        let linear = |c: f32| f64::from(((c + 0.055) / 1.055).powf(2.4));
        let [r, g, b] = BACKGROUND.map(linear);
        let mut encoder = device.create_command_encoder(&Default::default());
        let clear = wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: if samples > 1 { &many } else { &resolved },
                depth_slice: None,
                resolve_target: (samples > 1).then_some(&resolved),
                ops: wgpu::Operations { load: clear, store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depths,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        draw.record(&mut pass, &stepper, &view(eye), 1.0).unwrap();
        drop(pass);
        queue.submit([encoder.finish()]);
        read_back_picture(device, queue, &picture).unwrap()
    }

    /// Mean difference of the pictures, and the share of pixels that differ by more than 12 of 255.
    fn differences(a: &[[u8; 4]], b: &[[u8; 4]]) -> (f64, f64) {
        let far = |(a, b): (&[u8; 4], &[u8; 4])| (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap();
        let all: Vec<_> = a.iter().zip(b).map(far).collect();
        let mean = all.iter().map(|d| f64::from(*d)).sum::<f64>() / all.len() as f64;
        (mean, all.iter().filter(|d| **d > 12).count() as f64 / all.len() as f64)
    }

    /// The means of the light of 4 x 4 pixels, the size of the dither, at each of them.
    fn blurred(picture: &[[u8; 4]]) -> Vec<[u8; 4]> {
        let side = SIDE as usize;
        let block = |k: usize| {
            let (x, y) = (k % side / 4 * 4, k / side / 4 * 4);
            let light = |n: usize, c: usize| (f64::from(picture[(y + n / 4) * side + x + n % 4][c]) / 255.0).powf(2.2);
            let mean = |c: usize| (0..16).map(|n| light(n, c)).sum::<f64>() / 16.0;
            [0, 1, 2, 3].map(|c| (255.0 * mean(c).powf(1.0 / 2.2)) as u8)
        };
        (0..picture.len()).map(block).collect()
    }

    /// A texture of 64 x 64 pixels: waves of colour, and alpha that falls to the right.
    fn waves() -> Option<Arc<Texture>> {
        let pixel = |k: u32| {
            let (x, y) = (k % 64, k / 64);
            let wave = |n: u32| (127.0 + 120.0 * (n as f32 * 0.4).sin()) as u8;
            [wave(x), wave(y), wave(x + y), (255 - 4 * x.min(63)) as u8]
        };
        Some(Arc::new(Texture::new(64, 64, (0..64 * 64).map(pixel).collect()).unwrap()))
    }

    /// The square in `n` x `n` quads, whose texture coordinates run to `end`.
    fn divided(n: usize, end: f32) -> Vec<Facet> {
        let part = |k: usize| {
            let by = 1.0 / n as f32;
            let [x, y] = [k % n, k / n].map(|k| (k as f32 + 0.5) * by - 0.5);
            square().into_iter().map(move |f| {
                let corners = f.corners.map(|[a, b, c]| [x + by * a, y + by * b, c]);
                Facet { corners, uv: corners.map(|[x, y, _]| [end * (x + 0.5), end * (0.5 - y)]), ..f }
            })
        };
        (0..n * n).flat_map(part).collect()
    }

    #[test]
    fn the_gpu_draws_textures_alpha_and_wrapping_as_the_cpu_does() {
        let Some(gpu) = support::device() else { return };
        let wide = |from: f32, to: f32| {
            let uv = move |[u, v]: [f32; 2]| [from + (to - from) * u, from + (to - from) * v];
            square().into_iter().map(|f| Facet { uv: f.uv.map(uv), ..f }).collect::<Vec<_>>()
        };
        let tinted = |facets: Vec<Facet>| {
            let colors = [[1.0, 0.2, 0.2, 1.0], [0.2, 1.0, 0.2, 0.8], [0.2, 0.2, 1.0, 0.3]];
            facets.into_iter().map(|f| Facet { colors, ..f }).collect::<Vec<_>>()
        };
        let paint = |wrap, alpha| Paint { texture: waves(), wrap, alpha, ..Paint::default() };
        let (repeat, clamp, mirror) = ([Wrap::Repeat; 2], [Wrap::Clamp; 2], [Wrap::Mirror; 2]);
        let front = [0.0, 0.0, 2.0];
        let cases = [
            ("texture", paint(repeat, Alpha::Opaque), wide(0.0, 1.0), front),
            ("repeats", paint(repeat, Alpha::Opaque), wide(-1.3, 1.9), front),
            ("clamps", paint(clamp, Alpha::Opaque), wide(-1.3, 1.9), front),
            ("mirrors", paint(mirror, Alpha::Opaque), wide(-1.3, 1.9), front),
            ("mirrors and clamps", paint([Wrap::Mirror, Wrap::Clamp], Alpha::Opaque), wide(-0.7, 1.2), front),
            ("small and oblique", paint(repeat, Alpha::Opaque), divided(16, 6.0), [1.6, 0.3, 1.0]),
            ("behind", paint(repeat, Alpha::Opaque), wide(0.0, 1.0), [0.4, 0.0, -2.0]),
            ("mask", paint(repeat, Alpha::Mask(0.5)), wide(0.0, 1.0), front),
            ("blend", paint(repeat, Alpha::Blend), wide(0.0, 1.0), front),
            ("colours of corners", paint(repeat, Alpha::Blend), tinted(wide(0.0, 1.0)), front),
            (
                "no texture",
                Paint { color: [0.8, 0.3, 0.1, 0.5], alpha: Alpha::Blend, ..Paint::default() },
                wide(0.0, 1.0),
                front,
            ),
        ];
        let mut pictures: Vec<Vec<[u8; 4]>> = Vec::new();
        for (name, paint, facets, eye) in cases {
            // Where whole pixels are drawn or not, alpha is that of 4 x 4 of them.
            let is_coarse = gpu.0.adapter_info().backend == wgpu::Backend::Gl && matches!(paint.alpha, Alpha::Blend);
            let paints = [Paint::plain([0.0; 3]), paint];
            let facets: Vec<Facet> = facets.into_iter().map(|f| Facet { paint: 1, ..f }).collect();
            let (a, b) = (here(&paints, &facets, eye), there(&gpu, &paints, &facets, (eye, 4)));
            let (mean, large) = if is_coarse { differences(&blurred(&a), &blurred(&b)) } else { differences(&a, &b) };
            eprintln!("{name}: mean difference {mean:.3} of 255, {large:.4} of the pixels by more than 12");
            // Edges are sampled at other points, and levels are those of triangles on the CPU and of pixels on the GPU.
            // Whole pixels have 16 levels of alpha in place of 64.
            let most = if is_coarse { 6.0 } else { 3.0 };
            assert!(mean < most && large < 0.08, "{name}: {mean} {large}");
            assert!(pictures.iter().all(|other| differences(other, &a).0 > 1.0), "{name} is drawn as another case");
            pictures.push(a);
        }
    }

    #[test]
    fn one_sample_per_pixel_blends_too_and_facets_without_a_paint_are_white() {
        let Some(gpu) = support::device() else { return };
        let half = Paint { color: [0.0, 0.0, 0.0, 0.5], alpha: Alpha::Blend, ..Paint::default() };
        let drawn = there(&gpu, &[half], &square(), ([0.0, 0.0, 2.0], 1));
        let dark = |p: &[u8; 4]| p[2] < 60;
        let inner = (40..56).flat_map(|y| (40..56).map(move |x| y * SIDE as usize + x));
        assert_eq!(inner.filter(|k| dark(&drawn[*k])).count(), 128);
        let lost: Vec<Facet> = square().into_iter().map(|f| Facet { paint: 9, ..f }).collect();
        let drawn = there(&gpu, &[half_black()], &lost, ([0.0, 0.0, 2.0], 4));
        assert!(drawn[48 * SIDE as usize + 48][..3].iter().all(|x| *x > 200), "{:?}", drawn[48 * SIDE as usize + 48]);
    }

    fn half_black() -> Paint {
        Paint { color: [0.0, 0.0, 0.0, 0.5], ..Paint::default() }
    }
}
