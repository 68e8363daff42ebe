//! All cases, on several threads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use super::{Case, Effort, Outcome};

/// One case that has been run.
#[derive(Clone, Debug)]
pub struct Ran {
    /// What came out.
    pub outcome: Outcome,
    /// How long it took on one thread.
    pub elapsed: Duration,
}

/// Runs cases on `threads` threads, each simulation on one of them, long cases first. `told` hears of each case that is
/// done, by its index, and says whether to go on. Returns what was run, one entry per case.
pub fn run_all(
    cases: &[Case],
    threads: usize,
    told: impl Fn(usize, &Ran) -> bool + Sync,
) -> Vec<Option<Ran>> {
    let mut order: Vec<usize> = (0..cases.len()).collect();
    order.sort_by_key(|&index| cases[index].effort == Effort::Quick);
    let (next, results) = (AtomicUsize::new(0), Mutex::new(vec![None; cases.len()]));
    std::thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(|| {
                while let Some(&index) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let start = Instant::now();
                    let ran = Ran { outcome: cases[index].run(), elapsed: start.elapsed() };
                    if !told(index, &ran) {
                        next.store(cases.len(), Ordering::Relaxed);
                    }
                    if let Ok(mut results) = results.lock() {
                        results[index] = Some(ran);
                    }
                }
            });
        }
    });
    results.into_inner().unwrap_or_default()
}
