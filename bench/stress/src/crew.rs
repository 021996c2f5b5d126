//! Cases shared out among threads.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Does `count` pieces of work on `threads` threads, each as soon as one is free, and hands every result to `done` in the
/// order of the work. Every thread makes its own tools.
pub fn share<T, R: Send>(
    (count, threads): (usize, usize),
    tools: impl Fn() -> T + Sync,
    work: impl Fn(&T, usize) -> R + Sync,
    done: impl FnMut(R) + Send,
) {
    let (next, waiting) = (AtomicUsize::new(0), Mutex::new((0, BTreeMap::new(), done)));
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                let tools = tools();
                loop {
                    let k = next.fetch_add(1, Ordering::Relaxed);
                    if k >= count {
                        return;
                    }
                    let result = work(&tools, k);
                    let Ok(mut waiting) = waiting.lock() else { return };
                    let (due, list, done) = &mut *waiting;
                    list.insert(k, result);
                    while let Some(result) = list.remove(due) {
                        done(result);
                        *due += 1;
                    }
                }
            });
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_order_whatever_the_threads() {
        for threads in [1, 2, 5] {
            let mut out = Vec::new();
            // The first take longest.
            let work = |by: &usize, k: usize| (0..(20 - k) * 10_000).fold(k * by, |x, y| x + y / 1_000_000);
            share((20, threads), || 3, work, |x| out.push(x));
            assert_eq!(out, (0..20).map(|k| 3 * k).collect::<Vec<_>>());
        }
    }
}
