//! Options of the volume correction, and its errors.

use std::fmt;

use crate::range::Range;

/// Volume measure: a definition of a body's volume.
///
/// By each measure the volume is an exact cubic in the scale `lambda` of the correction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum VolumeMeasure {
    /// Sum over the lattice vertices of a volume that is computed from the six neighbors of the vertex
    /// (Takamatsu & Kanai 2009). Cheap and approximate: the embedded surface keeps its volume to a few per
    /// cent.
    Lattice,
    /// Exact volume of the lattice cells, deformed by trilinear interpolation.
    Cells,
    /// Exact volume enclosed by the embedded surface.
    Mesh,
}

impl VolumeMeasure {
    /// Returns the name of the measure in scenes and reports: `lattice`, `cells` or `mesh`.
    pub fn name(self) -> &'static str {
        Preservation::By(self).name()
    }
}

impl fmt::Display for VolumeMeasure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Choice of volume preservation: off, or the measure by which the volume is preserved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Preservation {
    /// No correction: the displayed surface follows the uncorrected lattice. Uses no time and no memory.
    Off,
    /// `mesh` if this measure can use the surface, else `cells`. [`VolumeError`] lists the surfaces that
    /// `mesh` cannot use.
    #[default]
    Auto,
    /// Preservation of this measure.
    By(VolumeMeasure),
}

impl Preservation {
    /// All values, with their names in scenes and in Python.
    pub const NAMED: [(&'static str, Self); 5] = [
        ("auto", Self::Auto),
        ("off", Self::Off),
        ("lattice", Self::By(VolumeMeasure::Lattice)),
        ("cells", Self::By(VolumeMeasure::Cells)),
        ("mesh", Self::By(VolumeMeasure::Mesh)),
    ];

    /// Returns the name of the value in [`Preservation::NAMED`].
    pub fn name(self) -> &'static str {
        name_of(self, &Self::NAMED)
    }
}

/// Returns the name of `value` in `named`, which lists all values.
fn name_of<T: PartialEq>(value: T, named: &[(&'static str, T)]) -> &'static str {
    named.iter().find(|(_, candidate)| *candidate == value).map_or("", |(name, _)| name)
}

/// Scope of the correction: where a body regains its volume.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum VolumeScope {
    /// Everywhere: one scale for each connected component of the lattice (Takamatsu & Kanai 2009).
    #[default]
    Global,
    /// Where the volume was lost: first a scale for each vertex, from the volume loss of the regions around
    /// the vertex; then one scale for each component, for the remaining error.
    Regional,
}

impl VolumeScope {
    /// All values, with their names in scenes and in Python.
    pub const NAMED: [(&'static str, Self); 2] = [("global", Self::Global), ("regional", Self::Regional)];

    /// Returns the name of the value in [`VolumeScope::NAMED`].
    pub fn name(self) -> &'static str {
        name_of(self, &Self::NAMED)
    }
}

/// Construction of the deformation field: the direction in which each lattice vertex is moved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum FieldKind {
    /// Field of Takamatsu & Kanai (2009). The vector of a boundary vertex is a unit normal, computed from the
    /// existing neighbors of the vertex. The vector of an interior vertex has the mean direction of its
    /// neighbors in the next layer towards the boundary. Its length decreases from 1 at the boundary to 0 at
    /// the center.
    Paper,
    /// Smoothest field that moves the boundary faces of the cells by 1 along their normals.
    Cells,
    /// Smoothest field that moves the surface mesh by 1 along its normals. It does not depend on the
    /// staircase shape of the lattice boundary. A bare lattice uses `Cells`.
    Surface,
    /// `Surface`, but `Cells` in components of the lattice in which the surface is a sheet, unless the volume is
    /// preserved by the measure `mesh`. A motion of a sheet along its normals leaves the volume of its cells nearly
    /// as it is.
    #[default]
    Auto,
}

impl FieldKind {
    /// All values, with their names in scenes and in Python.
    pub const NAMED: [(&'static str, Self); 4] =
        [("auto", Self::Auto), ("surface", Self::Surface), ("cells", Self::Cells), ("paper", Self::Paper)];

    /// Returns the name of the value in [`FieldKind::NAMED`].
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
    /// Measure by which the volume is preserved, or off. Default: [`Preservation::Auto`].
    pub measure: Preservation,
    /// Scope of the correction. Default: [`VolumeScope::Global`].
    pub scope: VolumeScope,
    /// Field along which the correction moves the lattice vertices. Default: [`FieldKind::Auto`].
    pub field: FieldKind,
    /// Cap: greatest magnitude of the scale `lambda`, as a fraction of the thickness. The thickness of a
    /// component of the lattice is the greatest depth of its vertices below its boundary. Where no scale within
    /// the cap preserves the volume, the correction moves the vertices in several passes with scales of at most
    /// half of the thickness; with a cap below 1 the sum of their magnitudes is at most the cap. Finite, >= 0;
    /// at 0 no vertex moves. Default: 1.
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
    /// Returns options that turn the correction off.
    pub fn off() -> Self {
        Preservation::Off.into()
    }

    /// Checks the range of the cap.
    pub(crate) fn validate(&self) -> Result<(), VolumeError> {
        match Range::NOT_NEGATIVE.contains(self.max_correction) {
            true => Ok(()),
            false => Err(VolumeError::MaxCorrection(self.max_correction)),
        }
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

/// Error in the volume options of a body: the measure cannot use the surface, or a value is out of range.
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
        /// Number of edges that faces use more often in one direction than in the other.
        open_edges: usize,
    },
    /// The surface in a lattice component encloses at most 1 % of the volume of the component's cells.
    #[error(
        "volume measure `mesh`: the surface of lattice component {component} encloses {mesh:.3e}, at most \
         1 % of the volume {cells:.3e} of its cells: use `cells`"
    )]
    Flat {
        /// Index of the lattice component, from 0.
        component: usize,
        /// Volume enclosed by the surface in this component, in cubed scene units.
        mesh: f64,
        /// Volume of the cells of this component, in cubed scene units.
        cells: f64,
    },
    /// A connected component of the surface is embedded in more than one component of the lattice.
    #[error(
        "volume measure `mesh`: a connected component of the surface lies in several components of the \
         lattice: use `cells`"
    )]
    AcrossComponents,
    /// `max_correction` is out of range.
    #[error("max_correction is {0}; it must be finite and at least 0 (1 = the body's thickness)")]
    MaxCorrection(f64),
}
