//! Options of the volume correction, and its errors.

use std::fmt;

/// Volume measure: a definition of a body's volume. Each measure is an exact cubic in the scale `lambda`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum VolumeMeasure {
    /// Sum over the lattice vertices of a volume from their six neighbors (Takamatsu & Kanai 2009). Cheap
    /// and approximate: the embedded surface keeps its volume to a few per cent.
    Lattice,
    /// Exact volume of the trilinear cells.
    Cells,
    /// Exact volume enclosed by the embedded surface.
    Mesh,
}

impl VolumeMeasure {
    /// Returns the name in scenes and reports: `lattice`, `cells` or `mesh`.
    pub fn name(self) -> &'static str {
        Preservation::By(self).name()
    }
}

impl fmt::Display for VolumeMeasure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Choice of volume preservation: off, or the measure whose value is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Preservation {
    /// No correction: the surface follows the dynamics. Uses no time and no memory.
    Off,
    /// `mesh` if the surface encloses a volume, else `cells`.
    #[default]
    Auto,
    /// Preservation of this measure.
    By(VolumeMeasure),
}

impl Preservation {
    /// Names in scenes and in Python.
    pub const NAMED: [(&'static str, Self); 5] = [
        ("auto", Self::Auto),
        ("off", Self::Off),
        ("lattice", Self::By(VolumeMeasure::Lattice)),
        ("cells", Self::By(VolumeMeasure::Cells)),
        ("mesh", Self::By(VolumeMeasure::Mesh)),
    ];

    /// Returns its name in [`Preservation::NAMED`].
    pub fn name(self) -> &'static str {
        name_of(self, &Self::NAMED)
    }
}

/// Returns the name of `value` in `named`, which lists all values.
fn name_of<T: PartialEq>(value: T, named: &[(&'static str, T)]) -> &'static str {
    named.iter().find(|(_, one)| *one == value).map_or("", |(name, _)| name)
}

/// Scope of the correction: where a body regains its volume.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum VolumeScope {
    /// Everywhere: one scale per lattice component (Takamatsu & Kanai 2009).
    #[default]
    Global,
    /// Where the volume was lost: one scale per lattice region, then one per component for the remainder.
    Regional,
}

impl VolumeScope {
    /// Names in scenes and in Python.
    pub const NAMED: [(&'static str, Self); 2] = [("global", Self::Global), ("regional", Self::Regional)];

    /// Returns its name in [`VolumeScope::NAMED`].
    pub fn name(self) -> &'static str {
        name_of(self, &Self::NAMED)
    }
}

/// Construction of the deformation field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum FieldKind {
    /// Field of Takamatsu & Kanai (2009). Boundary vertices have unit normals, computed from their existing
    /// neighbors. Interior vertices have the mean direction of the previous layer, with a length that
    /// decreases from 1 at the boundary to 0 at the center.
    Paper,
    /// Smoothest field that moves the boundary faces of the cells by 1 along their normals.
    Cells,
    /// Smoothest field that moves the surface mesh by 1 along its normals; it does not depend on the steps of
    /// the lattice boundary. A bare lattice uses `Cells`.
    #[default]
    Surface,
}

impl FieldKind {
    /// Names in scenes and in Python.
    pub const NAMED: [(&'static str, Self); 3] =
        [("surface", Self::Surface), ("cells", Self::Cells), ("paper", Self::Paper)];

    /// Returns its name in [`FieldKind::NAMED`].
    pub fn name(self) -> &'static str {
        name_of(self, &Self::NAMED)
    }
}

/// Options of the volume correction.
///
/// Exhaustive, so that users can write `VolumeOptions { scope, ..VolumeOptions::default() }`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct VolumeOptions {
    /// Measure whose value is kept, or off. Default: [`Preservation::Auto`].
    pub measure: Preservation,
    /// Scope of the correction. Default: [`VolumeScope::Global`].
    pub scope: VolumeScope,
    /// Field along which the correction moves the vertices. Default: [`FieldKind::Surface`].
    pub field: FieldKind,
    /// Cap on the scale `lambda`, as a fraction of the body's thickness (the greatest depth of a lattice
    /// vertex below the boundary). Finite, >= 0; at 0 no vertex moves. Default: 1.
    pub max_correction: f64,
}

impl Default for VolumeOptions {
    fn default() -> Self {
        Self {
            measure: Preservation::Auto,
            scope: VolumeScope::Global,
            field: FieldKind::default(),
            max_correction: 1.0,
        }
    }
}

impl VolumeOptions {
    /// Returns the options without correction.
    pub fn off() -> Self {
        Preservation::Off.into()
    }
}

impl From<Preservation> for VolumeOptions {
    fn from(measure: Preservation) -> Self {
        Self { measure, ..Self::default() }
    }
}

impl From<VolumeMeasure> for VolumeOptions {
    fn from(measure: VolumeMeasure) -> Self {
        Preservation::By(measure).into()
    }
}

/// Volume options that the body cannot satisfy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VolumeError {
    /// The measure is `mesh`, and the body has no mesh.
    #[error("volume measure `mesh` needs a surface mesh, and this body is a bare lattice: use `cells`")]
    NoMesh,
    /// The surface has holes, or faces of inconsistent orientation.
    #[error(
        "volume measure `mesh` needs a closed surface, and {open_edges} edges of this one are open or have \
         inconsistently oriented faces: use `cells`"
    )]
    Open {
        /// Number of edges whose directed uses do not cancel.
        open_edges: usize,
    },
    /// The surface of a component encloses less than 1 % of the volume of its cells.
    #[error(
        "volume measure `mesh`: the surface of lattice component {component} encloses {mesh:.3e}, less than \
         1 % of the volume {cells:.3e} of its cells: use `cells`"
    )]
    Flat {
        /// Index of the lattice component, from 0.
        component: usize,
        /// Volume enclosed by the surface, in cubed scene units.
        mesh: f64,
        /// Volume of the component's cells, in cubed scene units.
        cells: f64,
    },
    /// A connected component of the surface is embedded in more than one component of the lattice.
    #[error(
        "volume measure `mesh`: a connected part of the surface lies in several components of the lattice: \
         use `cells`"
    )]
    AcrossComponents,
    /// `max_correction` is out of range.
    #[error("max_correction is {0}; it must be finite and at least 0 (1 = the body's thickness)")]
    MaxCorrection(f64),
}
