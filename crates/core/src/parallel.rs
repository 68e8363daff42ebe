//! Runs work on threads. No other module starts threads.
//!
//! Work is divided into tasks: ranges of blocks, which are eight lattice vertices each (see `simd::lanes`).
//! The division does not depend on the number of threads, and one thread computes each output value in a
//! fixed order. Results are therefore bit-identical for any number of threads.
//!
//! All executors of a process with the same number of threads share one pool. It ends with the last of them.

use std::sync::Arc;
#[cfg(feature = "rayon")]
use std::sync::{Mutex, PoisonError, TryLockError, Weak};

/// Number of blocks in a chunk: 4,096 lattice vertices. A body of one chunk is one task, because joining threads takes
/// longer than its work.
const CHUNK: usize = 512;

/// Least number of blocks in a task of the window sums of a larger body. Tasks are small, so that the last of them keeps no
/// thread waiting for long.
pub(crate) const LEAST_TASK: usize = 256;

/// Returns whether a body with this number of blocks is one task.
pub(crate) fn is_one_task(blocks: usize) -> bool {
    blocks <= CHUNK
}

/// Number of attempts to lock the list of pools, a millisecond apart.
#[cfg(feature = "rayon")]
const LOCK_ATTEMPTS: u32 = 200;

/// The pools in use, with the process that started each and its number of threads.
#[cfg(feature = "rayon")]
static POOLS: Mutex<Vec<(u32, usize, Weak<rayon::ThreadPool>)>> = Mutex::new(Vec::new());

/// Runs work on the calling thread or on a pool of threads, which executors with the same number of threads share.
#[derive(Clone, Debug, Default)]
pub struct Executor {
    #[cfg(feature = "rayon")]
    pool: Option<Arc<rayon::ThreadPool>>,
    #[cfg(not(feature = "rayon"))]
    _pool: std::marker::PhantomData<Arc<()>>,
}

impl Executor {
    /// Creates an executor that uses the calling thread only.
    pub fn sequential() -> Self {
        Self::default()
    }

    /// Creates an executor with `threads` threads; 0 = one per processor. Without the feature `rayon`, or if
    /// the system cannot start threads, it uses the calling thread only.
    #[cfg(feature = "rayon")]
    pub fn new(threads: usize) -> Self {
        let threads =
            if threads == 0 { std::thread::available_parallelism().map_or(1, |n| n.get()) } else { threads };
        Self { pool: (threads > 1).then(|| shared_pool(threads)).flatten() }
    }

    /// Creates an executor that uses the calling thread only: the feature `rayon` is off.
    #[cfg(not(feature = "rayon"))]
    pub fn new(_threads: usize) -> Self {
        Self::sequential()
    }

    /// Leaks the pool and switches to the calling thread. After a fork the pool's threads do not exist, and
    /// dropping the pool would wait for them forever.
    pub(crate) fn abandon(&mut self) {
        #[cfg(feature = "rayon")]
        std::mem::forget(self.pool.take());
    }

    /// Returns the number of threads.
    pub fn threads(&self) -> usize {
        #[cfg(feature = "rayon")]
        if let Some(pool) = &self.pool {
            return pool.current_num_threads();
        }
        1
    }

    /// Runs `work` inside the pool. Call this function once for many steps, because entering a pool is slow.
    pub(crate) fn enter<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        #[cfg(feature = "rayon")]
        if let Some(pool) = &self.pool {
            return pool.install(work);
        }
        work()
    }

    /// Calls `work(item)` for each item, in parallel.
    pub(crate) fn for_each_mut<T: Send>(&self, items: &mut [T], work: impl Fn(&mut T) + Send + Sync) {
        #[cfg(feature = "rayon")]
        if self.pool.is_some() && items.len() > 1 {
            use rayon::prelude::*;
            return items.par_iter_mut().for_each(work);
        }
        items.iter_mut().for_each(work);
    }

    /// Calls `work(index, item)` for each item, in parallel.
    pub(crate) fn for_each_indexed<T: Send>(
        &self,
        items: &mut [T],
        work: impl Fn(u32, &mut T) + Send + Sync,
    ) {
        #[cfg(feature = "rayon")]
        if self.pool.is_some() && items.len() > 1 {
            use rayon::prelude::*;
            return items.par_iter_mut().enumerate().for_each(|(index, item)| work(index as u32, item));
        }
        (0..).zip(items).for_each(|(index, item)| work(index, item));
    }

    /// Returns the index of the current thread, less than [`Executor::threads`].
    pub(crate) fn worker(&self) -> usize {
        #[cfg(feature = "rayon")]
        if let Some(pool) = &self.pool {
            return pool.current_thread_index().unwrap_or(0);
        }
        0
    }

    /// Calls `work(item)` for each item, on the calling thread and on pool threads as they become free. For
    /// short work this is faster than entering the pool.
    pub fn for_each<T>(&self, items: impl ExactSizeIterator<Item = T> + Send, work: impl Fn(T) + Sync) {
        #[cfg(feature = "rayon")]
        if let Some(pool) = &self.pool
            && items.len() > 1
        {
            let helpers = pool.current_num_threads().min(items.len()) - 1;
            let items = Mutex::new(items);
            let next = || items.lock().unwrap_or_else(PoisonError::into_inner).next();
            let drain = || {
                while let Some(item) = next() {
                    work(item);
                }
            };
            return pool.in_place_scope(|scope| {
                (0..helpers).for_each(|_| scope.spawn(|_| drain()));
                drain();
            });
        }
        items.for_each(work);
    }

    /// Calls `work(task, a, b, c)` for tasks that own slices of three arrays. Task `task` owns the items
    /// `offsets[task]` to `offsets[task + 1]` of the first two arrays, each of which may also be a pair of arrays. The
    /// third array is divided equally among the tasks. An array that is not needed is empty.
    pub(crate) fn tasks<A: Split, B: Split, C: Send>(
        &self,
        offsets: &[usize],
        arrays: (A, B, &mut [C]),
        work: impl Fn(usize, A, B, &mut [C]) + Sync,
    ) {
        #[cfg(feature = "rayon")]
        if self.pool.is_some() && offsets.len() > 2 {
            return self.enter(|| run_tasks(0, offsets, arrays, &work));
        }
        let (mut a, mut b, mut c) = arrays;
        let c_items = c.len() / offsets.len().saturating_sub(1).max(1);
        for (task, ends) in offsets.windows(2).enumerate() {
            let items = ends[1] - ends[0];
            let (task_a, task_b) = (a.take_front(items), b.take_front(items));
            work(task, task_a, task_b, take_front(&mut c, c_items));
        }
    }

    /// Calls `work(first, a, b, c)` for each chunk of three arrays of equal length. `first` is the index of
    /// the first item of the chunk.
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

