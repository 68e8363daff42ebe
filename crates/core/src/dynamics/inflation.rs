//! Inflation: rest volumes that change over time.
//!
//! s is the ratio of the rest volume around a vertex to its volume in the mesh: s = s₀ Π s_z^share, with the ratio s₀
//! of the body, and the ratio of each zone and the share of the vertex in it, both at the end of the step. For the
//! use of s by the regions see `matching::bulk`.

use crate::lattice::Components;
use crate::matching::VolumeRatios;
use crate::motion::Curve;
use crate::range::{RATIOS, Range, RangeError};

/// The ratios of the rest volume of a body and of its zones.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Inflation {
    /// s₀.
    body: InflatedPart,
    zones: Vec<(InflatedPart, Vec<f64>)>,
    /// The mean of s over each component as of the last step, weighted by mass. Empty if all ratios are 1.
    #[cfg_attr(feature = "serde", serde(skip))]
    means: Vec<f64>,
    /// The mass of each component.
    #[cfg_attr(feature = "serde", serde(skip))]
    totals: Vec<f64>,
}

/// The ratio of the rest volume of a part.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct InflatedPart {
    curve: Curve,
    /// The ratio as of the last step.
    in_force: f64,
}

impl InflatedPart {
    fn new(curve: Curve) -> Self {
        Self { curve, in_force: 1.0 }
    }

    /// Returns whether the ratio is 1 and stays so.
    fn is_idle(&self) -> bool {
        self.in_force == 1.0 && self.curve.constant() == Some(1.0)
    }
}

impl Default for Inflation {
    fn default() -> Self {
        Self { body: InflatedPart::new(1.0.into()), zones: Vec::new(), means: Vec::new(), totals: Vec::new() }
    }
}

impl Inflation {
    /// Checks the range of a ratio.
    pub(crate) fn validate(curve: &Curve) -> Result<(), RangeError> {
        curve.keys().iter().try_for_each(|key| Range::INFLATION.check("inflate", key.value).map(drop))
    }

    /// Returns the ratio of the body.
    pub(crate) fn curve(&self) -> &Curve {
        &self.body.curve
    }

    /// Sets the ratio of the body, from the next step on.
    pub(crate) fn set_curve(&mut self, curve: Curve) {
        self.body.curve = curve;
    }

    /// Adds a zone, in which each vertex has a share in [0, 1].
    pub(crate) fn add_zone(&mut self, curve: Curve, shares: Vec<f64>) {
        self.zones.push((InflatedPart::new(curve), shares));
    }

    fn parts_mut(&mut self) -> impl Iterator<Item = &mut InflatedPart> {
        std::iter::once(&mut self.body).chain(self.zones.iter_mut().map(|(part, _)| part))
    }

    fn parts(&self) -> impl Iterator<Item = &InflatedPart> {
        std::iter::once(&self.body).chain(self.zones.iter().map(|(part, _)| part))
    }

    /// Returns whether a ratio at `time` is not the one as of the last step.
    pub(crate) fn changes_at(&self, time: f64) -> bool {
        self.parts().any(|part| part.curve.value(time) != part.in_force)
    }

    /// Sets the ratios to those at `time`.
    pub(crate) fn update(&mut self, time: f64) {
        self.parts_mut().for_each(|part| part.in_force = part.curve.value(time));
    }

    /// Returns whether all ratios are 1 and stay so.
    pub(crate) fn is_idle(&self) -> bool {
        self.parts().all(InflatedPart::is_idle)
    }

    /// Returns whether a ratio as of the last step is not 1.
    pub(crate) fn is_acting(&self) -> bool {
        self.parts().any(|part| part.in_force != 1.0)
    }

    /// Passes s as of the last step to `receive`, or `None` if all ratios are 1.
    pub(crate) fn pass(&self, receive: impl FnOnce(Option<VolumeRatios>)) {
        match () {
            _ if !self.is_acting() => receive(None),
            _ if self.zones.is_empty() => receive(Some(VolumeRatios::Uniform(self.body.in_force))),
            _ => receive(Some(VolumeRatios::Vertices(&|vertex| self.ratio(vertex)))),
        }
    }

