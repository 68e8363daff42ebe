//! Finds out where a body deviates from its scene: frames in which its volume was not kept or in which it was crushed, and
//! a frequency or a Young's modulus for which its steps are too long.

use std::fmt;

use crate::count::counted;
use crate::scene::MAX_SUBSTEPS;
use supple::{BodyRef, ComponentReport, FieldKind, Interior, Simulation, UntanglingReport};

/// Relative volume error above which the volume of a frame counts as not kept: 0.1 %.
///
/// It changes lengths by 0.03 %, a third of a pixel on a body of 1000 pixels. It is a thousand times the error
/// of a complete correction, 1e-6.
pub const VOLUME_THRESHOLD: f64 = 1e-3;

/// The written frames in which the displayed volume of a body was not kept although its volume is preserved:
/// its relative error exceeds [`VOLUME_THRESHOLD`] in a component of the lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct UnkeptVolume {
    /// Number of frames in which the volume was not kept, at least 1.
    pub frames: u32,
    /// Number of frames that the run wrote with the volume correction.
    pub written: u32,
    /// Number of the frame with the largest error, as in its file name.
    pub worst_frame: u64,
    /// Largest relative error, `(after - rest) / rest`; negative if volume was lost.
    pub worst_error: f64,
    /// Change of the scene that lets the correction keep more of the volume.
    pub remedy: VolumeRemedy,
}

/// Change of a scene that lets the correction keep more of the volume of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum VolumeRemedy {
    /// The scale of the correction is limited to less than the thickness of the body.
    RaiseCap,
    /// The surface is a sheet, and the correction moves it along its normals.
    AutoField,
    /// Pins, handles or colliders can press the body from two sides.
    MoreSpace,
    /// Weights and impacts press the body.
    StifferMaterial,
}

impl VolumeRemedy {
    /// Returns the remedy for the body with the given index. A cap of 1 or more does not limit the correction: where one
    /// scale does not suffice, it takes passes of at most half of the thickness each.
    pub(super) fn of(simulation: &Simulation, index: usize) -> Self {
        let body = simulation.body(index);
        let options = body.volume_options();
        let is_sheet = || body.mesh().is_some_and(|mesh| mesh.interior() == Interior::Sheet);
        if options.max_correction < 1.0 {
            Self::RaiseCap
        } else if options.field == FieldKind::Surface && is_sheet() {
            Self::AutoField
        } else if body.constraint_count() > 0 || simulation.collider_count() > 1 {
            Self::MoreSpace
        } else {
            Self::StifferMaterial
        }
    }
}

impl fmt::Display for VolumeRemedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::RaiseCap => "raise `max_correction` of `volume` to 1",
            Self::AutoField => "its surface is a sheet: set `field` of `volume` to \"auto\"",
            Self::MoreSpace => "leave more space between pins, handles and colliders",
            Self::StifferMaterial => "it is pressed too much for its material: make it stiffer",
        })
    }
}

impl fmt::Display for UnkeptVolume {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { frames, written, worst_frame, worst_error, remedy } = self;
        let written = counted(*written as usize, "written frame");
        write!(
            f,
            "the volume was not kept in {frames} of {written}, by up to {:+.2} % in frame \
             {worst_frame}; {remedy}",
            100.0 * worst_error
        )
    }
}

/// The written frames in which a body was crushed to less than a quarter of its volume, and was displayed with cells inside
/// out: to untangle them would take too long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Crushed {
    /// Number of these frames, at least 1.
    pub frames: u32,
    /// Number of frames that the run wrote.
    pub written: u32,
}

impl fmt::Display for Crushed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { frames, written } = self;
        let written = counted(*written as usize, "written frame");
        write!(
            f,
            "it was crushed to less than a quarter of its volume in {frames} of {written}, and is shown there with cells \
             inside out, so that the frames take no longer; make it stiffer, or what presses it lighter"
        )
    }
}

/// Counts the frames in which a body was crushed.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CrushRecord {
    written: u32,
    crushed: u32,
}

impl CrushRecord {
    /// Adds a frame.
    pub(super) fn add(&mut self, untangling: UntanglingReport) {
        self.written += 1;
        self.crushed += u32::from(untangling.given_up);
    }

