//! The inputs of an evaluation.

use crate::body::BodyRef;
use crate::parallel::Executor;

/// A body in a simulation, and the executor of the evaluation.
#[derive(Clone, Debug)]
pub(super) struct Frame<'a> {
    pub(super) body: BodyRef<'a>,
    pub(super) executor: Executor,
}

impl<'a> Frame<'a> {
    pub(super) fn new(body: BodyRef<'a>) -> Self {
        let executor = body.context().map_or_else(Executor::sequential, |context| context.executor.clone());
        Self { body, executor }
    }
}
