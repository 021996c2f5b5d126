//! How many steps a frame crumpled cloth needs: many disorders, and how many of them are still stretched 2 s later.

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
    Ok(Case { calm: 2.0, ..Case::new(format!("heap {k}"), scene(cloth)) })
}

/// A table: a row a number of steps, and for each solver that has a bound how many of `count` heaps fail.
#[allow(clippy::print_stdout)]
pub fn run(count: usize, substeps: &[u32], threads: usize) {
    let solvers = SOLVERS.map(|s| (s.1 == Solver::Xpbd).then_some(s));
    let solvers: Vec<_> = solvers.into_iter().flatten().collect();
    println!("substeps,{}", solvers.iter().map(|s| s.0).collect::<Vec<_>>().join(","));
    for &substeps in substeps {
        let mut failed = vec![0; solvers.len()];
        let work = |(): &(), n: usize| {
            let (k, solver) = (n / solvers.len(), n % solvers.len());
            let case = Case { substeps, ..heap(k).ok()? };
            // What is asked beside the stretch takes longer than 2 s.
            let case = Case { asked: crate::case::Asked { rest: None, ..case.asked }, ..case };
            Some((solver, drive(&case, solvers[solver], None).failures.is_empty()))
        };
        crew::share(
            (count * solvers.len(), threads),
            || (),
            work,
            |outcome| {
                if let Some((solver, held)) = outcome {
                    failed[solver] += usize::from(!held);
                }
            },
        );
        println!("{substeps},{}", failed.iter().map(usize::to_string).collect::<Vec<_>>().join(","));
    }
}
