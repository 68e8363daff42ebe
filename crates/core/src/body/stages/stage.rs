//! The trait of the stages.

use crate::body::context::StepContext;
use crate::body::snapshot::BodySnapshot;
use crate::body::soft_body::Body;
use crate::body::transfer::Parents;
use crate::contact::bodies::BodyContactPart;
use crate::error::StateError;
use crate::parallel::Executor;

/// The inputs of a stage.
pub(in crate::body) struct BodyStep<'a> {
    pub(in crate::body) context: &'a StepContext<'a>,
    /// The part of the body in the contacts between bodies. It is known from the contacts on.
    pub(in crate::body) part: &'a BodyContactPart<'a>,
    pub(in crate::body) executor: &'a Executor,
}

/// Returns an error if saved data are not those of a body.
pub(super) fn check_owner(body: &Body, what: &'static str, fits: bool) -> Result<(), StateError> {
    if fits { Ok(()) } else { Err(StateError::Vertices { body: body.name.clone(), what }) }
}

/// A stage of the step of a body. Its data are a field of [`Body`] or of one of its parts.
pub(in crate::body) trait Stage: Sync {
    /// Returns the name of the stage in the plan.
    fn name(&self) -> &'static str;

    /// Returns whether the plan lists the stage as left out if the body does not have it. Stages that only prepare a
    /// later stage are not listed.
    fn is_main(&self) -> bool {
        true
    }

    /// Returns whether a body has the stage. A missing stage takes no time and no memory.
    fn exists(&self, body: &Body) -> bool;

    /// Runs the stage.
    fn run(&self, body: &mut Body, step: &BodyStep<'_>);

    /// Returns the parameters of the stage, and its memory in bytes.
    fn describe(&self, body: &Body) -> (String, usize);

    /// Builds the data that depend on the lattice, the regions and the material, which are new or were changed.
    fn rebuild(&self, _body: &mut Body) {}

    /// Moves the data of lattice vertices to a lattice whose vertices were split, before [`rebuild`](Self::rebuild). The
    /// lattice, the masses, the regions and the state of the body are the new ones.
    fn follow(&self, _body: &mut Body, _parents: &Parents) {}

    /// Copies the data of the stage that steps change to a snapshot.
    fn save(&self, _body: &Body, _snapshot: &mut BodySnapshot) {}

    /// Checks that the data of a snapshot fit the body, which then has `vertices` lattice vertices.
    ///
    /// # Errors
    ///
    /// Data that do not fit.
    fn check(&self, _body: &Body, _snapshot: &BodySnapshot, _vertices: usize) -> Result<(), StateError> {
        Ok(())
    }

    /// Restores the data of a snapshot that passed [`check`](Self::check). The lattice, the settings and the state of
    /// the body are restored before.
    fn restore(&self, _body: &mut Body, _snapshot: &BodySnapshot) {}
}
