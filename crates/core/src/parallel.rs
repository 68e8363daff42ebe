//! Threads and chunks: the only place that starts threads.
//!
//! Work on a body is cut into chunks of a fixed number of blocks, whatever the number of threads; each output
//! value is computed by one thread in one order. So the bits of a result do not depend on the threads.

use std::sync::Arc;
#[cfg(feature = "rayon")]
use std::sync::{Mutex, PoisonError};

/// Blocks in a task: 4,096 lattice vertices. A smaller body is one task, since joins cost more than its work.
pub(crate) const CHUNK: usize = 512;

/// Where work runs: on the calling thread, or on a pool of threads. Cloning shares the pool.
#[derive(Clone, Debug, Default)]
pub struct Executor {
    #[cfg(feature = "rayon")]
    pool: Option<Arc<rayon::ThreadPool>>,
    #[cfg(not(feature = "rayon"))]
    _pool: std::marker::PhantomData<Arc<()>>,
}

impl Executor {
    /// The calling thread alone.
    pub fn sequential() -> Self {
        Self::default()
    }

    /// `threads` threads; 0 = one for each processor. Without the feature `rayon`, or where the system gives
    /// no threads, the calling thread alone.
    #[cfg(feature = "rayon")]
    pub fn new(threads: usize) -> Self {
        let threads =
            if threads == 0 { std::thread::available_parallelism().map_or(1, |n| n.get()) } else { threads };
        let pool = (threads > 1)
            .then(|| rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok())
            .flatten();
        Self { pool: pool.map(Arc::new) }
    }

    /// The calling thread: the feature `rayon` is off.
    #[cfg(not(feature = "rayon"))]
    pub fn new(_threads: usize) -> Self {
        Self::sequential()
    }

    /// Leaves the pool as it is, and works on the calling thread: its threads are not there any more, and to wait
    /// for them would hang.
    pub(crate) fn abandon(&mut self) {
        #[cfg(feature = "rayon")]
        std::mem::forget(self.pool.take());
    }

    /// Threads that work.
    pub fn threads(&self) -> usize {
        #[cfg(feature = "rayon")]
        if let Some(pool) = &self.pool {
            return pool.current_num_threads();
        }
        1
    }

    /// Runs `work` where its chunks can be shared out; once for many steps, since entering a pool has a price.
    pub(crate) fn enter<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        #[cfg(feature = "rayon")]
        if let Some(pool) = &self.pool {
            return pool.install(work);
        }
        work()
    }

    /// `work(item)` for each item, in parallel.
    pub(crate) fn each<T: Send>(&self, items: &mut [T], work: impl Fn(&mut T) + Send + Sync) {
        #[cfg(feature = "rayon")]
        if self.pool.is_some() && items.len() > 1 {
            use rayon::prelude::*;
            return items.par_iter_mut().for_each(work);
        }
        items.iter_mut().for_each(work);
    }

    /// The number of the thread that works, below [`Executor::threads`].
    pub(crate) fn worker(&self) -> usize {
        #[cfg(feature = "rayon")]
        if let Some(pool) = &self.pool {
            return pool.current_thread_index().unwrap_or(0);
        }
        0
    }

    /// `work(item)` for each item, on the calling thread, and on threads of the pool as they become free. Faster than
    /// entering the pool where the work is short.
    pub fn share<T>(&self, items: impl ExactSizeIterator<Item = T> + Send, work: impl Fn(T) + Sync) {
        #[cfg(feature = "rayon")]
        if let Some(pool) = &self.pool
            && items.len() > 1
        {
            let helpers = pool.current_num_threads().min(items.len()) - 1;
            let items = Mutex::new(items);
            let next = || items.lock().unwrap_or_else(PoisonError::into_inner).next();
            let help = || {
                while let Some(item) = next() {
                    work(item);
                }
            };
            return pool.in_place_scope(|scope| {
                (0..helpers).for_each(|_| scope.spawn(|_| help()));
                help();
            });
        }
        items.for_each(work);
    }

    /// `work(task, a, b, c)` for tasks that own parts of arrays: of `a` and `b` the items from `bounds[task]` to
    /// `bounds[task + 1]`, of `c` equally many each. An empty array stands for no array.
    pub(crate) fn tasks<A: Send, B: Send, C: Send>(
        &self,
        bounds: &[usize],
        parts: (&mut [A], &mut [B], &mut [C]),
        work: impl Fn(usize, &mut [A], &mut [B], &mut [C]) + Sync,
    ) {
        #[cfg(feature = "rayon")]
        if self.pool.is_some() && bounds.len() > 2 {
            return self.enter(|| halve(0, bounds, parts, &work));
        }
        let (mut a, mut b, mut c) = parts;
        let each = c.len() / bounds.len().saturating_sub(1).max(1);
        for (task, ends) in bounds.windows(2).enumerate() {
            let items = ends[1] - ends[0];
            let (of_a, of_b) = (take(&mut a, items), take(&mut b, items));
            work(task, of_a, of_b, take(&mut c, each));
        }
    }

    /// `work(first, a, b, c)` for chunks of three arrays of equal length, `first` the index of a chunk's first items.
    pub(crate) fn chunks3<A: Send, B: Send, C: Send>(
        &self,
        (a, b, c): (&mut [A], &mut [B], &mut [C]),
        work: impl Fn(usize, &mut [A], &mut [B], &mut [C]) + Send + Sync,
    ) {
        debug_assert!(a.len() == b.len() && a.len() == c.len());
        #[cfg(feature = "rayon")]
        if self.pool.is_some() && a.len() > CHUNK {
            use rayon::prelude::*;
            let chunks = a.par_chunks_mut(CHUNK).zip(b.par_chunks_mut(CHUNK)).zip(c.par_chunks_mut(CHUNK));
            return chunks.enumerate().for_each(|(k, ((a, b), c))| work(k * CHUNK, a, b, c));
        }
        let chunks = a.chunks_mut(CHUNK).zip(b.chunks_mut(CHUNK)).zip(c.chunks_mut(CHUNK));
        chunks.enumerate().for_each(|(k, ((a, b), c))| work(k * CHUNK, a, b, c));
    }
}

/// Cuts the first items off, as many as there are.
fn take<'a, T>(items: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let count = count.min(items.len());
    items.split_off_mut(..count).unwrap_or_default()
}

#[cfg(feature = "rayon")]
type Parts<'a, A, B, C> = (&'a mut [A], &'a mut [B], &'a mut [C]);

/// Does the tasks from `task` on, of which `bounds` are the bounds, one half beside the other.
#[cfg(feature = "rayon")]
fn halve<A: Send, B: Send, C: Send>(
    task: usize,
    bounds: &[usize],
    (mut a, mut b, mut c): Parts<A, B, C>,
    work: &(impl Fn(usize, &mut [A], &mut [B], &mut [C]) + Sync),
) {
    let tasks = bounds.len() - 1;
    if tasks <= 1 {
        return if tasks == 1 {
            work(task, a, b, c)
        };
    }
    let half = tasks / 2;
    let (items, each) = (bounds[half] - bounds[0], c.len() / tasks);
    let first = (take(&mut a, items), take(&mut b, items), take(&mut c, each * half));
    rayon::join(
        || halve(task, &bounds[..=half], first, work),
        || halve(task + half, &bounds[half..], (a, b, c), work),
    );
}
