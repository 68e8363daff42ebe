//! The contacts between bodies that pressed on them in the last step, as supports of their rest.

use nalgebra::Vector3;

use super::Deflection;

/// The contacts between two connected components that pressed on them in a step, as one contact at their center of
/// pressure. In world space and scene units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct PairSupport {
    /// The bodies, each with the index of its connected component; the lesser pair first.
    pub(crate) sides: [(u32, u32); 2],
    /// Sum of the normal impulses.
    pub(crate) impulse: f64,
    /// Center of pressure.
    pub(crate) point: [f64; 3],
    /// Mean normal to the first side, a unit vector; zero if the normals cancel each other.
    pub(crate) normal: [f64; 3],
    /// Deflection by relative rotation, in rad.
    pub(crate) rotation: Deflection,
    /// Deflection by sliding, as a fraction of the size of the smaller body.
    pub(crate) sliding: Deflection,
}

/// The supports of the bodies of a simulation by each other, in increasing order of the sides.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct PairSupports(Vec<PairSupport>);

impl PairSupports {
    pub(crate) fn list(&self) -> &[PairSupport] {
        &self.0
    }

    /// Returns whether the supports are in increasing order of the sides, each pair once, with finite numbers.
    pub(crate) fn is_valid(&self) -> bool {
        let numbers = |support: &PairSupport| {
            support.point.iter().chain(&support.normal).all(|x| x.is_finite()) && support.impulse.is_finite()
        };
        self.0.is_sorted_by(|a, b| a.sides < b.sides) && self.0.iter().all(numbers)
    }

    pub(crate) fn list_mut(&mut self) -> &mut [PairSupport] {
        &mut self.0
    }

    /// Keeps the supports of which `keeps` returns true.
    pub(crate) fn retain(&mut self, keeps: impl Fn(&PairSupport) -> bool) {
        self.0.retain(keeps);
    }

    /// Replaces the supports that `replaces` selects by the supports at some contacts: the two sides, the impulse on
    /// the first one, the point and the unit normal towards the first side. A support that existed before keeps its
    /// deflections.
    pub(crate) fn set(
        &mut self,
        replaces: impl Fn(&PairSupport) -> bool,
        contacts: impl Iterator<Item = ([(u32, u32); 2], f64, Vector3<f64>, Vector3<f64>)>,
    ) {
        for support in self.0.iter_mut().filter(|support| replaces(support)) {
            (support.impulse, support.point, support.normal) = (0.0, [0.0; 3], [0.0; 3]);
        }
        for (mut sides, impulse, point, mut normal) in contacts {
            if sides[0] > sides[1] {
                sides.swap(0, 1);
                normal = -normal;
            }
            let index =
                self.0.binary_search_by_key(&sides, |support| support.sides).unwrap_or_else(|index| {
                    self.0.insert(index, PairSupport { sides, ..PairSupport::default() });
                    index
                });
            let support = &mut self.0[index];
            support.impulse += impulse;
            for c in 0..3 {
                support.point[c] += impulse * point[c];
                support.normal[c] += impulse * normal[c];
            }
        }
        self.0.retain(|support| !replaces(support) || support.impulse > 0.0);
        for support in self.0.iter_mut().filter(|support| replaces(support)) {
            let scale = 1.0 / support.impulse;
            support.point = support.point.map(|sum| sum * scale);
            let normal = Vector3::from(support.normal) * scale;
            support.normal = normal.try_normalize(1e-3).unwrap_or_default().into();
        }
    }
}
