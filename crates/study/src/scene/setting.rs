//! Defines the varied parameters of a point and their names.

use serde::{Deserialize, Serialize};
use supple::reference::Regions;
use supple::{HalfWidth, Preservation, VolumeScope};

/// Method of volume preservation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Method {
    /// Whether the volume is preserved, and by which measure.
    pub measure: Preservation,
    /// Scope of the correction.
    pub scope: VolumeScope,
}

impl Method {
    /// Returns the name, e.g. `off` or `mesh global`.
    pub(super) fn name(self) -> String {
        match self.measure {
            Preservation::Off => "off".to_owned(),
            measure => format!("{} {}", measure.name(), self.scope.name()),
        }
    }

    /// Returns the method without a correction.
    pub(super) fn off() -> Self {
        Self { measure: Preservation::Off, scope: VolumeScope::Global }
    }

    /// Returns all methods: off, and each measure with each scope.
    pub(super) fn all() -> Vec<Self> {
        let measures = Preservation::NAMED.iter().map(|&(_, measure)| measure);
        let measures = measures.filter(|measure| matches!(measure, Preservation::By(_)));
        let scopes = VolumeScope::NAMED.map(|(_, scope)| scope);
        let corrected = measures.flat_map(|measure| scopes.map(|scope| Self { measure, scope }));
        std::iter::once(Self::off()).chain(corrected).collect()
    }
}

/// Summation of the goal positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sums {
    /// The sums of the library: window sums in f32 over staircase regions.
    Fast,
    /// Explicit sums in f64 over regions of the given kind.
    Naive(Regions),
}

impl Sums {
    /// Returns the name in tables.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Naive(Regions::Staircase) => "naive",
            Self::Naive(Regions::BreadthFirst) => "breadth-first",
        }
    }
}

/// The parameters of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Setting {
    /// Parameters that affect the motion of the lattice.
    pub dynamics: Dynamics,
    /// Volume preservation.
    pub method: Method,
}

/// The parameters that affect the motion of the lattice. Volume preservation does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Dynamics {
    /// Number of cells per length, relative to the scene. The regions keep their radius, so half-widths in
    /// cells grow in proportion.
    pub refinement: f64,
    /// Radius of the regions relative to the scene; a value other than 1 is another material.
    pub region_factor: f64,
    /// Half-width of the regions in place of that of the scene, with the same Young's modulus: the same material.
    pub half_width: Option<HalfWidth>,
    /// Steps per frame, at least 1.
    pub substeps: u32,
    /// Summation of the goal positions.
    pub sums: Sums,
}

/// The parameter in which a point differs from the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// The unchanged scene.
    Base,
    /// A finer or coarser lattice, or another method of volume preservation.
    Resolution,
    /// More or fewer steps per frame.
    Substeps,
    /// Wider or narrower regions on the same lattice: another material.
    HalfWidth,
    /// The same material by regions of another half-width, in the steps that it then needs.
    Regions,
    /// Naive sums over staircase or breadth-first regions.
    Sums,
}

impl Axis {
    /// Returns the name in files.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Base => "base",
            Self::Resolution => "resolution",
            Self::Substeps => "substeps",
            Self::HalfWidth => "half-width",
            Self::Regions => "regions",
            Self::Sums => "sums",
        }
    }
}
