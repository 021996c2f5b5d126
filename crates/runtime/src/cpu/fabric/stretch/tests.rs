use super::*;
use crate::cloth::Grid;

/// Numbers from -0.5 to 0.5.
fn noise(k: usize) -> f32 {
    ((k * 7919 + 13) % 1009) as f32 / 1009.0 - 0.5
}

fn rest(k: usize) -> f32 {
    if k.is_multiple_of(29) { 0.0 } else { 1.0 + 0.2 * noise(k + 5) }
}

fn weight(k: usize, alike: bool) -> f32 {
    match (alike, k % 17) {
        (true, _) => 5.0,
        (false, 0) => 0.0,
        (false, n) => 4.0 + n as f32,
    }
}

/// The rule for one spring, number by number.
fn relax(p: &mut [[f32; 3]], (a, b): (usize, usize), rest: f32, alike: bool) {
    let (wa, wb) = (weight(a, alike), weight(b, alike));
    let d = [0, 1, 2].map(|c| p[b][c] - p[a][c]);
    let far = ((d[0] * d[0] + d[1] * d[1]) + d[2] * d[2]).sqrt().max(1e-9);
    let [ga, gb] = if rest <= 0.0 {
        [0.0; 2]
    } else if alike {
        [0.5 - 0.5 * rest / far; 2]
    } else {
        let g = (far - rest) / (far * (wa + wb)).max(1e-30);
        [g * wa, g * wb]
    };
    for c in 0..3 {
        p[a][c] += d[c] * ga;
        p[b][c] -= d[c] * gb;
    }
}

/// The ends of the springs of a colour, and where their rest lengths are.
fn colour(width: usize, height: usize, (direction, parity): (u32, usize)) -> Vec<[usize; 3]> {
    let mut all = Vec::new();
    for k in 0..width * height {
        let (i, j) = (k % width, k / width);
        let (right, down) = (i + 1 < width, j + 1 < height && j % 2 == parity);
        match direction {
            0 if right && i % 2 == parity => all.push([k, k + 1, k]),
            1 if down => all.push([k, k + width, k]),
            2 if right && down => all.push([k, k + width + 1, k]),
            3 if right && down => all.push([k + width, k + 1, k + width]),
            _ => {}
        }
    }
    all
}

#[test]
fn rows_of_all_widths_give_the_bits_of_the_rule_number_by_number() {
    let height = 5;
    for (width, alike) in (2..=72).flat_map(|width| [(width, false), (width, true)]) {
        let mut sheet =
            Sheet::<f32>::new(&Grid { name: String::new(), first: 0, width: width as u32, height: height as u32 });
        let count = width * height;
        let at = |k: usize| [(k % width) as f32 + noise(k), noise(k + 1), (k / width) as f32 + noise(k + 2)];
        let mut p: Vec<[f32; 3]> = (0..count).map(at).collect();
        (0..count).for_each(|k| sheet.put(sheet.triple(k), p[k]));
        sheet.weigh(|k| weight(k, alike));
        for (direction, parity) in (0..4).flat_map(|d| [(d, 0), (d, 1)]) {
            let springs = colour(width, height, (direction, parity));
            let of = |k: usize| springs.iter().find(|s| s[2] == k).map_or(0.0, |_| rest(k));
            let list = Rests::List(Arc::new(sheet.list(0.0, of)));
            let mut all = Springs { rest: list, soft: Values::Constant(0.0), sums: Vec::new(), bound: 0.0 };
            run(&Threads::one(), &mut sheet, &mut all, (direction, parity as u32), false, 0.01);
            springs.iter().for_each(|[a, b, k]| relax(&mut p, (*a, *b), rest(*k), alike));
            let same = (0..count).all(|k| sheet.at(sheet.triple(k)) == p[k]);
            assert!(same, "{width} columns, direction {direction}, parity {parity}, alike {alike}");
        }
    }
}
