use gimage_runtime::*;
use std::time::Instant;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let (name, n, sub, it, solver, teth) = (&a[1], a[2].parse().unwrap(), a[3].parse().unwrap(), a[4].parse().unwrap(), &a[5], a[6] == "t");
    let scene = scene::builtin(name, n).unwrap();
    let frames = scene.frames;
    let options = Options { backend: Backend::Cpu, solver: if solver == "x" { Solver::Xpbd } else { Solver::Classic }, substeps: sub, iterations: it, tethers: if teth {2} else {0}, normals: false, threads: 1, ..Options::default() };
    let mut s = Stepper::new(scene, options, None).unwrap();
    println!("{}", s.plan());
    let h = 1.0 / (n as f64 - 1.0);
    let (mut best, mut smax, mut mean, mut cnt, mut rms, mut all) = (1e9f64, 0f64, 0f64, 0, 0f64, 0f64);
    let mut old: Vec<[f32; 4]> = vec![];
    let (mut pen, mut tun) = (0f64, 0);
    let mut times = vec![];
    for f in 0..frames {
        let t = Instant::now();
        s.advance(1.0 / 60.0).unwrap();
        let e = t.elapsed().as_secs_f64() * 1e3;
        best = best.min(e); times.push(e);
        let p = s.positions(0).unwrap();
        let st = |a: usize, b: usize| { let d: f64 = (0..3).map(|c| (p[a][c] as f64 - p[b][c] as f64).powi(2)).sum(); (d.sqrt() / h - 1.0).abs() };
        let w = n as usize;
        let (mut m, mut sum, mut c) = (0f64, 0f64, 0);
        for j in 0..w { for i in 0..w { let k = j * w + i; if i + 1 < w { let x = st(k, k + 1); m = m.max(x); sum += x; c += 1; } if j + 1 < w { let x = st(k, k + w); m = m.max(x); sum += x; c += 1; } } }
        all = all.max(m);
        for q in p { pen = pen.max(0.3 - (0..3).map(|c| (q[c] as f64).powi(2)).sum::<f64>().sqrt()); }
        if f + 60 >= frames { smax = smax.max(m); mean += sum / c as f64; cnt += 1;
            if !old.is_empty() { let v: f64 = p.iter().zip(&old).map(|(a, b)| (0..3).map(|c| ((a[c] - b[c]) as f64 * 60.0).powi(2)).sum::<f64>()).sum::<f64>() / p.len() as f64; rms += v; }
        }
        old = p.to_vec();
        if f == frames - 1 && name.starts_with("s2") { let p0 = s.scene().cloths[0].positions(); tun = p.iter().zip(p0).filter(|(p, q)| q[0].hypot(q[2]) < 0.2 && p[1] < 0.0).count(); }
    }
    if std::env::var("WHERE").is_ok() {
        let p = &old; let w = n as usize;
        let st = |a: usize, b: usize| { let d: f64 = (0..3).map(|c| (p[a][c] as f64 - p[b][c] as f64).powi(2)).sum(); d.sqrt() / h - 1.0 };
        let mut all: Vec<(f64, usize, usize, char)> = vec![];
        for j in 0..w { for i in 0..w { let k = j * w + i; if i + 1 < w { all.push((st(k, k + 1), i, j, 'R')); } if j + 1 < w { all.push((st(k, k + w), i, j, 'D')); } } }
        all.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
        for x in &all[..12] { println!("{x:?} z {} y {}", p[x.2 * w + x.1][2], p[x.2 * w + x.1][1]); }
    }
    times.sort_by(f64::total_cmp);
    let ymin = old.iter().map(|p| p[1]).fold(0f32, f32::min);
    println!("{name} n={n} sub={sub} it={it}: min {best:.4} median {:.4} ms  max {:.4}% mean {:.5}% rms {:.3} mm/s transient {:.2}% hem {ymin} pen {:.4} mm tunnelled {tun}", times[times.len() / 2], smax * 100.0, mean / cnt as f64 * 100.0, (rms / cnt as f64).sqrt() * 1e3, all * 100.0, pen.max(0.0) * 1e3);
}
