//! Options of the correction, and why they cannot be met.

use std::fmt;

/// A definition of the volume of a body. Each is an exact cubic in the scale of the correction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum VolumeMeasure {
    /// Takamatsu & Kanai (2009): summed over lattice vertices, from their six neighbours. Cheap and approximate: the
    /// visible surface keeps its volume to a few per cent.
    Lattice,
    /// The exact volume of the trilinear cells.
    Cells,
    /// The exact volume enclosed by the embedded surface.
    Mesh,
}

impl VolumeMeasure {
    /// Its name in scenes and reports: `lattice`, `cells` or `mesh`.
    pub fn name(self) -> &'static str {
        Preservation::By(self).name()
    }
}

impl fmt::Display for VolumeMeasure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Whether a body's volume is kept, and by which measure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Preservation {
    /// No correction: the surface follows the dynamics. Costs nothing.
    Off,
    /// `mesh` where the surface encloses a volume, else `cells`.
    #[default]
    Auto,
    /// By this measure.
    By(VolumeMeasure),
}

impl Preservation {
    /// What it is called in scenes and in Python.
    pub const NAMED: [(&'static str, Self); 5] = [
        ("auto", Self::Auto),
        ("off", Self::Off),
        ("lattice", Self::By(VolumeMeasure::Lattice)),
        ("cells", Self::By(VolumeMeasure::Cells)),
        ("mesh", Self::By(VolumeMeasure::Mesh)),
    ];

    /// Its name among [`Preservation::NAMED`].
    pub fn name(self) -> &'static str {
        name_of(self, &Self::NAMED)
    }
}

/// The name of a value among the named ones, which are all that there are.
fn name_of<T: PartialEq>(value: T, named: &[(&'static str, T)]) -> &'static str {
    named.iter().find(|(_, one)| *one == value).map_or("", |(name, _)| name)
}

/// Where a body regains its volume.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum VolumeScope {
    /// Everywhere: one scale for each component, as in Takamatsu & Kanai (2009).
    #[default]
    Global,
    /// Where it was lost: a scale for each region of the lattice, then one for each component for the rest.
    Regional,
}

impl VolumeScope {
    /// What it is called in scenes and in Python.
    pub const NAMED: [(&'static str, Self); 2] = [("global", Self::Global), ("regional", Self::Regional)];

    /// Its name among [`VolumeScope::NAMED`].
    pub fn name(self) -> &'static str {
        name_of(self, &Self::NAMED)
    }
}

/// How the deformation field is built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum FieldKind {
    /// As in Takamatsu & Kanai (2009): unit normals at boundary vertices, from the neighbours that exist; inwards,
    /// layer by layer, the mean direction of the layer before, at a length that falls from 1 to 0 at the center.
    Paper,
    /// The smoothest field that moves the boundary faces of the cells by 1 along their normals.
    Cells,
    /// The smoothest field that moves the surface mesh by 1 along its normals, whatever the stairs of the lattice. A
    /// bare lattice has `Cells`.
    #[default]
    Surface,
}

impl FieldKind {
    /// What it is called in scenes and in Python.
    pub const NAMED: [(&'static str, Self); 3] =
        [("surface", Self::Surface), ("cells", Self::Cells), ("paper", Self::Paper)];

    /// Its name among [`FieldKind::NAMED`].
    pub fn name(self) -> &'static str {
        name_of(self, &Self::NAMED)
    }
}

/// How a body's volume is kept. Exhaustive, so that users write `VolumeOptions { scope, ..VolumeOptions::default() }`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct VolumeOptions {
    /// Whether, and by which measure. Default: [`Preservation::Auto`].
    pub measure: Preservation,
    /// Where the volume is regained. Default: [`VolumeScope::Global`].
    pub scope: VolumeScope,
    /// The field along which the correction moves. Default: [`FieldKind::Surface`].
    pub field: FieldKind,
    /// Cap on the scale of the correction, as a fraction of the body's thickness (the greatest depth of a lattice
    /// vertex below the boundary): finite, 0 or more; at 0 nothing moves. Default: 1.
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
    /// No correction.
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

/// Why a volume cannot be kept as asked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VolumeError {
    /// The measure `mesh` without a mesh.
    #[error("volume measure `mesh` needs a surface mesh, and this body is a bare lattice: use `cells`")]
    NoMesh,
    /// The surface has holes, or faces that look opposite ways.
    #[error(
        "volume measure `mesh` needs a closed surface, and {open_edges} edges of this one do not cancel between the \
         faces beside them: use `cells`"
    )]
    Open {
        /// Edges whose directed uses do not cancel.
        open_edges: usize,
    },
    /// The surface encloses next to nothing.
    #[error(
        "volume measure `mesh`: the surface of lattice component {component} encloses {mesh:.3e}, less than 1 % of \
         the {cells:.3e} that its cells fill: use `cells`"
    )]
    Flat {
        /// The lattice component, from 0.
        component: usize,
        /// Volume enclosed, in cubed units of length.
        mesh: f64,
        /// Volume of the component's cells, in cubed units of length.
        cells: f64,
    },
    /// A connected part of the surface is carried by more than one component of the lattice.
    #[error(
        "volume measure `mesh`: a part of the surface hangs on two components of the lattice: use `cells`"
    )]
    AcrossComponents,
    /// The cap is out of range.
    #[error("max_correction is {0}, and must be finite and 0 or more (1 = the body's thickness)")]
    MaxCorrection(f64),
}
