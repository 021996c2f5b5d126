use super::*;
use crate::base::shapes;
use crate::base::topology::Topology;
use crate::options::BuildOptions;
use crate::stage::measure::{MeasureOptions, measure};
use proptest::prelude::*;

fn options() -> ImageOptions {
    let mut build = BuildOptions::default();
    build.image.effort = crate::options::Effort::Fast;
    ImageOptions::new(&build, Some(4096))
}

fn topology(s: &Surface) -> (i64, usize) {
    let t = Topology::of(&s.triangles);
    (t.euler, t.boundary_loops)
}

/// Everything that must hold of any split.
fn check(name: &str, s: &Surface, parts: &Parts) {
    let (_, triangles) = parts.welded();
    let t = Topology::of(&triangles);
    assert_eq!((t.euler, t.boundary_loops), topology(s), "{name}");
    assert_eq!((t.components, t.non_manifold_edges, t.singular_vertices), (1, 0, 0), "{name}");
    let triangles: usize = parts.parts.iter().map(|p| p.surface.triangles.len()).sum();
    assert_eq!(triangles, s.triangles.len(), "{name}: every triangle is in one part");
    let mut seen = std::collections::BTreeSet::new();
    for ring in &parts.rings {
        assert!(ring.len() > 1 && ring.is_sorted());
        let at = |&(p, k): &PartTexel| parts.parts[p as usize].image.grid.positions[k as usize].map(f64::to_bits);
        assert!(ring.iter().all(|r| at(r) == at(&ring[0])), "{name}: duplicates differ");
        assert!(ring.iter().all(|r| seen.insert(*r)), "{name}: a texel is in two rings");
        // A ring has all members of the rings of its grids.
        for &(p, k) in ring {
            let next = parts.parts[p as usize].image.grid.links[k as usize];
            assert!(next == NONE || ring.contains(&(p, next)), "{name}: a ring leaves out a duplicate");
        }
    }
    let spans = |r: &Vec<PartTexel>| r.iter().any(|m| m.0 != r[0].0);
    assert!(parts.rings.iter().any(spans), "{name}: parts are joined");
    for PartImage { image, .. } in &parts.parts {
        assert!(image.closed && image.grid.rings_are_closed(), "{name}");
        assert_eq!(image.distortion.flips, 0, "{name}");
        for ring in image.grid.rings() {
            let at = |k: u32| image.grid.positions[k as usize].map(f64::to_bits);
            assert!(ring.iter().all(|&k| at(k) == at(ring[0])), "{name}: duplicates of a cut differ");
        }
    }
}

#[test]
fn a_surface_of_more_holes_than_the_budget_holds_is_refused_before_any_image() {
    let sheet = shapes::rectangle(120, 120, 1.0, 1.0);
    let net = shapes::without(&sheet, |t| (t / 2 % 120) % 2 == 1 && (t / 240) % 2 == 1);
    assert_eq!(topology(&net), (1 - 3481, 3482));
    let Err(e) = image_parts("net", &net, None, &options(), 5000) else { panic!("it was built") };
    assert!(matches!(e, Error::TooLarge { .. }), "{e}");
    assert!(e.to_string().contains("Euler number -3480, 3482 boundary loops"), "{e}");
}

#[test]
fn any_number_of_parts_welds_to_the_surface() {
    for (name, s) in shapes::all().into_iter().filter(|x| x.1.triangles.len() >= 40) {
        for k in 2..=8 {
            match image_at_least(name, &s, None, &options(), 4096, k) {
                Ok(parts) => {
                    assert!(parts.parts.len() >= k, "{name}: {} parts for {k}", parts.parts.len());
                    assert!(parts.texels() <= 4096, "{name}: {} texels", parts.texels());
                    check(&format!("{name} in {k}"), &s, &parts);
                }
                Err(e) => panic!("{name} in {k}: {e}"),
            }
        }
    }
}

#[test]
fn threads_do_not_change_a_bit_of_the_parts() {
    for s in [shapes::holed(6), shapes::plate(3), shapes::klein(16, 8)] {
        let run = |n: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
            let parts = pool.install(|| image_at_least("x", &s, None, &options(), 4096, 5)).unwrap();
            let grids: Vec<_> = parts.parts.iter().map(|p| p.image.grid.clone()).collect();
            (grids, parts.rings)
        };
        assert_eq!(run(1), run(3));
    }
}

fn psnr(s: &Surface, parts: &Parts) -> f64 {
    let (positions, triangles) = parts.welded();
    let options = MeasureOptions { samples: 20_000, seed: 1 };
    measure(&s.positions, &s.triangles, &positions, &triangles, &options).unwrap().psnr
}

