//! Sums of cubics over many terms, of a shape that does not depend on the threads.

use std::ops::Range;

use crate::parallel::Executor;

/// Terms in a chunk, where a term is a determinant. Fixed, so that the order of the additions is fixed.
pub(super) const DETERMINANTS: usize = 2048;

/// Terms sorted by component, cut into chunks: the terms of a chunk are summed in order, then the chunks in order.
#[derive(Clone, Debug)]
pub(super) struct ChunkedSum {
    chunks: Vec<Chunk>,
}

#[derive(Clone, Debug)]
struct Chunk {
    terms: Range<usize>,
    component: usize,
}

impl ChunkedSum {
    /// `counts[c]` terms of component `c`, one component after the other; `size` terms in a chunk.
    pub(super) fn new(counts: &[usize], size: usize) -> Self {
        Self { chunks: Vec::new() }.then(counts, size)
    }

    /// The same and more terms behind them, again one component after the other.
    pub(super) fn then(mut self, counts: &[usize], size: usize) -> Self {
        let mut first = self.chunks.last().map_or(0, |chunk| chunk.terms.end);
        for (component, count) in counts.iter().enumerate() {
            let end = first + count;
            while first < end {
                let next = end.min(first + size);
                self.chunks.push(Chunk { terms: first..next, component });
                first = next;
            }
        }
        self
    }

    /// Adds `factor` times the sum of the terms of each component to `out` (one per component). `sums` is scratch.
    pub(super) fn add_to(
        &self,
        executor: &Executor,
        factor: f64,
        sums: &mut Vec<[f64; 4]>,
        out: &mut [[f64; 4]],
        terms: impl Fn(Range<usize>) -> [f64; 4] + Sync,
    ) {
        sums.resize(self.chunks.len(), [0.0; 4]);
        executor.share(self.chunks.iter().zip(&mut *sums), |(chunk, sum)| *sum = terms(chunk.terms.clone()));
        for (chunk, terms) in self.chunks.iter().zip(sums) {
            for (sum, term) in out[chunk.component].iter_mut().zip(terms) {
                *sum += factor * *term;
            }
        }
    }
}

/// Sorts `items` by the component that each belongs to, keeping their order within it; returns how many each has.
pub(super) fn group_by_component<T>(
    items: &mut [T],
    components: usize,
    component: impl Fn(&T) -> u32,
) -> Vec<usize> {
    let mut counts = vec![0; components];
    for item in items.iter() {
        counts[component(item) as usize] += 1;
    }
    if components > 1 {
        items.sort_by_key(component);
    }
    counts
}
