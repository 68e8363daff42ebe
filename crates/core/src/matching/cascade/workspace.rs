//! The buffers of a cascade. Every use overwrites them.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::loose::Motion;
use super::plane::{Scratch, Sizes};
use super::transform::Purpose;
use crate::parallel::Executor;
use crate::simd::lanes::Lanes;

/// The buffers of a cascade. They are allocated at the first use, and grow for a larger cascade.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    /// Output of the adjoint y pass for each vertex.
    pub(super) adjoint_y: Lanes<6>,
    /// Scratch memory of each thread.
    scratch: Vec<Mutex<Scratch>>,
    /// Motions of loose cells.
    pub(super) loose: Vec<Motion>,
}

impl Workspace {
    /// Allocates missing buffers for `purpose` and `threads` threads.
    pub(super) fn reserve(&mut self, sizes: Sizes, purpose: Purpose, threads: usize) {
        if purpose == Purpose::Vertices {
            self.adjoint_y.grow(sizes.blocks);
        }
        if self.scratch.len() < threads {
            self.scratch.resize_with(threads, Mutex::default);
        }
        if self.loose.len() < sizes.loose {
            self.loose.resize_with(sizes.loose, Motion::default);
        }
        for scratch in &mut self.scratch {
            scratch.get_mut().unwrap_or_else(PoisonError::into_inner).grow(sizes);
        }
    }

    /// Returns the memory of the buffers, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let scratch = self.scratch.iter().map(|scratch| locked(scratch).bytes());
        self.adjoint_y.bytes() + scratch.sum::<usize>() + size_of_val(self.loose.as_slice())
    }

    /// Locks the scratch memory of the calling thread.
    pub(super) fn scratch(&self, executor: &Executor) -> MutexGuard<'_, Scratch> {
        locked(&self.scratch[executor.worker() % self.scratch.len()])
    }
}

/// The workspaces of the threads of a simulation, for the bodies whose steps run on one thread. So the bodies that a
/// thread steps one after the other use the same memory, which stays in its cache.
#[derive(Debug, Default)]
pub(crate) struct Workspaces(Vec<Mutex<Workspace>>);

impl Workspaces {
    /// Allocates missing buffers for `threads` threads and for cascades of the given sizes.
    pub(crate) fn reserve(&mut self, threads: usize, sizes: impl Iterator<Item = Sizes>) {
        let Some(sizes) = sizes.reduce(Sizes::max) else { return };
        if self.0.len() < threads {
            self.0.resize_with(threads, Mutex::default);
        }
        for workspace in &mut self.0 {
            let workspace = workspace.get_mut().unwrap_or_else(PoisonError::into_inner);
            workspace.reserve(sizes, Purpose::Vertices, 1);
        }
    }

    /// Locks the workspace of the calling thread.
    pub(crate) fn lock(&self, executor: &Executor) -> MutexGuard<'_, Workspace> {
        locked(&self.0[executor.worker() % self.0.len()])
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.0.iter().map(|workspace| locked(workspace).bytes()).sum()
    }
}

/// Locks buffers. Ignores poisoning, because every use overwrites the buffers.
fn locked<T>(buffers: &Mutex<T>) -> MutexGuard<'_, T> {
    buffers.lock().unwrap_or_else(PoisonError::into_inner)
}
