//! The translations by which components leave colliders in which they began.

use nalgebra::Vector3;

/// Length in cells of a step out of a collider, unless the translation would take more than [`MAX_STEPS`].
const STEP: f64 = 0.25;

/// Greatest number of steps out of a collider.
const MAX_STEPS: f64 = 64.0;

/// The escape of one component. The component does not move otherwise until it has left the colliders.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Escape {
    /// Index of the connected component.
    pub(crate) component: u32,
    /// Number of steps that remain, at least 1.
    steps: u32,
    /// Translation of a step, in cells.
    pub(crate) translation: [f64; 3],
}

/// The escapes of all components that are leaving colliders.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Escapes {
    /// Whether the next step looks for components inside colliders.
    pub(crate) searches: bool,
    list: Vec<Escape>,
}

impl Default for Escapes {
    fn default() -> Self {
        Self { searches: true, list: Vec::new() }
    }
}

impl Escapes {
    pub(crate) fn list(&self) -> &[Escape] {
        &self.list
    }

    /// Returns the escape of a component, if it is leaving colliders.
    pub(crate) fn of(&self, component: u32) -> Option<&Escape> {
        self.list.iter().find(|escape| escape.component == component)
    }

    /// Lets the next step look for components inside colliders. Called when positions or colliders were set.
    pub(crate) fn search(&mut self) {
        self.searches = true;
        self.list.clear();
    }

    /// Adds a component that leaves colliders by `translation`, in cells.
    pub(crate) fn add(&mut self, component: u32, translation: Vector3<f64>) {
        let steps = (translation.norm() / STEP).ceil().clamp(1.0, MAX_STEPS);
        self.list.push(Escape { component, steps: steps as u32, translation: (translation / steps).into() });
    }

    /// Removes the components that do not satisfy a condition.
    pub(crate) fn retain(&mut self, condition: impl Fn(&Escape) -> bool) {
        self.list.retain(condition);
    }

    /// Counts a step. The step after the end of an escape looks for colliders again, because they may have moved.
    pub(crate) fn advance(&mut self) {
        for escape in &mut self.list {
            escape.steps -= 1;
        }
        let count = self.list.len();
        self.list.retain(|escape| escape.steps > 0);
        self.searches |= self.list.len() < count;
    }

    /// Checks deserialized data of a body with this number of components.
    pub(super) fn is_valid(&self, components: usize) -> bool {
        self.list.iter().all(|escape| {
            (escape.component as usize) < components
                && escape.steps > 0
                && escape.translation.iter().all(|x| x.is_finite())
        })
    }
}