/// Returns the pool of this process with `threads` threads. Starts it if there is none; `None` if that fails.
#[cfg(feature = "rayon")]
fn shared_pool(threads: usize) -> Option<Arc<rayon::ThreadPool>> {
    let start = || rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok().map(Arc::new);
    // A thread that held the lock during a fork does not exist in the child process, which must not wait for it.
    let mut pools = (0..LOCK_ATTEMPTS).find_map(|attempt| match POOLS.try_lock() {
        Ok(pools) => Some(pools),
        Err(TryLockError::Poisoned(poisoned)) => Some(poisoned.into_inner()),
        Err(TryLockError::WouldBlock) => {
            std::thread::sleep(std::time::Duration::from_millis(u64::from(attempt > 0)));
            None
        }
    });
    let Some(pools) = &mut pools else { return start() };
    // The threads of a pool that another process started do not exist in this one.
    let process = std::process::id();
    pools.retain(|(owner, _, pool)| *owner == process && pool.strong_count() > 0);
    let running =
        pools.iter().filter(|(_, size, _)| *size == threads).find_map(|(_, _, pool)| pool.upgrade());
    running.or_else(|| {
        let pool = start()?;
        pools.push((process, threads, Arc::downgrade(&pool)));
        Some(pool)
    })
}

/// Splits off the first `count` items, or all if there are fewer.
fn take_front<'a, T>(items: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let count = count.min(items.len());
    items.split_off_mut(..count).unwrap_or_default()
}

/// Arrays of equal length that can be divided: a slice, a pair of such arrays, or `()`, which stands for no array. A
/// slice that is not needed is empty.
pub(crate) trait Split: Send + Sized {
    /// Splits off the first `count` items, or all if there are fewer.
    #[must_use]
    fn take_front(&mut self, count: usize) -> Self;
}

impl Split for () {
    #[inline(always)]
    fn take_front(&mut self, _: usize) -> Self {}
}

impl<T: Send> Split for &mut [T] {
    #[inline(always)]
    fn take_front(&mut self, count: usize) -> Self {
        take_front(self, count)
    }
}

impl<A: Split, B: Split> Split for (A, B) {
    #[inline(always)]
    fn take_front(&mut self, count: usize) -> Self {
        (self.0.take_front(count), self.1.take_front(count))
    }
}

/// Runs the tasks of [`Executor::tasks`] with the item offsets `offsets`, numbered from `task`. Splits them
/// recursively into two halves that run in parallel.
#[cfg(feature = "rayon")]
fn run_tasks<A: Split, B: Split, C: Send>(
    task: usize,
    offsets: &[usize],
    (mut a, mut b, mut c): (A, B, &mut [C]),
    work: &(impl Fn(usize, A, B, &mut [C]) + Sync),
) {
    let tasks = offsets.len() - 1;
    if tasks <= 1 {
        return if tasks == 1 {
            work(task, a, b, c)
        };
    }
    let half = tasks / 2;
    let (items, c_items) = (offsets[half] - offsets[0], c.len() / tasks);
    let first = (a.take_front(items), b.take_front(items), take_front(&mut c, c_items * half));
    rayon::join(
        || run_tasks(task, &offsets[..=half], first, work),
        || run_tasks(task + half, &offsets[half..], (a, b, c), work),
    );
}

#[cfg(all(test, feature = "rayon"))]
mod tests {
    use super::*;

    #[test]
    fn executors_with_the_same_number_of_threads_share_a_pool_while_one_of_them_exists() {
        let pool = |executor: &Executor| Arc::downgrade(executor.pool.as_ref().expect("it has threads"));
        // No other test of this crate uses as many threads.
        let (first, second, other) = (Executor::new(13), Executor::new(13), Executor::new(14));
        let shared = pool(&first);
        assert!(shared.ptr_eq(&pool(&second)) && !shared.ptr_eq(&pool(&other)));
        drop(first);
        assert!(shared.ptr_eq(&pool(&Executor::new(13))));
        drop(second);
        assert!(shared.upgrade().is_none());
        assert_eq!(Executor::new(13).threads(), 13);
    }

    #[test]
    fn work_of_one_executor_inside_the_work_of_another_ends() {
        let (outer, inner) = (Executor::new(2), Executor::new(2));
        let mut sums = vec![0; 64];
        outer.for_each_mut(&mut sums, |sum| {
            let total = std::sync::atomic::AtomicUsize::new(0);
            inner.for_each(0..100, |k| {
                total.fetch_add(k, std::sync::atomic::Ordering::Relaxed);
            });
            *sum = total.into_inner();
        });
        assert!(sums.iter().all(|&sum| sum == 4950));
    }
}
