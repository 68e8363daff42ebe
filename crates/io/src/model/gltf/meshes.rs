//! Appends the meshes of nodes to a surface.

use ::gltf::mesh::{Mode, Semantic};
use ::gltf::{Node, Primitive};
use nalgebra::Matrix4;

use super::super::error::Fault;
use super::super::surface::{NO_TEXTURE, Surface, checked, finite};
use super::super::weld::Weld;
use super::accessors::{Accessors, Read};
use super::maps::Maps;
use super::materials::Materials;
use super::skin::{Joints, transformed};
use crate::count::counted;

/// Builds the surface of a file.
pub(super) struct Meshes<'a> {
    accessors: &'a Accessors<'a>,
    surface: Surface,
    materials: Materials<'a>,
    maps: Maps,
    /// Number of primitives of points or lines.
    lines: usize,
}

/// A primitive at the place of a node.
struct Shown<'p> {
    primitive: Primitive<'p>,
    /// Description in messages, such as `mesh 2, primitive 0`.
    element: String,
    /// Positions of the vertices in the mesh.
    positions: Read<[f32; 3]>,
    /// Displacements of the vertices, with their weights.
    morphs: Vec<(Read<[f32; 3]>, f64)>,
    joints: Option<Joints>,
    place: Matrix4<f64>,
}

impl<'a> Meshes<'a> {
    pub(super) fn new(materials: Materials<'a>, accessors: &'a Accessors<'a>) -> Self {
        let maps = Maps::new(accessors.left());
        Self { accessors, surface: Surface::default(), materials, maps, lines: 0 }
    }

    /// Appends the mesh of a node, if it has one. `places` are those of all nodes.
    pub(super) fn append(&mut self, node: &Node<'_>, places: &[Matrix4<f64>]) -> Result<(), Fault> {
        let Some(mesh) = node.mesh() else { return Ok(()) };
        let name =
            node.name().or(mesh.name()).map_or_else(|| format!("mesh {}", mesh.index()), str::to_owned);
        let mut weld = Weld::default();
        for primitive in mesh.primitives() {
            if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
                self.lines += 1;
                continue;
            }
            let material = self.materials.index(&primitive.material());
            self.surface.start(&name, material);
            let element = format!("mesh {}, primitive {}", mesh.index(), primitive.index());
            let weights = node.weights().or(mesh.weights()).unwrap_or_default();
            let shown = self.shown(node, primitive, (element, weights), places)?;
            self.append_primitive(&shown, &mut weld)?;
        }
        Ok(())
    }

    /// Reads the vertices of a primitive.
    fn shown<'p>(
        &self,
        node: &Node<'_>,
        primitive: Primitive<'p>,
        (element, weights): (String, &[f32]),
        places: &[Matrix4<f64>],
    ) -> Result<Shown<'p>, Fault> {
        let accessors = self.accessors;
        let missing = || Fault(format!("{element} has no POSITION; export it again"));
        let accessor = primitive.get(&Semantic::Positions).ok_or_else(missing)?;
        let positions = accessors.positions(&accessor, &format!("{element}, POSITION"))?;
        let mut morphs = Vec::new();
        for (index, (target, &weight)) in primitive.morph_targets().zip(weights).enumerate() {
            let Some(accessor) = target.positions().filter(|_| weight != 0.0) else { continue };
            let moved = accessors.positions(&accessor, &format!("{element}, morph target {index}"))?;
            if moved.len() < positions.len() {
                return Err(Fault(format!(
                    "{element}, morph target {index} has {} displacements for {} vertices; export it again",
                    moved.len(),
                    positions.len()
                )));
            }
            morphs.push((moved, f64::from(weight)));
        }
        let of_primitive = (&primitive, positions.len(), &*element);
        let joints =
            node.skin().map(|skin| Joints::read(&skin, of_primitive, places, accessors)).transpose()?;
        Ok(Shown { element, positions, morphs, joints, place: places[node.index()], primitive })
    }

    /// Appends the vertices that a primitive uses, in their order, and its triangles.
    fn append_primitive(&mut self, shown: &Shown<'_>, weld: &mut Weld) -> Result<(), Fault> {
        let (element, count) = (&shown.element, shown.positions.len());
        let indices = match shown.primitive.indices() {
            Some(accessor) => self.accessors.indices(&accessor, &format!("{element}, indices"))?,
            None => {
                self.accessors.spend(count)?;
                (0..count as u32).collect()
            }
        };
        if let Some(at) = indices.iter().position(|&index| index as usize >= count) {
            return Err(Fault(format!(
                "{element}: index {at} refers to vertex {} of {count}, both counted from 0; export it again",
                indices[at]
            )));
        }
        let mut used = indices.clone();
        used.sort_unstable();
        used.dedup();
        self.accessors.spend(used.len().saturating_mul(shown.morphs.len()))?;
        let mut vertices = Vec::with_capacity(used.len());
        let first = self.surface.positions.len();
        for &index in &used {
            let name = || format!("{element}, vertex {index}");
            let position = checked(shown.position(index as usize, &name)?, name)?;
            vertices.push(weld.vertex(position, &mut self.surface.positions));
        }
        self.append_maps(shown, first, used.iter().copied().zip(vertices.iter().copied()))?;
        let start = self.append_coordinates(shown, &used)?;
        let corner = |index: u32| {
            let at =
                if used.len() == count { index as usize } else { used.partition_point(|&used| used < index) };
            (vertices[at], start.map_or(NO_TEXTURE, |start| start + at as u32))
        };
        let is_mirrored = shown.joints.is_none() && shown.place.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
        for [a, b, c] in triangles(shown.primitive.mode(), &indices) {
            let [b, c] = if is_mirrored { [c, b] } else { [b, c] };
            self.surface.push_face([a, b, c].into_iter().map(corner));
        }
        Ok(())
    }

    /// Appends the maps of the vertices from `first` on. `vertices` are the used vertices of the primitive with their indices
    /// in the surface, of which those before the first are welded to another one.
    fn append_maps(
        &mut self,
        shown: &Shown<'_>,
        first: usize,
        vertices: impl Iterator<Item = (u32, u32)>,
    ) -> Result<(), Fault> {
        let mut next = first as u32;
        let is_new = |&(_, vertex): &(u32, u32)| {
            let is_new = vertex == next;
            next += u32::from(is_new);
            is_new
        };
        let new: Vec<u32> = vertices.filter(is_new).map(|(index, _)| index).collect();
        let of_primitive = (&shown.primitive, shown.positions.len(), &*shown.element);
        self.maps.append(self.accessors, of_primitive, (first, &new))
    }

    /// Appends the texture coordinates of the used vertices, if there are any. Returns the index of the first.
    fn append_coordinates(&mut self, shown: &Shown<'_>, used: &[u32]) -> Result<Option<u32>, Fault> {
        let base = shown.primitive.material().pbr_metallic_roughness();
        let set = base.base_color_texture().map_or(0, |texture| texture.tex_coord());
        let Some(accessor) = shown.primitive.get(&Semantic::TexCoords(set)) else { return Ok(None) };
        let element = format!("{}, TEXCOORD_{set}", shown.element);
        let coordinates = self.accessors.coordinates(&accessor, &element)?;
        if coordinates.len() < shown.positions.len() {
            return Err(Fault(format!("{element}: fewer than vertices; export it again")));
        }
        let start = self.surface.coordinates.len() as u32;
        // The origin of glTF is at the upper left.
        let turned = used.iter().map(|&index| coordinates[index as usize]).map(|[u, v]| finite([u, 1.0 - v]));
        self.surface.coordinates.extend(turned);
        Ok(Some(start))
    }

    /// Returns the surface.
    pub(super) fn finish(self) -> Result<Surface, Fault> {
        let Self { mut surface, materials, maps, lines, .. } = self;
        if surface.face_count() == 0 {
            return Err(Fault(match lines {
                0 => "no mesh with triangles in its scene; export one".to_owned(),
                _ => "only points and lines in its scene; export triangles".to_owned(),
            }));
        }
        if lines > 0 {
            surface.ignored.push(format!("{} of points or lines", counted(lines, "primitive")));
        }
        if materials.images > 0 {
            surface
                .ignored
                .push(format!("{} missing, or neither PNG nor JPEG", counted(materials.images, "image")));
        }
        surface.materials = materials.all;
        maps.finish(&mut surface);
        Ok(surface)
    }
}

