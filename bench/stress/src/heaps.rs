//! How many steps per frame crumpled cloth needs: many disorders, and how many of them are still stretched 2 s later.

use gimage_runtime::{Result, Solver};

use crate::case::{Case, N, SOLVERS, flag, scene};
use crate::crew;
use crate::drive::drive;
use crate::random::Random;

/// All particles but the pins at one point, on one line, or anywhere, within 1 m; by turns.
fn heap(k: usize) -> Result<Case> {
    let mut random = Random(1000 + k as u64);
    let (from, to) = (random.point(0.5), random.point(0.5));
    let mut place = |n: usize, grid: [f32; 3]| match k % 3 {
        _ if n == 0 || n == N - 1 => grid,
        0 => from,
        1 => [0, 1, 2].map(|c| from[c] + (to[c] - from[c]) * (n as f32 / (N * N) as f32)),
        _ => random.point(0.5),
    };
    let mut cloth = flag()?;
    let grid = cloth.positions().to_vec();
    cloth.place((0..N * N).map(|n| place(n, [grid[n][0], grid[n][1], grid[n][2]])).collect())?;
    Ok(Case::new(format!("heap {k}"), scene(cloth)))
}

/// A table: a row a number of steps, and for each solver that unfolds cloth how many of `count` heaps are stretched by more
/// than 5 % after 2 s, and how many are not at rest after 15.
#[allow(clippy::print_stdout)]
pub fn run(count: usize, substeps: &[u32], threads: usize) {
    let solvers: Vec<_> = SOLVERS.into_iter().filter(|s| s.solver == Solver::Xpbd).collect();
    let each = |words: [&str; 2]| {
        words.map(|w| solvers.iter().map(|s| format!("{} {w}", s.name)).collect::<Vec<_>>()).concat()
    };
    println!("substeps,heaps,{}", each(["stretched", "restless"]).join(","));
    for &substeps in substeps {
        let mut failed = [vec![0; solvers.len()], vec![0; solvers.len()]];
        let work = |(): &(), n: usize| {
            let (k, solver) = (n / solvers.len(), n % solvers.len());
            let case = Case { substeps, ..heap(k).ok()? };
            let out = drive(&case, solvers[solver], None);
            // Written so that NaN fails.
            Some((solver, [out.stretch.abs() < 0.05, out.rest < 1.0]))
        };
        crew::share(
            (count * solvers.len(), threads),
            || (),
            work,
            |outcome| {
                let Some((solver, held)) = outcome else { return };
                failed.iter_mut().zip(held).for_each(|(f, held)| f[solver] += usize::from(!held));
            },
        );
        println!("{substeps},{count},{}", failed.concat().iter().map(usize::to_string).collect::<Vec<_>>().join(","));
    }
}
