use super::*;
use crate::Flat;
use crate::cloth::Rest;

fn square(n: u32) -> Cloth {
    Flat::square("square", n).cloth().unwrap()
}

/// A strip of `n` columns and 9 rows, whose first row is sewn to itself: column i to column `sum - i`.
fn folded(n: u32, sum: u32) -> Result<Cloth> {
    let flat = Flat { width: n, height: 9, ..Flat::square("folded", 2) }.cloth()?;
    let mate = |i: u32| sum.checked_sub(i).filter(|m| *m < n && *m != i);
    let next = |k: u32| if k < n { mate(k) } else { None };
    let positions = flat.positions().iter().enumerate().map(|(k, p)| match next(k as u32) {
        Some(mate) => flat.positions()[k.min(mate as usize)],
        None => *p,
    });
    let particles = (0..flat.len() as u32).map(|k| Particle::Free { next: next(k) }).collect();
    let (name, grids) = ("folded".into(), flat.grids().to_vec());
    let (rest, mass) = (flat.rest().clone(), Mass::Constant(1e-3));
    Cloth::new(Parts { name, grids, positions: positions.collect(), particles, rest, mass })
}

#[test]
fn odd_and_even_sides_keep_their_corners() {
    for (n, coarse) in [(4, 3), (5, 3), (32, 17), (33, 17), (64, 33), (65, 33)] {
        let fine = square(n);
        let coarser = fine.coarser().unwrap();
        let cloth = coarser.cloth();
        assert_eq!((cloth.grids()[0].width, cloth.grids()[0].height), (coarse, coarse), "{n}");
        let last = (coarse * coarse - 1) as usize;
        let corners = [0, coarse as usize - 1, last + 1 - coarse as usize, last].map(|k| coarser.samples()[k]);
        assert_eq!(corners, [0, n - 1, n * n - n, n * n - 1], "{n}");
        assert!((cloth.total_mass() - fine.total_mass()).abs() < 1e-6, "{n}");
        for (k, p) in coarser.samples().iter().zip(cloth.positions()) {
            assert_eq!(p, &fine.positions()[*k as usize]);
        }
    }
    assert!(matches!(square(2).coarser(), Err(Error::Coarser { .. })));
    let mut cut = square(9);
    cut.open();
    assert!(cut.coarser().unwrap_err().to_string().contains("cut"));
}

#[test]
fn rest_lengths_are_those_along_the_springs() {
    let coarser = square(33).coarser().unwrap();
    let Rest::Constant(rest) = coarser.cloth().rest() else { panic!("all cells are alike") };
    let h = 1.0 / 16.0;
    for (length, expected) in rest[0].iter().zip([h, h, h * 2f32.sqrt(), h * 2f32.sqrt()]) {
        assert!((length - expected).abs() < 1e-6, "{length}");
    }
    // The last cell of an even side is one texel wide, and its diagonals are straight lines.
    let coarser = square(8).coarser().unwrap();
    let cloth = coarser.cloth();
    assert!(matches!(cloth.rest(), Rest::Image(_)));
    for (k, d) in (0..cloth.len()).flat_map(|k| (0..4).map(move |d| (k, d))) {
        let Some(other) = cloth.neighbour(0, k, d) else { continue };
        let [a, b] = [k, other].map(|k| cloth.positions()[k]);
        let far = (a[0] - b[0]).hypot(a[2] - b[2]);
        assert!((cloth.spring(0, k, d) - far).abs() < 1e-5, "{k} {d}: {} {far}", cloth.spring(0, k, d));
    }
}

