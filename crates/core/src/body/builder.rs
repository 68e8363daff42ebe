//! From what a user asks for to a body.

use super::state::State;
use super::{Body, Damping, Material, Placement, Reach, Stiffness};
use crate::dynamics::damping::RegionDamping;
use crate::dynamics::momentum::Bookkeeper;
use crate::error::Error;
use crate::lattice::Lattice;
use crate::matching::Matching;
use crate::matching::layout::Layout;

/// What a [`Body`] is built from.
#[derive(Debug)]
pub struct BodyBuilder {
    name: String,
    shape: Shape,
    material: Material,
    placement: Placement,
}

#[derive(Debug)]
enum Shape {
    Lattice(Lattice),
}

impl BodyBuilder {
    pub(super) fn from_lattice(lattice: Lattice) -> Self {
        Self {
            name: "body".to_owned(),
            shape: Shape::Lattice(lattice),
            material: Material::default(),
            placement: Placement::default(),
        }
    }

    /// Name of the body; default "body".
    #[must_use]
    pub fn name(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Half-width of the regions in cells, at least 1; default 2. Larger is stiffer; so is a coarser lattice.
    #[must_use]
    pub fn half_width(mut self, cells: usize) -> Self {
        self.material.reach = Reach::Cells(cells);
        self
    }

    /// Half-width of the regions as a length, > 0: it stays when the resolution changes.
    #[must_use]
    pub fn stiffness_radius(mut self, radius: f64) -> Self {
        self.material.reach = Reach::Radius(radius);
        self
    }

    /// alpha per step, in (0, 1]; default 1.
    #[must_use]
    pub fn stiffness(mut self, alpha: f64) -> Self {
        self.material.stiffness = Stiffness::PerStep(alpha);
        self
    }

    /// Stiffness as a frequency in Hz, > 0: it stays when the step changes.
    #[must_use]
    pub fn frequency(mut self, hertz: f64) -> Self {
        self.material.stiffness = Stiffness::Frequency(hertz);
        self
    }

    /// Region damping per step, in [0, 1]; default 0, which leaves the stage out.
    #[must_use]
    pub fn damping(mut self, share: f64) -> Self {
        self.material.damping = Damping::PerStep(share);
        self
    }

    /// Region damping as a rate in 1/s, >= 0: it stays when the step changes.
    #[must_use]
    pub fn damping_rate(mut self, rate: f64) -> Self {
        self.material.damping = Damping::Rate(rate);
        self
    }

    /// Mass per volume, > 0; default 1000.
    #[must_use]
    pub fn density(mut self, density: f64) -> Self {
        self.material.density = density;
        self
    }

    /// The whole material at once.
    #[must_use]
    pub fn material(mut self, material: Material) -> Self {
        self.material = material;
        self
    }

    /// Where and how the body starts; default: at rest where the model is.
    #[must_use]
    pub fn placement(mut self, placement: Placement) -> Self {
        self.placement = placement;
        self
    }

    /// The body.
    ///
    /// # Errors
    ///
    /// A number out of its range.
    pub fn build(self) -> Result<Body, Error> {
        self.material.validate()?;
        let Shape::Lattice(lattice) = self.shape;
        let layout = Layout::new(&lattice);
        let bookkeeper = Bookkeeper::new(&lattice, &layout);
        let state =
            State::at_rest(&lattice, &layout, self.placement.rotation(), self.placement.translation());
        let half_width = self.material.half_width(lattice.cell_size(), extent(&lattice));
        let matching = Matching::new(&lattice, layout, half_width);
        let damping = self.material.is_damped().then(|| RegionDamping::new(&matching));
        let body = Body {
            name: self.name,
            material: self.material,
            placement: self.placement,
            lattice,
            surface: None,
            matching,
            damping,
            bookkeeper,
            kinematics: None,
            contacts: None,
            state,
        };
        Ok(body)
    }
}

/// The largest extent of a lattice along an axis, in cells.
fn extent(lattice: &Lattice) -> usize {
    let along = |c: usize| {
        let (low, high) = lattice
            .indices()
            .iter()
            .fold((i32::MAX, i32::MIN), |(low, high), index| (low.min(index[c]), high.max(index[c])));
        high.abs_diff(low) as usize
    };
    (0..3).map(along).max().unwrap_or(1)
}
