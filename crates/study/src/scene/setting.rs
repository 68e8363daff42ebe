//! One point of the matrix: what is varied, and what it is called.

use serde::{Deserialize, Serialize};
use supple::reference::Regions;
use supple::{Preservation, VolumeScope};

/// How the volume is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Method {
    /// Whether, and by which measure.
    pub measure: Preservation,
    /// Where it is given back.
    pub scope: VolumeScope,
}

impl Method {
    /// As scenes have it: `off`, `mesh global`.
    pub(super) fn name(self) -> String {
        match self.measure {
            Preservation::Off => "off".to_owned(),
            measure => format!("{} {}", measure.name(), self.scope.name()),
        }
    }

    /// No correction.
    pub(super) fn off() -> Self {
        Self { measure: Preservation::Off, scope: VolumeScope::Global }
    }

    /// All of them: off, and each measure with each scope.
    pub(super) fn all() -> Vec<Self> {
        let kept = Preservation::NAMED.iter().map(|&(_, measure)| measure);
        let kept = kept.filter(|measure| matches!(measure, Preservation::By(_)));
        let scopes = VolumeScope::NAMED.map(|(_, scope)| scope);
        let both = kept.flat_map(|measure| scopes.map(|scope| Self { measure, scope }));
        std::iter::once(Self::off()).chain(both).collect()
    }
}

/// How the goal positions are summed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sums {
    /// As the core does: window sums in f32 over staircase regions.
    Fast,
    /// Explicit sums in f64, over regions of either kind.
    Naive(Regions),
}

impl Sums {
    /// What it is called in tables.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Naive(Regions::Staircase) => "naive",
            Self::Naive(Regions::BreadthFirst) => "breadth-first",
        }
    }
}

/// One point of the matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Setting {
    /// Dynamics, which points that differ in the method alone share.
    pub dynamics: Dynamics,
    /// How the volume is kept.
    pub method: Method,
}

/// What of a setting changes the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Dynamics {
    /// Cells per length, over those of the scene: the regions keep their radius, so that half-widths grow with it.
    pub refinement: f64,
    /// Radius of the regions over that of the scene: another one than 1 is another material.
    pub region_factor: f64,
    /// Steps a frame, at least 1.
    pub substeps: u32,
    /// How the goal positions are summed.
    pub sums: Sums,
}

/// Which axis of the matrix a point is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// The scene as it is.
    Base,
    /// Finer or coarser lattices, with every method.
    Resolution,
    /// More or fewer steps.
    Substeps,
    /// Wider or narrower regions on the same lattice: another material.
    HalfWidth,
    /// The naive sums, and the regions of another kind.
    Sums,
}

impl Axis {
    /// Its name in files.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Base => "base",
            Self::Resolution => "resolution",
            Self::Substeps => "substeps",
            Self::HalfWidth => "half-width",
            Self::Sums => "sums",
        }
    }
}
