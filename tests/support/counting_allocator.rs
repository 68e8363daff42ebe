//! The system's allocator, with counters. A test program that counts makes it the global allocator.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The system's allocator, with counters.
pub struct CountingAllocator;

/// Number of allocations of all threads, including those of the test runner.
static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    /// Number of allocations of this thread.
    static THREAD_ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
    /// Bytes that this thread has allocated less those that it has freed.
    static THREAD_BYTES: Cell<isize> = const { Cell::new(0) };
    /// Largest value of `THREAD_BYTES` since [`thread_peak`] was called.
    static THREAD_PEAK: Cell<isize> = const { Cell::new(0) };
}

#[allow(unsafe_code, reason = "the trait `GlobalAlloc` is unsafe")]
// SAFETY: all calls are passed on unchanged to the system's allocator.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        THREAD_ALLOCATIONS.set(THREAD_ALLOCATIONS.get() + 1);
        let bytes = THREAD_BYTES.get() + layout.size() as isize;
        THREAD_BYTES.set(bytes);
        THREAD_PEAK.set(THREAD_PEAK.get().max(bytes));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        THREAD_BYTES.set(THREAD_BYTES.get() - layout.size() as isize);
        unsafe { System.dealloc(pointer, layout) }
    }
}

/// Returns the number of allocations of all threads while `work` runs. The program must have only one test,
/// so that no other test allocates at the same time.
pub fn allocations(work: impl FnOnce()) -> usize {
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    work();
    ALLOCATIONS.load(Ordering::Relaxed) - before
}

/// Returns the number of allocations of this thread while `work` runs.
pub fn thread_allocations(work: impl FnOnce()) -> usize {
    let before = THREAD_ALLOCATIONS.get();
    work();
    THREAD_ALLOCATIONS.get() - before
}

/// Returns the bytes that this thread has allocated less those that it has freed.
pub fn thread_bytes() -> isize {
    THREAD_BYTES.get()
}

/// Returns the largest number of bytes that this thread has allocated beside its earlier ones while `work`
/// runs.
pub fn thread_peak(work: impl FnOnce()) -> isize {
    let before = THREAD_BYTES.get();
    THREAD_PEAK.set(before);
    work();
    THREAD_PEAK.get() - before
}
