//! Reads the texture coordinates and the materials of the faces of a file, in a pass of its own, because most formats
//! of frames need neither.

use std::collections::HashMap;

use super::corner;
use super::lines::{Statements, Words, decode};
use super::numbers::finite_or_zero;
use super::{Document, Part};

/// Texture coordinates and materials of the faces of a part.
#[derive(Debug, Default)]
#[non_exhaustive]
pub struct Appearance {
    /// The `vt` that corners use: u and v. The origin is at the lower left of the image.
    pub coordinates: Vec<[f32; 2]>,
    /// For each corner of the faces in their order, its index in `coordinates`; empty if no corner has a `vt`. A
    /// corner without a `vt` has coordinates of its own, (0, 0).
    pub corners: Vec<u32>,
    /// Materials that faces use, by the names in `usemtl` statements, each with its faces in the body, in order.
    pub materials: Vec<(String, Vec<u32>)>,
}

/// Marks a face that is not part of the body.
const OTHER: u32 = u32::MAX;

impl Document {
    /// Returns the texture coordinates and materials of a part of the file.
    pub fn appearance(&self, part: &Part) -> Appearance {
        let mut face_of = vec![OTHER; self.face_count()];
        for (face, in_file) in (0..).zip(part.faces()) {
            face_of[in_file as usize] = face;
        }
        let coordinates = self.texture_coordinates();
        let mut found = Appearance::default();
        // For each `vt`, its index in the appearance.
        let mut index_of: HashMap<i64, u32> = HashMap::new();
        let mut materials: HashMap<Vec<u8>, usize> = HashMap::new();
        let (mut material, mut face, mut textures) = (None, 0, 0_i64);
        let (mut corners, mut any) = (Vec::new(), false);
        for statement in Statements::new(self.bytes()) {
            let mut words = Words::new(self.bytes(), &statement.bytes);
            let Some(keyword) = words.next() else { continue };
            match &self.bytes()[keyword] {
                b"vt" => textures += 1,
                b"usemtl" => {
                    let name = self.bytes()[words.rest()].to_vec();
                    material = (!name.is_empty()).then(|| {
                        let text = decode(&name).into_owned();
                        *materials.entry(name).or_insert_with(|| {
                            found.materials.push((text, Vec::new()));
                            found.materials.len() - 1
                        })
                    });
                }
                b"f" | b"fo" => {
                    corners.clear();
                    corners.extend(words.map(|word| {
                        let texture = corner::parse(&self.bytes()[word]).and_then(|corner| corner.texture);
                        texture.map_or(0, |index| if index < 0 { textures + 1 + index } else { index })
                    }));
                    if corners.len() < 3 {
                        continue;
                    }
                    face += 1;
                    if face_of[face - 1] == OTHER {
                        continue;
                    }
                    if let Some(material) = material {
                        found.materials[material].1.push(face_of[face - 1]);
                    }
                    for &texture in &corners {
                        any |= texture > 0;
                        let next = index_of.len() as u32;
                        let index = *index_of.entry(texture).or_insert(next);
                        if index == next {
                            let value = coordinates.get(texture as usize).copied();
                            found.coordinates.push(value.unwrap_or_default());
                        }
                        found.corners.push(index);
                    }
                }
                _ => {}
            }
        }
        if !any {
            (found.coordinates, found.corners) = (Vec::new(), Vec::new());
        }
        found.materials.retain(|(_, faces)| !faces.is_empty());
        found
    }

    /// Returns the color (`Kd`) of the material of each face of a part; `None` for faces without one. Images are left out.
    pub(crate) fn face_colors(&self, part: &Part) -> Vec<Option<[f32; 3]>> {
        let mut colors = vec![None; part.mesh().face_count()];
        let materials = self.material_colors();
        for (name, faces) in self.appearance(part).materials {
            let Some(material) = materials.get(&name) else { continue };
            for face in faces {
                colors[face as usize] = Some(material.diffuse);
            }
        }
        colors
    }

    /// Returns the first two numbers of each `vt`, after an entry for corners without one. Text that is not a finite
    /// number counts as 0.
    pub(crate) fn texture_coordinates(&self) -> Vec<[f32; 2]> {
        let mut coordinates = vec![[0.0; 2]];
        for statement in Statements::new(self.bytes()) {
            let mut words = Words::new(self.bytes(), &statement.bytes);
            if words.next().is_some_and(|keyword| &self.bytes()[keyword] == b"vt") {
                coordinates.push(
                    [(); 2].map(|()| words.next().map_or(0.0, |word| finite_or_zero(&self.bytes()[word]))),
                );
            }
        }
        coordinates
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0 0.5\nvt 1 1\n\
        o left\nf 1/1 2/2 3/3\nusemtl red paint\nf 1/-3 3/-1 4\nf 1 2\n\
        vt 0.25 x\no right\nusemtl blue\nf 4/4 3/3 2/2\nusemtl red paint\nf 1 2 3 4\n";

    fn appearance(object: Option<&str>) -> Appearance {
        let document = Document::from_bytes("a.obj", TEXT.into()).unwrap();
        let part = document.part(object).unwrap();
        document.appearance(&part)
    }

    fn corners(appearance: &Appearance) -> Vec<[f32; 2]> {
        appearance.corners.iter().map(|&corner| appearance.coordinates[corner as usize]).collect()
    }

    #[test]
    fn corners_have_the_coordinates_of_their_vt() {
        let whole = appearance(None);
        let [a, b, c, d, none] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.25, 0.0], [0.0, 0.0]];
        assert_eq!(corners(&whole), [a, b, c, a, c, none, d, c, b, none, none, none, none]);
        assert_eq!(corners(&appearance(Some("right"))), [d, c, b, none, none, none, none]);
    }

    #[test]
    fn materials_have_the_faces_after_their_statements() {
        let named = |name: &str, faces: &[u32]| (name.to_owned(), faces.to_vec());
        assert_eq!(appearance(None).materials, [named("red paint", &[1, 3]), named("blue", &[2])]);
        assert_eq!(appearance(Some("right")).materials, [named("red paint", &[1]), named("blue", &[0])]);
        assert_eq!(appearance(Some("left")).materials, [named("red paint", &[1])]);
    }

    #[test]
    fn a_file_without_vt_has_no_coordinates() {
        let document = Document::from_bytes("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".into()).unwrap();
        let found = document.appearance(&document.part(None).unwrap());
        assert!(found.coordinates.is_empty() && found.corners.is_empty() && found.materials.is_empty());
    }
}
