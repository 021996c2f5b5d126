use super::*;

/// A closed ball of n x 2 n quads that is pressed flat and bent, without the quads that are `holes`.
fn bent_ball(n: usize, holes: impl Fn(usize) -> bool) -> Vec<[V3; 3]> {
    let at = |i: usize, j: usize| {
        let (s, c) = (std::f64::consts::PI * i as f64 / n as f64).sin_cos();
        let (t, u) = (std::f64::consts::PI * (j % (2 * n)) as f64 / n as f64).sin_cos();
        let (x, y) = (s * u, c);
        [x, 0.4 * s * t + 0.3 * x * x, y + 0.2 * (5.0 * x).sin()]
    };
    let quads = (0..n).flat_map(|i| (0..2 * n).map(move |j| (i, j)));
    quads
        .enumerate()
        .filter(|(k, _)| !holes(*k))
        .flat_map(|(_, (i, j))| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

/// Points in and around the ball, some of them near its surface.
fn points(triangles: &[[V3; 3]]) -> Vec<V3> {
    let box_of = |k: usize| {
        let mut state = 2654435761u64.wrapping_mul(k as u64 + 1);
        [0; 3].map(|_| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            3.0 * ((state >> 33) as f64 / (1u64 << 31) as f64 - 0.5)
        })
    };
    let near = triangles.iter().step_by(7).enumerate().map(|(k, t)| {
        let off = [1e-6, 1e-3, 0.02, -1e-6, -1e-3, -0.02][k % 6];
        let n = cross(sub(t[1], t[0]), sub(t[2], t[0]));
        let long = dot(n, n).sqrt().max(1e-12);
        [0, 1, 2].map(|c| (t[0][c] + t[1][c] + t[2][c]) / 3.0 + off * n[c] / long)
    });
    (0..2000).map(box_of).chain(near).collect()
}

#[test]
fn small_angles_are_those_of_the_arc_tangent() {
    for k in -1000..=1000 {
        let x = FAR * f64::from(k) / 1000.0;
        assert!((small_angle(x) - x.atan()).abs() < 1.1e-11, "{x}");
    }
}

#[test]
fn a_tetrahedron_winds_once_around_its_middle_and_not_around_points_outside() {
    let at = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let winding = Winding::new(faces.into_iter().map(|f: [usize; 3]| f.map(|v| at[v])));
    assert!((winding.number([0.2, 0.2, 0.2]) - 1.0).abs() < 1e-9);
    assert!(winding.number([0.5, 0.5, 0.5]).abs() < 1e-9);
    assert!(winding.number([-3.0, 7.0, 1.0]).abs() < 1e-9);
}

#[test]
fn triangles_that_count_together_wind_as_often_as_each_alone() {
    let cases: [fn(usize) -> bool; 3] = [|_| false, |k| k % 10 == 3, |k| k < 700];
    for holes in cases {
        let triangles = bent_ball(32, holes);
        let winding = Winding::new(triangles.iter().copied());
        let (mut most, mut inside) = (0.0f64, 0);
        for p in points(&triangles) {
            let exact = triangles.iter().map(|t| half_angle(t, p)).sum::<f64>() / (2.0 * std::f64::consts::PI);
            most = most.max((winding.number(p) - exact).abs());
            inside += usize::from(exact > 0.5);
        }
        eprintln!("{} triangles, {inside} points inside, {most}", triangles.len());
        assert!(most < 0.01 && inside > 100, "{most}, {inside}");
    }
}

#[test]
fn nothing_and_points_in_place_of_triangles_wind_around_nothing() {
    assert_eq!(Winding::new(std::iter::empty()).number([0.0; 3]), 0.0);
    let points = Winding::new(std::iter::repeat_n([[1.0, 2.0, 3.0]; 3], 20));
    assert_eq!(points.number([0.0; 3]), 0.0);
    assert_eq!(points.number([1.0, 2.0, 3.0]), 0.0);
}
