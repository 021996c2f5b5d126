//! Sharing out cloths and rows among threads, so that the result does not depend on their number.

use crate::error::{Error, Result};

/// Below this many bytes a pass is quicker than handing it over.
#[cfg(feature = "threads")]
const WORTH_SHARING: usize = 1 << 18;
/// The same where the caller alone could run all passes of a step in one walk, which reads a row once: two threads need
/// as long pass by pass at 256 x 256 particles, and three times as long at 128 x 128.
#[cfg(feature = "threads")]
const WORTH_PARTING: usize = 1 << 20;

/// Steps of a particle from which on cloths are shared out: some 50 microseconds.
#[cfg(feature = "threads")]
const WORTH_STEPS: usize = 1 << 12;

/// The threads that a stepper may use.
pub struct Threads {
    #[cfg(feature = "threads")]
    pool: Option<rayon::ThreadPool>,
}

impl Threads {
    /// 1 starts none; 0 starts one for each core. Without the feature `threads`, and in a browser, there is only the caller's.
    #[cfg(feature = "threads")]
    pub fn new(count: usize) -> Result<Self> {
        if count == 1 || (count == 0 && cfg!(target_family = "wasm")) {
            return Ok(Threads { pool: None });
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
        Ok(Threads { pool: Some(pool.map_err(|e| Error::Threads(e.to_string()))?) })
    }

    /// As above.
    #[cfg(not(feature = "threads"))]
    pub fn new(count: usize) -> Result<Self> {
        if count > 1 {
            return Err(Error::Threads("built without the feature `threads`".into()));
        }
        Ok(Threads {})
    }

    /// The caller's alone.
    pub fn one() -> Self {
        Threads {
            #[cfg(feature = "threads")]
            pool: None,
        }
    }

    /// Number of threads.
    pub fn count(&self) -> usize {
        #[cfg(feature = "threads")]
        return self.pool.as_ref().map_or(1, |pool| pool.current_num_threads());
        #[cfg(not(feature = "threads"))]
        1
    }

    /// Whether all passes of a step over this list are the caller's alone.
    pub fn alone<A>(&self, _list: &[A]) -> bool {
        #[cfg(feature = "threads")]
        return self.pool.is_none() || size_of_val(_list) < WORTH_PARTING;
        #[cfg(not(feature = "threads"))]
        true
    }

    /// Calls `work` with each of some cloths, which have this many particles and steps in all.
    pub fn each<A: Send>(&self, cloths: &mut [A], _steps: usize, work: impl Fn(&mut A) + Sync + Send) {
        #[cfg(feature = "threads")]
        if let Some(pool) = self.pool.as_ref().filter(|_| cloths.len() > 1 && _steps >= WORTH_STEPS) {
            use rayon::prelude::*;
            return pool.install(|| cloths.par_iter_mut().with_max_len(1).for_each(work));
        }
        cloths.iter_mut().for_each(work);
    }

    /// Calls `work` with the number and the elements of each chunk of `size`; the last may be shorter.
    pub fn chunks<A: Send>(&self, data: &mut [A], size: usize, work: impl Fn(usize, &mut [A]) + Sync + Send) {
        #[cfg(feature = "threads")]
        if let Some(pool) = self.pool.as_ref().filter(|_| size_of_val(data) >= WORTH_SHARING) {
            use rayon::prelude::*;
            let together = (WORTH_SHARING / 8 / (size * size_of::<A>()).max(1)).max(1);
            let each = || data.par_chunks_mut(size).with_min_len(together).enumerate().for_each(|(k, c)| work(k, c));
            return pool.install(each);
        }
        data.chunks_mut(size).enumerate().for_each(|(k, c)| work(k, c));
    }

    /// As [`Threads::chunks`] over two lists, each in chunks of its own size.
    pub fn chunks2<A: Send, B: Send>(
        &self,
        a: &mut [A],
        b: &mut [B],
        size: (usize, usize),
        work: impl Fn(usize, &mut [A], &mut [B]) + Sync + Send,
    ) {
        #[cfg(feature = "threads")]
        if let Some(pool) = self.pool.as_ref().filter(|_| size_of_val(a) >= WORTH_SHARING) {
            use rayon::prelude::*;
            let both = a.par_chunks_mut(size.0).zip(b.par_chunks_mut(size.1));
            let each = || both.enumerate().for_each(|(k, (a, b))| work(k, a, b));
            return pool.install(each);
        }
        a.chunks_mut(size.0).zip(b.chunks_mut(size.1)).enumerate().for_each(|(k, (a, b))| work(k, a, b));
    }

    /// As [`Threads::chunks`] over three lists of one length.
    pub fn chunks3<A: Send>(
        &self,
        [a, b, c]: [&mut [A]; 3],
        size: usize,
        work: impl Fn(usize, [&mut [A]; 3]) + Sync + Send,
    ) {
        #[cfg(feature = "threads")]
        if let Some(pool) = self.pool.as_ref().filter(|_| size_of_val(a) >= WORTH_SHARING) {
            use rayon::prelude::*;
            let all = a.par_chunks_mut(size).zip(b.par_chunks_mut(size)).zip(c.par_chunks_mut(size));
            return pool.install(|| all.enumerate().for_each(|(k, ((a, b), c))| work(k, [a, b, c])));
        }
        let all = a.chunks_mut(size).zip(b.chunks_mut(size)).zip(c.chunks_mut(size));
        all.enumerate().for_each(|(k, ((a, b), c))| work(k, [a, b, c]));
    }
}
