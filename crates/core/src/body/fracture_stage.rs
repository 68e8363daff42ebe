//! The stage of a body that can break or was cut.

use crate::fracture::Fracture;
use crate::lattice::Masses;
use crate::mesh::Mesh;

/// The stage of a body that can break or was cut.
#[derive(Debug)]
pub(super) struct Breaking {
    pub(super) fracture: Fracture,
    /// Filled share of each cell, times the factor of its density.
    pub(super) shares: Vec<f64>,
    /// The mesh of the whole body.
    pub(super) whole: Option<Mesh>,
    /// The masses of the vertices of the whole body.
    pub(super) whole_masses: Masses,
    /// Whether the shape matching of the step stores the deformation gradients of all regions.
    pub(super) has_gradients: bool,
    /// Whether joints were found that break at the end of the step.
    pub(super) is_due: bool,
    /// Whether there are pieces that the contacts of the simulation have not registered.
    pub(super) has_new_pieces: bool,
}

impl Breaking {
    /// Decides whether the shape matching of a step stores the deformation gradients of all regions. Otherwise they are
    /// measured after it where they are needed. The results are the same. Plastic bodies always need them.
    pub(super) fn expect_gradients(&mut self, is_plastic: bool) {
        self.has_gradients = is_plastic || self.fracture.expects_gradients();
    }
}
