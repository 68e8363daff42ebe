//! The change of the measure `mesh` by the displacements of mesh vertices on colliders (module `flatten`).

use super::line::Moving;
use super::mesh_measure::{MeshMeasure, WeightedPoints, volume_of_quads};
use super::sums::Scratch;
use crate::flatten::{Displacements, FlattenedSurface};

/// Marks a rank without a number.
const NONE: u32 = u32::MAX;

/// The change of the volume by displacements of mesh vertices, and its buffers.
///
/// Only triangles with a displaced corner change their volumes. Their corners are numbered: first the displaced mesh
/// vertices, then the others.
#[derive(Clone, Debug, Default)]
pub(super) struct FlattenedVolume {
    /// Number of each rank.
    numbers: Vec<u32>,
    /// Rank of each number.
    ranks: Vec<u32>,
    /// Motion of each number along the field, without and with the displacements.
    motions: [Vec<Moving>; 2],
    points: WeightedPoints,
    /// Component and number of the displaced mesh vertices, sorted.
    displaced: Vec<(u32, u32)>,
    /// The triangles of a component, as quads whose last corner is the first one.
    quads: Vec<[u32; 4]>,
    /// Components with displaced mesh vertices, and the change of the volume of each as a cubic in `lambda`, in cubed
    /// cells.
    changes: Vec<(u32, [f64; 4])>,
}

impl FlattenedVolume {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let motions: usize = self.motions.iter().map(|motions| size_of_val(&**motions)).sum();
        let numbers = size_of_val(&*self.numbers) + size_of_val(&*self.ranks) + size_of_val(&*self.displaced);
        numbers + motions + self.points.bytes() + size_of_val(&*self.quads) + size_of_val(&*self.changes)
    }

    /// Computes the change of the volume of each component.
    ///
    /// The displacements are those at the present `lambda` of each component, `lambdas`. When it changes, the colliders
    /// hold the displaced mesh vertices back. `scratch`: the points and their directions; with a smooth skin the
    /// measure has been evaluated for them.
    pub(super) fn update(
        &mut self,
        measure: &MeshMeasure,
        scratch: &Scratch,
        surface: FlattenedSurface<'_>,
        lambdas: &[f64],
    ) -> &[(u32, [f64; 4])] {
        self.number_displaced(measure, scratch, surface, lambdas);
        let displaced = std::mem::take(&mut self.displaced);
        let count = displaced.len() as u32;
        self.changes.clear();
        for group in displaced.chunk_by(|a, b| a.0 == b.0) {
            self.collect_quads(measure, scratch, surface, (group, count));
            let [before, after] =
                self.motions.each_ref().map(|motions| volume_of_quads(&self.quads, motions));
            self.changes.push((group[0].0, std::array::from_fn(|k| after[k] - before[k])));
        }
        self.displaced = displaced;
        for &rank in &self.ranks {
            self.numbers[rank as usize] = NONE;
        }
        &self.changes
    }

    /// Adds to the displacements of mesh vertices the part of their motions that is held back, after `lambda` has
    /// changed. `steps`: change of the `lambda` of each component. Must be called after [`FlattenedVolume::update`].
    pub(super) fn follow(&self, steps: &[f64], displacements: &mut Displacements) {
        let [before, after] = &self.motions;
        for &(component, number) in &self.displaced {
            let step = steps[component as usize] as f32;
            let (v, held) = (before[number as usize].direction(), after[number as usize].direction());
            displacements.add(self.ranks[number as usize], std::array::from_fn(|k| step * (held[k] - v[k])));
        }
    }

    /// Numbers the displaced mesh vertices, and computes their motions.
    fn number_displaced(
        &mut self,
        measure: &MeshMeasure,
        scratch: &Scratch,
        surface: FlattenedSurface<'_>,
        lambdas: &[f64],
    ) {
        let Self { numbers, ranks, motions, displaced, .. } = self;
        let FlattenedSurface { embedding, table, displacements, .. } = surface;
        numbers.resize(table.vertices.len(), NONE);
        ranks.clear();
        displaced.clear();
        motions.iter_mut().for_each(Vec::clear);
        for hold in &displacements.holds {
            let number = &mut numbers[hold.rank as usize];
            if *number == NONE {
                *number = ranks.len() as u32;
                ranks.push(hold.rank);
                let corner = embedding.corners(table.vertices[hold.rank as usize] as usize)[0];
                displaced.push((table.components[corner as usize], *number));
            }
        }
        self.add_motions(measure, scratch, surface);
        let Self { numbers, ranks, motions: [before, after], displaced, .. } = self;
        for hold in &displacements.holds {
            let motion = &mut after[numbers[hold.rank as usize] as usize];
            motion.set_direction(hold.apply(motion.direction()));
        }
        for &(component, number) in &*displaced {
            let (before, after) = (&before[number as usize], &mut after[number as usize]);
            let lambda = lambdas.get(component as usize).map_or(0.0, |lambda| *lambda as f32);
            let offset = displacements.get(ranks[number as usize]);
            let (p, v, held) = (before.position(), before.direction(), after.direction());
            after.set_position(std::array::from_fn(|k| p[k] + offset[k] + lambda * (v[k] - held[k])));
        }
        displaced.sort_unstable();
    }

    /// Computes the motions of the last numbers, without displacements.
    fn add_motions(&mut self, measure: &MeshMeasure, scratch: &Scratch, surface: FlattenedSurface<'_>) {
        let Self { ranks, motions: [before, after], points, .. } = self;
        let first = before.len();
        let new = ranks[first..].iter().map(|&rank| (surface.table.vertices[rank as usize], rank));
        measure.add_motions(new, surface.embedding, scratch, points, before);
        after.extend_from_slice(&before[first..]);
    }

    /// Collects the triangles with a corner in `displaced`, and numbers their other corners. `count`: number of all
    /// displaced mesh vertices.
    fn collect_quads(
        &mut self,
        measure: &MeshMeasure,
        scratch: &Scratch,
        surface: FlattenedSurface<'_>,
        (displaced, count): (&[(u32, u32)], u32),
    ) {
        let table = surface.table;
        let Self { numbers, ranks, quads, .. } = self;
        quads.clear();
        for &(_, number) in displaced {
            let rank = ranks[number as usize];
            let sign = measure.sign(table.vertices[rank as usize]);
            let triangles = if sign == 0 { &[] } else { table.triangles.row(rank as usize) };
            for &triangle in triangles {
                let corners = table.corners[triangle as usize];
                // A triangle belongs to the first of its displaced corners.
                let first = corners.iter().find(|&&corner| numbers[corner as usize] < count);
                if first != Some(&rank) {
                    continue;
                }
                let [a, b, c] = corners.map(|corner| {
                    let number = &mut numbers[corner as usize];
                    if *number == NONE {
                        *number = ranks.len() as u32;
                        ranks.push(corner);
                    }
                    *number
                });
                quads.push(if sign > 0 { [a, b, c, a] } else { [a, c, b, a] });
            }
        }
        self.add_motions(measure, scratch, surface);
    }
}