    /// Returns the frames in which the body was crushed; `None` if there are none.
    pub(super) fn crushed(&self) -> Option<Crushed> {
        let Self { written, crushed } = *self;
        (crushed > 0).then_some(Crushed { frames: crushed, written })
    }
}

/// Counts the frames in which the volume of a body was not kept.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct VolumeRecord {
    written: u32,
    unkept: u32,
    worst_frame: u64,
    worst_error: f64,
}

impl VolumeRecord {
    /// Adds the results of the correction in the frame with the number `number`. Without a correction there
    /// are no results, and the frame does not count.
    pub(super) fn add(&mut self, number: u64, corrections: &[ComponentReport]) {
        let errors = corrections.iter().map(|component| component.residual);
        let Some(error) = errors.max_by(|a, b| a.abs().total_cmp(&b.abs())) else { return };
        self.written += 1;
        if error.abs() > VOLUME_THRESHOLD {
            self.unkept += 1;
            if error.abs() > self.worst_error.abs() {
                (self.worst_frame, self.worst_error) = (number, error);
            }
        }
    }

    /// Returns the frames in which the volume was not kept; `None` if there are none.
    pub(super) fn unkept(&self, remedy: impl FnOnce() -> VolumeRemedy) -> Option<UnkeptVolume> {
        let Self { written, unkept, worst_frame, worst_error } = *self;
        (unkept > 0).then(|| UnkeptVolume {
            frames: unkept,
            written,
            worst_frame,
            worst_error,
            remedy: remedy(),
        })
    }
}

/// A body that is softer than its material, because its steps are too long.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Softened {
    /// The key of the quantity: `youngs_modulus` (also of a `material`) or `frequency`.
    pub key: &'static str,
    /// Specified value: force per area in scene units, or Hz.
    pub specified: f64,
    /// Value in force.
    pub in_force: f64,
    /// The stiffness factor of the part that the values are of: the greatest of the body, and 1 without zones.
    pub factor: f64,
    /// Steps per frame of the run.
    pub substeps: u32,
    /// Steps per frame that reach the specified value; `None` if a scene cannot have as many.
    pub needed_substeps: Option<u32>,
}

impl Softened {
    /// Returns whether and how a body is softened by frames of `substeps` steps of `dt` seconds.
    pub fn of(body: BodyRef<'_>, substeps: u32, dt: f64) -> Option<Self> {
        body.softened().map(|supple::Softened { key, specified, in_force, factor, needed_rate, .. }| {
            // The factor 1 - 1e-9 prevents a rounding error from increasing a whole number of steps by one.
            let steps = (needed_rate * dt * f64::from(substeps) * (1.0 - 1e-9)).ceil();
            let needed_substeps = (steps <= f64::from(MAX_SUBSTEPS)).then_some(steps as u32);
            Self { key, specified, in_force, factor, substeps, needed_substeps }
        })
    }
}

impl fmt::Display for Softened {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { key, specified, in_force, factor, substeps, needed_substeps } = *self;
        let (steps, verb) =
            (counted(substeps as usize, "step"), if substeps == 1 { "allows" } else { "allow" });
        let unit = if key == "frequency" { " Hz" } else { "" };
        let [specified, in_force] = [specified, in_force].map(four_digits);
        let part =
            if factor > 1.0 { format!(" of the part with the factor {factor}") } else { String::new() };
        write!(
            f,
            "it is softer than specified: `{key}`{part} is {specified}{unit}, and {steps} per frame {verb} at most \
             {in_force}{unit}; ",
        )?;
        match needed_substeps {
            Some(needed) => write!(f, "set simulation.substeps to {needed} or \"auto\", or lower `{key}`"),
            None => write!(f, "lower `{key}`"),
        }
    }
}