impl Shown<'_> {
    /// Returns the position of a vertex in the scene. The place of the node of a skinned mesh has no effect (glTF 2.0,
    /// 3.7.3.3).
    fn position(&self, vertex: usize, element: &dyn Fn() -> String) -> Result<[f64; 3], Fault> {
        let mut position = self.positions[vertex].map(f64::from);
        for (moved, weight) in &self.morphs {
            for (x, by) in position.iter_mut().zip(moved[vertex]) {
                *x += weight * f64::from(by);
            }
        }
        match &self.joints {
            None => Ok(transformed(&self.place, position)),
            Some(joints) => Ok(transformed(&joints.matrix(vertex, element)?, position)),
        }
    }
}

/// Returns the triangles of a list, a strip or a fan of corners (glTF 2.0, 3.7.2.1). Triangles of strips and fans with two
/// equal corners, which join parts, are left out.
fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    let mut triangles: Vec<[u32; 3]> = match mode {
        Mode::TriangleStrip => {
            let turned = |(place, corners): (usize, &[u32])| match place % 2 {
                0 => [corners[0], corners[1], corners[2]],
                _ => [corners[0], corners[2], corners[1]],
            };
            indices.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => {
            indices.windows(2).skip(1).map(|corners| [corners[0], corners[1], indices[0]]).collect()
        }
        _ => return indices.as_chunks().0.to_vec(),
    };
    triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_have_one_orientation() {
        assert_eq!(triangles(Mode::Triangles, &[0, 1, 2, 2, 1, 3, 4]), [[0, 1, 2], [2, 1, 3]]);
        assert_eq!(triangles(Mode::TriangleStrip, &[0, 1, 2, 3, 3, 4]), [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(triangles(Mode::TriangleFan, &[0, 1, 2, 3]), [[1, 2, 0], [2, 3, 0]]);
        assert!(
            triangles(Mode::TriangleStrip, &[0, 1]).is_empty()
                && triangles(Mode::TriangleFan, &[]).is_empty()
        );
    }
}