/// A sheet of `n` x `n` quads without every second quad of every second row.
fn lace(n: u32) -> Surface {
    shapes::without(&shapes::rectangle(n, n, 1.0, 1.0), |t| {
        let (i, j) = (t as u32 / 2 % n, t as u32 / 2 / n);
        i % 2 == 1 && j % 2 == 1
    })
}

#[test]
fn a_flat_sheet_of_400_holes_is_above_60_db_in_parts() {
    let s = lace(41);
    assert_eq!(topology(&s), (-399, 401));
    let parts =
        image_parts("lace", &s, None, &ImageOptions::new(&BuildOptions::default(), Some(16_384)), 16_384).unwrap();
    check("lace", &s, &parts);
    let db = psnr(&s, &parts);
    assert!(db > 60.0, "{db}");
    assert!(parts.texels() <= 16_384 && parts.parts.len() <= MAX_PARTS);
}

/// A flat comb, its teeth eight times as long as wide.
fn comb(teeth: u32) -> Surface {
    let w = 4 * teeth + 2;
    shapes::without(&shapes::rectangle(w, 60, 1.0, 1.0), |t| {
        let (i, j) = (t as u32 / 2 % w, t as u32 / 2 / w);
        j > 6 && i % 4 >= 2
    })
}

/// A flat sheet with `n` x `n` round holes, each of 16 edges.
fn round_lace(n: u32) -> Surface {
    // Each cell a ring of 16 around its hole, and quads out to the cell's square.
    let mut positions = Vec::new();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for j in 0..n {
        for i in 0..n {
            let base = positions.len() as u32;
            for r in 0..4 {
                for k in 0..16 {
                    let a = std::f64::consts::TAU * k as f64 / 16.0;
                    let (c, s) = (a.cos(), a.sin());
                    let square = 1.0 / c.abs().max(s.abs());
                    let f = r as f64 / 3.0;
                    let l = 0.3 * (1.0 - f) + 0.5 * square * f;
                    let q = |x: f64| (x * 1e9).round() / 1e9;
                    positions.push([
                        q((i as f64 + 0.5 + l * c) / n as f64),
                        q((j as f64 + 0.5 + l * s) / n as f64),
                        0.0,
                    ]);
                }
            }
            for r in 0..3u32 {
                for k in 0..16u32 {
                    let at = |r: u32, k: u32| base + 16 * r + k % 16;
                    triangles.push([at(r, k), at(r + 1, k), at(r + 1, k + 1)]);
                    triangles.push([at(r, k), at(r + 1, k + 1), at(r, k + 1)]);
                }
            }
        }
    }
    let mut index = std::collections::BTreeMap::new();
    let mut kept = Vec::new();
    let to: Vec<u32> = positions
        .iter()
        .map(|p: &[f64; 3]| {
            *index.entry(p.map(f64::to_bits).map(|b| if b == 1 << 63 { 0 } else { b })).or_insert_with(|| {
                kept.push(*p);
                kept.len() as u32 - 1
            })
        })
        .collect();
    let all = shapes::surface(kept, triangles.iter().map(|t| t.map(|v| to[v as usize])).collect());
    shapes::without(&all, |_| false)
}

#[test]
fn combs_handles_and_round_holes_are_good_in_parts() {
    let options = ImageOptions::new(&BuildOptions::default(), Some(16_384));
    for (name, s, least) in
        [("comb", comb(20), 60.0), ("genus 20", shapes::plate(20), 70.0), ("lace", round_lace(10), 60.0)]
    {
        let parts = image_parts(name, &s, None, &options, 16_384).unwrap();
        check(name, &s, &parts);
        let db = psnr(&s, &parts);
        assert!(db > least, "{name}: {db} dB in {} parts", parts.parts.len());
        // The verdict of the parts is near what is measured of the whole, and never much better.
        let (verdict, _) = parts.verdict(&s);
        assert!(verdict.psnr() < db + 2.0, "{name}: {} {db}", verdict.psnr());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]
    #[test]
    fn random_surfaces_split_in_parts_weld(seed in any::<u64>(), holes in 0usize..20, k in 2usize..9) {
        let s = shapes::blob(seed, 40, holes);
        prop_assume!(s.triangles.len() >= 40);
        let parts = image_at_least("blob", &s, None, &options(), 4096, k);
        prop_assert!(parts.is_ok(), "{:?}", parts.err().map(|e| e.to_string()));
        check("blob", &s, &parts.unwrap());
    }
}