/// Formats a positive number with four significant digits.
pub(super) fn four_digits(value: f64) -> String {
    let text = format!("{value:.3e}");
    let rounded: f64 = text.parse().unwrap_or(value);
    if (1e-3..1e6).contains(&rounded) { rounded.to_string() } else { format!("{rounded:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn results(residuals: &[f64]) -> Vec<ComponentReport> {
        let result = |&residual: &f64| {
            let mut result = ComponentReport::default();
            result.residual = residual;
            result
        };
        residuals.iter().map(result).collect()
    }

    #[test]
    fn frames_above_the_threshold_are_counted_and_the_worst_is_named() {
        let mut record = VolumeRecord::default();
        record.add(7, &results(&[1e-6, -VOLUME_THRESHOLD]));
        record.add(8, &[]);
        let remedy = || VolumeRemedy::RaiseCap;
        assert_eq!(record.unkept(remedy), None);
        for (number, residuals) in [(9, [0.0, 0.002]), (10, [-0.034_56, 0.01]), (11, [0.02, 0.0])] {
            record.add(number, &results(&residuals));
        }
        let unkept = record.unkept(remedy).unwrap();
        let (written, worst_error, remedy) = (4, -0.034_56, remedy());
        assert_eq!(unkept, UnkeptVolume { frames: 3, written, worst_frame: 10, worst_error, remedy });
        let text = unkept.to_string();
        assert!(text.contains("3 of 4 written frames, by up to -3.46 % in frame 10; raise"), "{text}");
        let text = UnkeptVolume { frames: 1, written: 1, ..unkept }.to_string();
        assert!(text.contains("1 of 1 written frame,"), "{text}");
    }

    #[test]
    fn the_remedy_for_a_volume_depends_on_its_cause() {
        use supple::{Body, Collider, Mesh, Pin, Selection, TimeWindow, VolumeOptions};

        let square = [[0.0; 3], [4.0, 0.0, 0.0], [4.0, 0.0, 4.0], [0.0, 0.0, 4.0]];
        let sheet = Mesh::new(square.to_vec(), &[vec![0, 1, 2, 3]]).unwrap();
        let remedy = |options: VolumeOptions, is_pinned: bool, colliders: usize| {
            let mut body = Body::builder(sheet.clone()).cell_size(1.0).volume(options);
            if is_pinned {
                let selection = Selection::Box { min: [-9.0; 3], max: [9.0; 3] };
                body = body.pin(Pin { goal: None, selection, window: TimeWindow::default() });
            }
            let mut simulation = Simulation::builder().body(body.build().unwrap());
            for _ in 0..colliders {
                simulation = simulation.collider(Collider::plane([0.0, -9.0, 0.0], [0.0, 1.0, 0.0]));
            }
            VolumeRemedy::of(&simulation.build().unwrap(), 0)
        };
        let default = VolumeOptions::default();
        let capped = VolumeOptions { max_correction: 0.5, ..default };
        let along_normals = VolumeOptions { field: FieldKind::Surface, ..default };
        assert_eq!(remedy(capped, true, 2), VolumeRemedy::RaiseCap);
        assert_eq!(remedy(along_normals, true, 2), VolumeRemedy::AutoField);
        assert_eq!(remedy(default, true, 0), VolumeRemedy::MoreSpace);
        assert_eq!(remedy(default, false, 2), VolumeRemedy::MoreSpace);
        assert_eq!(remedy(default, false, 1), VolumeRemedy::StifferMaterial);
    }

    #[test]
    fn a_frequency_above_a_sixth_of_the_step_rate_is_softened() {
        let softened = |frequency: f64, substeps: u32| {
            let lattice = supple::Lattice::from_cells(&[[0; 3]], 1.0, [0.0; 3], true).unwrap();
            let body = supple::Body::from_lattice(lattice).frequency(frequency).build().unwrap();
            let simulation = supple::Simulation::builder().body(body).fps(30.0);
            let simulation = simulation.substeps(supple::Substeps::Fixed(substeps)).build().unwrap();
            Softened::of(simulation.body(0), substeps, simulation.dt())
        };
        // Two steps per frame at 30 frames per second: 60 / 6 Hz.
        assert_eq!(softened(10.0, 2), None);
        let found = softened(10.5, 2).unwrap();
        assert!((found.in_force - 10.0).abs() < 1e-12);
        assert_eq!((found.needed_substeps, softened(10.5, 3)), (Some(3), None));
        let text = found.to_string();
        let expected = "10.5 Hz, and 2 steps per frame allow at most 10 Hz; set simulation.substeps to 3 or";
        assert!(text.contains(expected), "{text}");
        assert!(softened(6.0, 1).unwrap().to_string().contains("1 step per frame allows at most 5 Hz"));
        assert!(softened(1e9, 2).unwrap().to_string().ends_with("at most 10 Hz; lower `frequency`"));
    }
}
