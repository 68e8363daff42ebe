//! What is measured of a case, and in which unit.

/// A figure of a case. All are the smaller the better; where a case looks several times it is the largest that counts,
/// unless it says "at the end".
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// Numbers that are NaN or infinite: of positions, velocities, rotations, the corrected lattice, volumes.
    NotNumbers,
    /// The largest speed of a vertex, in cells a step.
    LargestSpeed,
    /// The largest speed of a vertex at the end, in cells a step.
    FinalSpeed,
    /// What the energy rose to above that of the start, as a share of it and of that of motion by a thousandth of a cell a
    /// step.
    EnergyGain,
    /// The energy at the end, as a share of that of the start.
    EnergyLeft,
    /// Root mean square distance from the rest shape at the end, up to a rigid motion, in cells.
    Shape,
    /// Steps until the distance from the rest shape was a tenth of that at the start, or below a thousandth of a cell.
    StepsToTenth,
    /// Distance of the vertices from where they are expected at the end, root mean square, in cells.
    Place,
    /// Error of the linear momentum, as a share of the sum of the magnitudes of what makes it up.
    Linear,
    /// Error of the angular momentum about the centre of mass, as a share of the sum of the magnitudes.
    Angular,
    /// How deep the surface lies in a collider at the end, in cells.
    Depth,
    /// Error of the volume after its correction at the end, as a share of the volume at rest.
    Volume,
    /// Looks at which no correction within its cap kept the volume.
    Capped,
    /// Rotations that Newton's method left to the robust path.
    Unsettled,
}

impl Measure {
    /// In a few words, with the unit.
    pub fn label(self) -> &'static str {
        match self {
            Self::NotNumbers => "NaN",
            Self::LargestSpeed => "largest speed, cells/step",
            Self::FinalSpeed => "final speed, cells/step",
            Self::EnergyGain => "energy gained, share",
            Self::EnergyLeft => "energy left, share",
            Self::Shape => "shape, cells",
            Self::StepsToTenth => "steps to a tenth",
            Self::Place => "place, cells",
            Self::Linear => "momentum",
            Self::Angular => "angular momentum",
            Self::Depth => "depth, cells",
            Self::Volume => "volume",
            Self::Capped => "capped looks",
            Self::Unsettled => "robust rotations",
        }
    }
}