#[test]
fn seams_close_wherever_they_begin() {
    // Sums that are even join texels of one parity, odd ones those of both.
    for (n, sum) in [(33, 32), (33, 20), (33, 21), (33, 31), (32, 31), (32, 20), (65, 41), (64, 64)] {
        let fine = folded(n, sum).unwrap();
        let coarser = fine.coarser().unwrap_or_else(|e| panic!("{n} {sum}: {e}"));
        let (cloth, map) = (coarser.cloth(), &coarser.map);
        assert!(cloth.ring_count() * 2 >= fine.ring_count() - 2, "{n} {sum}: {} rings", cloth.ring_count());
        assert!(cloth.len() * 2 < fine.len(), "{n} {sum}: {} of {}", cloth.len(), fine.len());
        for ring in 0..cloth.ring_count() {
            let fine_of = |k: &u32| coarser.samples()[*k as usize];
            let members: Vec<u32> = cloth.ring(ring).iter().map(fine_of).collect();
            let mut own = fine.ring_of(members[0]).unwrap().to_vec();
            own.sort_unstable();
            let mut members = members.clone();
            members.sort_unstable();
            assert_eq!(members, own, "{n} {sum}");
        }
        for ring in 0..fine.ring_count() {
            let stencils: Vec<_> = fine.ring(ring).iter().map(|k| map.stencils[*k as usize]).collect();
            assert!(stencils.iter().all(|s| *s == stencils[0]), "{n} {sum}");
        }
        assert!((cloth.total_mass() - fine.total_mass()).abs() < 1e-5 * fine.total_mass(), "{n} {sum}");
        // Openings keep their size: the first and the last seam point of the fine image stay.
        let fine_rings = fine.rings().1;
        for end in [*fine_rings.iter().min().unwrap(), *fine_rings.iter().max().unwrap()] {
            assert!(coarser.samples().contains(&end), "{n} {sum}: {end}");
        }
        let points = cloth.points();
        for (k, d) in (0..cloth.len()).flat_map(|k| (0..4).map(move |d| (k, d))) {
            let joined = cloth.neighbour(0, k, d).is_some_and(|other| points[k] == points[other]);
            assert!(!joined || cloth.spring(0, k, d) == 0.0, "{n} {sum}: a spring between duplicates");
        }
    }
}

#[test]
fn what_lies_between_is_on_the_triangles() {
    for n in [8, 9, 33] {
        let fine = square(n);
        let coarser = fine.coarser().unwrap();
        let coarse = coarser.cloth().positions();
        for (stencil, p) in coarser.map.stencils.iter().zip(fine.positions()) {
            let q = [0, 1, 2].map(|c| stencil.parts().map(|(k, w)| w * coarse[k][c]).sum::<f32>());
            assert!((0..3).all(|c| (q[c] - p[c]).abs() < 1e-6), "{n}: {q:?} {p:?}");
            assert!((stencil.weight.iter().sum::<f32>() - 1.0).abs() < 1e-6);
        }
    }
}

#[test]
fn pins_limits_texture_and_material_come_along() {
    let mut fine = square(17);
    // A pinned row, and one pin between coarse texels.
    let row: Vec<u32> = (0..17).collect();
    fine.pin(&row).unwrap();
    fine.pin(&[5 * 17 + 5]).unwrap();
    fine.limits = Some((0..289).map(|k| k as f32 * 1e-3).collect());
    fine.set_grain(Some((0..289).map(|k| [k as f32, 0.0]).collect())).unwrap();
    fine.set_material(&Material { bend: 1e-4, damping: 0.7, ..Material::default() }).unwrap();
    (fine.velocity, fine.speed_limit) = ([1.0, 0.0, 0.0], 9.0);
    let coarser = fine.coarser().unwrap();
    let cloth = coarser.cloth();
    let pinned = cloth.particles().iter().filter(|p| p.is_pinned()).count();
    assert_eq!(pinned, 9 + 1);
    assert_eq!(cloth.limits.as_ref().unwrap()[4], 8e-3);
    assert_eq!(cloth.uv()[9 + 1], [36.0, 0.0]);
    assert_eq!((cloth.velocity, cloth.speed_limit, cloth.damping), ([1.0, 0.0, 0.0], 9.0, 0.7));
    assert!(cloth.membrane().is_some() && cloth.bending().is_some());
    assert_eq!(cloth.membrane().unwrap().woven, fine.membrane().unwrap().woven);
    assert!((cloth.total_mass() - fine.total_mass()).abs() < 1e-6);
    assert!(cloth.check().is_ok());
    // A chain of images ends where none is coarser.
    let mut sizes = Vec::new();
    let mut next = fine.coarser();
    while let Ok(coarser) = next {
        sizes.push(coarser.cloth().grids()[0].width);
        next = coarser.cloth().coarser();
    }
    assert_eq!(sizes, [9, 5, 3, 2]);
}
