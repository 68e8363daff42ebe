//! Places the vertices of skinned meshes by their joints.

use ::gltf::mesh::Semantic;
use ::gltf::{Primitive, Skin};
use nalgebra::{Matrix4, Vector4};

use super::super::error::Fault;
use super::accessors::{Accessors, Read};

/// The joints of the vertices of a primitive.
pub(super) struct Joints {
    /// The matrix of each joint: from the bind pose to its place.
    matrices: Vec<Matrix4<f64>>,
    sets: Vec<Set>,
}

/// Four joints of each vertex, and their weights.
struct Set {
    joints: Read<[u16; 4]>,
    weights: Read<[f32; 4]>,
}

impl Joints {
    /// Reads the joints of a primitive with `count` vertices. `element` describes it in messages.
    pub(super) fn read(
        skin: &Skin<'_>,
        (primitive, count, element): (&Primitive<'_>, usize, &str),
        places: &[Matrix4<f64>],
        accessors: &Accessors<'_>,
    ) -> Result<Self, Fault> {
        let mut matrices: Vec<Matrix4<f64>> = skin.joints().map(|joint| places[joint.index()]).collect();
        accessors.spend(matrices.len())?;
        if let Some(accessor) = skin.inverse_bind_matrices() {
            let name = format!("skin {}, inverse bind matrices", skin.index());
            let inverse = accessors.matrices(&accessor, &name)?;
            if inverse.len() < matrices.len() {
                return Err(Fault(format!(
                    "{name}: {} for {} joints; export it again",
                    inverse.len(),
                    matrices.len()
                )));
            }
            let bound = matrices.iter_mut().zip(inverse.iter());
            bound.for_each(|(matrix, inverse)| *matrix *= Matrix4::from(*inverse).cast::<f64>());
        }
        let mut sets = Vec::new();
        for set in 0.. {
            let of_set = (primitive.get(&Semantic::Joints(set)), primitive.get(&Semantic::Weights(set)));
            let (Some(joints), Some(weights)) = of_set else { break };
            let joints = accessors.joints(&joints, &format!("{element}, JOINTS_{set}"))?;
            let weights = accessors.weights(&weights, &format!("{element}, WEIGHTS_{set}"))?;
            if joints.len() < count || weights.len() < count {
                return Err(Fault(format!(
                    "{element} has fewer joints or weights than vertices; export it again"
                )));
            }
            sets.push(Set { joints, weights });
        }
        if sets.is_empty() {
            return Err(Fault(format!(
                "{element} has a skin, and no JOINTS_0 and WEIGHTS_0; export it again"
            )));
        }
        Ok(Self { matrices, sets })
    }

    /// Returns the matrix of a vertex: the weighted mean of those of its joints. `element` describes the vertex.
    pub(super) fn matrix(&self, vertex: usize, element: &dyn Fn() -> String) -> Result<Matrix4<f64>, Fault> {
        let (mut sum, mut total) = (Matrix4::zeros(), 0.0);
        for Set { joints, weights } in &self.sets {
            for (joint, weight) in joints[vertex].into_iter().zip(weights[vertex]) {
                if weight == 0.0 {
                    continue;
                }
                let matrix = self.matrices.get(usize::from(joint)).ok_or_else(|| {
                    let joints = self.matrices.len();
                    Fault(format!(
                        "{} has joint {joint} of {joints}, counted from 0; export it again",
                        element()
                    ))
                })?;
                sum += matrix * f64::from(weight);
                total += f64::from(weight);
            }
        }
        Ok(if total == 0.0 { Matrix4::identity() } else { sum / total })
    }
}

/// Returns the image of a point.
pub(super) fn transformed(matrix: &Matrix4<f64>, [x, y, z]: [f64; 3]) -> [f64; 3] {
    (matrix * Vector4::new(x, y, z, 1.0)).xyz().into()
}
