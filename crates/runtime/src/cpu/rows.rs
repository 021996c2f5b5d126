//! Sharing out rows among threads, so that the result does not depend on their number.

use crate::error::{Error, Result};

/// Below this many numbers a pass is quicker than handing it over.
#[cfg(feature = "threads")]
const WORTH_SHARING: usize = 16_384;

/// The threads that a stepper may use.
pub struct Threads {
    #[cfg(feature = "threads")]
    pool: Option<rayon::ThreadPool>,
}

impl Threads {
    /// 1 starts none; 0 starts one for each core. Without the feature `threads` there is only the caller's.
    #[cfg(feature = "threads")]
    pub fn new(count: usize) -> Result<Self> {
        if count == 1 {
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

    /// Whether a pass over so many numbers is the caller's alone.
    pub fn alone(&self, _numbers: usize) -> bool {
        #[cfg(feature = "threads")]
        return self.pool.is_none() || _numbers < WORTH_SHARING;
        #[cfg(not(feature = "threads"))]
        true
    }

    /// Calls `work` with the number and the elements of each chunk of `size`; the last may be shorter.
    pub fn chunks<A: Send>(&self, data: &mut [A], size: usize, work: impl Fn(usize, &mut [A]) + Sync + Send) {
        #[cfg(feature = "threads")]
        if let Some(pool) = self.pool.as_ref().filter(|_| data.len() >= WORTH_SHARING) {
            use rayon::prelude::*;
            let together = (WORTH_SHARING / 8 / size).max(1);
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
        if let Some(pool) = self.pool.as_ref().filter(|_| a.len() >= WORTH_SHARING) {
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
        if let Some(pool) = self.pool.as_ref().filter(|_| a.len() >= WORTH_SHARING) {
            use rayon::prelude::*;
            let all = a.par_chunks_mut(size).zip(b.par_chunks_mut(size)).zip(c.par_chunks_mut(size));
            return pool.install(|| all.enumerate().for_each(|(k, ((a, b), c))| work(k, [a, b, c])));
        }
        let all = a.chunks_mut(size).zip(b.chunks_mut(size)).zip(c.chunks_mut(size));
        all.enumerate().for_each(|(k, ((a, b), c))| work(k, [a, b, c]));
    }
}