    /// Computes the means over components as of the last step.
    pub(crate) fn measure_means(&mut self, components: &Components, masses: &[f32]) {
        self.means.clear();
        self.totals.clear();
        if !self.is_acting() {
            return;
        }
        self.means.resize(components.count, 0.0);
        self.totals.resize(components.count, 0.0);
        for (vertex, (&component, &mass)) in components.of_vertex.iter().zip(masses).enumerate() {
            self.means[component as usize] += f64::from(mass) * self.ratio(vertex);
            self.totals[component as usize] += f64::from(mass);
        }
        for (mean, total) in self.means.iter_mut().zip(&self.totals) {
            *mean /= total;
        }
    }

    /// Returns the ratio of the rest volume of each component: the mean of s, weighted by mass. `None` if all ratios
    /// are 1.
    pub(crate) fn means(&self) -> Option<&[f64]> {
        Some(self.means.as_slice()).filter(|means| !means.is_empty())
    }

    /// Returns s of a vertex as of the last step, limited to [0.1, 10].
    pub(crate) fn ratio(&self, vertex: usize) -> f64 {
        let mut ratio = self.body.in_force;
        for (part, shares) in &self.zones {
            match shares[vertex] {
                0.0 => {}
                1.0 => ratio *= part.in_force,
                share => ratio *= libm::pow(part.in_force, share),
            }
        }
        ratio.clamp(*RATIOS.start(), *RATIOS.end())
    }

    /// Transfers the zones to a lattice whose vertices were split: `parents` has the vertex before of each vertex.
    pub(crate) fn transfer(&mut self, parents: &[u32]) {
        for (_, shares) in &mut self.zones {
            *shares = parents.iter().map(|&parent| shares[parent as usize]).collect();
        }
    }

    /// Returns the inflation before the first step, with the zones on a lattice in which each vertex has the vertex
    /// `parents` of this one.
    pub(crate) fn at_start(&self, parents: &[u32]) -> Self {
        let mut inflation = self.clone();
        inflation.transfer(parents);
        inflation.parts_mut().for_each(|part| part.in_force = 1.0);
        (inflation.means, inflation.totals) = (Vec::new(), Vec::new());
        inflation
    }

    /// Returns whether all numbers are valid for a lattice with `vertices` vertices.
    pub(crate) fn is_valid(&self, vertices: usize) -> bool {
        self.parts().all(|part| {
            part.curve.is_valid()
                && Self::validate(&part.curve).is_ok()
                && Range::INFLATION.contains(part.in_force)
        }) && self.zones.iter().all(|(_, shares)| {
            shares.len() == vertices && shares.iter().all(|share| (0.0..=1.0).contains(share))
        })
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let shares: usize = self.zones.iter().map(|(_, shares)| size_of_val(shares.as_slice())).sum();
        shares + size_of_val(self.means.as_slice()) + size_of_val(self.totals.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ratio_of_a_vertex_is_the_product_over_its_zones() {
        let mut inflation = Inflation::default();
        inflation.set_curve(2.0.into());
        inflation.add_zone(4.0.into(), vec![0.0, 0.5, 1.0]);
        inflation.add_zone(3.0.into(), vec![0.0, 0.0, 1.0]);
        assert!(inflation.changes_at(0.0));
        inflation.update(0.0);
        assert!(!inflation.changes_at(1.0));
        // The last product is limited.
        assert_eq!([0, 1, 2].map(|vertex| inflation.ratio(vertex)), [2.0, 4.0, 10.0]);
        inflation.transfer(&[1, 1, 0, 2]);
        assert_eq!([0, 1, 2, 3].map(|vertex| inflation.ratio(vertex)), [4.0, 4.0, 2.0, 10.0]);
        assert!(inflation.is_valid(4) && !inflation.is_valid(3));
    }

    #[test]
    fn an_inflation_is_idle_once_all_ratios_stay_1() {
        let mut inflation = Inflation::default();
        inflation.set_curve(2.0.into());
        inflation.update(0.0);
        inflation.set_curve(1.0.into());
        assert!(!inflation.is_idle());
        inflation.update(0.0);
        assert!(inflation.is_idle());
    }
}
