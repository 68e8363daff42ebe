//! Prims of the surfaces of bodies.

use std::collections::BTreeMap;
use std::sync::Arc;

use supple::mesh::Mesh;

use super::layout::Layout;
use super::material::Materials;
use super::name::Names;
use super::prim::{Prim, Property, Stored, Value, face_varying, integers, subset_prim, token};
use super::surface_pieces::SurfacePieces;
use crate::obj::{Appearance, Document, Part};

/// Input of a body: its mesh, or the part of an OBJ file that it is.
pub(crate) type BodyInput = (Mesh, Option<(Arc<Document>, Part)>);

/// The surface of a body, and the places of its values in the frames.
#[derive(Debug)]
pub(crate) struct Surface {
    name: String,
    mesh: Mesh,
    /// The OBJ file with the texture coordinates, materials and groups; `None` for a mesh of arrays.
    file: Option<(Arc<Document>, Part)>,
    normals: Option<(Normals, Stored)>,
    pub(super) points: Stored,
    pub(super) bounds: Stored,
    /// The velocities of the points, if the frames have them.
    velocities: Option<Stored>,
}

/// The normals of a surface: `vn` of its file.
#[derive(Debug)]
pub(super) struct Normals {
    /// Index of the `vn` of each normal, from 0.
    pub(super) vn: Vec<u32>,
    /// For each corner of the faces, the index of its normal; `None` if there is one normal per vertex.
    corners: Option<Vec<i32>>,
}

impl Normals {
    /// Returns the normals of a part of a file; `None` if a face has none.
    fn new(document: &Document, part: &Part) -> Option<Self> {
        const NONE: u32 = u32::MAX;
        let mut of_vertex = vec![NONE; part.mesh().vertices().len()];
        let mut index_of = vec![NONE; document.normal_count()];
        let (mut vn, mut corners, mut is_smooth) = (Vec::new(), Vec::new(), true);
        for (face, in_file) in part.mesh().faces().zip(part.faces()) {
            for (&vertex, &normal) in face.iter().zip(document.face_normals(in_file)?) {
                let (known, index) = (&mut of_vertex[vertex as usize], &mut index_of[normal as usize]);
                is_smooth &= *known == NONE || *known == normal;
                *known = normal;
                if *index == NONE {
                    *index = vn.len() as u32;
                    vn.push(normal);
                }
                corners.push(*index as i32);
            }
        }
        if is_smooth && !of_vertex.contains(&NONE) {
            return Some(Self { vn: of_vertex, corners: None });
        }
        Some(Self { vn, corners: Some(corners) })
    }
}

impl Surface {
    pub(super) fn new(
        name: &str,
        (mesh, file): BodyInput,
        has_velocities: bool,
        layout: &mut Layout,
    ) -> Self {
        let points = layout.add_vectors(mesh.vertices().len());
        let bounds = layout.add_vectors(2);
        let velocities = has_velocities.then(|| layout.add_vectors(mesh.vertices().len()));
        let normals = file.as_ref().and_then(|(document, part)| Normals::new(document, part));
        let normals = normals.map(|normals| {
            let stored = layout.add_vectors(normals.vn.len());
            (normals, stored)
        });
        Self { name: name.to_owned(), mesh, file, normals, points, bounds, velocities }
    }

    /// Returns the `vn` of its file, from 0, of each normal in a frame; `None` if the frames have no normals.
    pub(crate) fn normals(&self) -> Option<&[u32]> {
        self.normals.as_ref().map(|(normals, _)| &normals.vn[..])
    }

    /// Returns the name of the body.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Returns the number of points.
    pub(crate) fn points(&self) -> usize {
        self.mesh.vertices().len()
    }

    /// Returns the prim. `names` are those of its siblings, and `pieces` those of a body that breaks.
    pub(super) fn prim<'a>(
        &'a self,
        names: &mut Names,
        materials: &mut Materials<'a>,
        pieces: Option<&SurfacePieces<'_>>,
    ) -> Prim {
        let prim = match pieces {
            None => self.with_points(names),
            Some(pieces) => {
                let (counts, corners) = faces(&self.mesh);
                let prim =
                    Prim::new("Mesh", &self.name, names).uniform("bool", "doubleSided", is_open(&self.mesh));
                let prim = pieces.with_faces(prim, counts, corners.clone());
                let prim = prim.uniform("token", "subdivisionScheme", token("none"));
                let normals = self.normals.as_ref().map(|(Normals { corners: of_corner, .. }, stored)| {
                    (of_corner.clone().unwrap_or(corners), *stored)
                });
                pieces.with_points(prim, (self.points, self.bounds, self.velocities), normals)
            }
        };
        let mut subset_names = Names::default();
        let prim = match pieces {
            Some(pieces) => pieces.with_textures(prim, self.textures()),
            None => prim,
        };
        let mut prim = match &self.file {
            None => prim,
            Some((document, part)) => {
                self.with_file(prim, (document, part), materials, (&mut subset_names, pieces))
            }
        };
        if let Some(pieces) = pieces {
            let document = self.file.as_ref().map(|(document, _)| &**document);
            pieces.with_caps(&mut prim, (&self.name, document), materials, &mut subset_names);
        }
        prim
    }

    /// Returns the texture coordinates of all corners; zero if the input has none.
    fn textures(&self) -> Vec<[f32; 2]> {
        let appearance = self.file.as_ref().map(|(document, part)| document.appearance(part));
        match appearance {
            Some(Appearance { corners, coordinates, .. }) if !corners.is_empty() => {
                corners.iter().map(|&corner| coordinates[corner as usize]).collect()
            }
            _ => vec![[0.0; 2]; self.mesh.faces().map(<[u32]>::len).sum()],
        }
    }

    /// Returns the prim of a whole body with its points and normals.
    fn with_points(&self, names: &mut Names) -> Prim {
        let prim = mesh_prim(&self.name, names, &self.mesh)
            .animated("float3[]", "extent", self.bounds)
            .animated("point3f[]", "points", self.points);
        let prim = match self.velocities {
            Some(stored) => prim.animated("vector3f[]", "velocities", stored),
            None => prim,
        };
        match &self.normals {
            None => prim,
            Some((Normals { corners: None, .. }, stored)) => {
                let normals = Property::animated("normal3f[]", "normals", *stored);
                prim.property(normals.with("interpolation", Value::Token("vertex".to_owned())))
            }
            Some((Normals { corners: Some(corners), .. }, stored)) => {
                let normals = Property::animated("normal3f[]", "primvars:normals", *stored);
                prim.property(normals.with("interpolation", face_varying())).constant(
                    "int[]",
                    "primvars:normals:indices",
                    Value::Integers(corners.clone()),
                )
            }
        }
    }

    /// Adds the texture coordinates, materials and groups of the file.
    fn with_file<'a>(
        &self,
        mut prim: Prim,
        (document, part): (&'a Document, &Part),
        materials: &mut Materials<'a>,
        (names, pieces): (&mut Names, Option<&SurfacePieces<'_>>),
    ) -> Prim {
        let appearance = document.appearance(part);
        let subset = |name: &str, faces: &[u32], family: &str, names: &mut Names| match pieces {
            Some(pieces) => pieces.subset(name, faces, family, names),
            None => subset_prim(name, family, names).constant("int[]", "indices", integers(faces)),
        };
        if pieces.is_none() && !appearance.corners.is_empty() {
            let coordinates = Value::Vectors2(appearance.coordinates);
            let coordinates = Property::attribute("texCoord2f[]", "primvars:st", coordinates);
            prim = prim.property(coordinates.with("interpolation", face_varying())).constant(
                "int[]",
                "primvars:st:indices",
                integers(&appearance.corners),
            );
        }
        let colors =
            if appearance.materials.is_empty() { BTreeMap::new() } else { document.material_colors() };
        let mut subsets = Vec::new();
        for (name, faces) in &appearance.materials {
            let color = colors.get(name).cloned().unwrap_or_default();
            let path = materials.path_of(document.path(), name, &color, &self.name);
            if faces.len() == self.mesh.face_count() {
                prim = prim.bound(&path);
            } else {
                subsets.push(subset(name, faces, "materialBind", names).bound(&path));
            }
        }
        if !subsets.is_empty() {
            prim = prim.uniform("token", "subsetFamily:materialBind:familyType", token("nonOverlapping"));
        }
        let groups = groups(document, part);
        if !groups.is_empty() {
            prim = prim.uniform("token", "subsetFamily:group:familyType", token("unrestricted"));
        }
        subsets.extend(groups.iter().map(|(name, faces)| subset(name, faces, "group", names)));
        prim.children = subsets;
        prim
    }
}

/// Returns the objects and groups of a file that contain some of the faces of a part, with these faces. An object that
/// contains all faces is the body itself.
fn groups<'a>(document: &'a Document, part: &Part) -> Vec<(&'a str, Vec<u32>)> {
    let in_file: Vec<u32> = part.faces().collect();
    let groups = document.groups().map(|group| {
        let faces = group.faces.iter().flat_map(|range| {
            // The faces of a part are in the order of the file.
            let position = |face: u32| in_file.partition_point(|&other| other < face) as u32;
            position(range.start)..position(range.end)
        });
        (group, faces.collect::<Vec<u32>>())
    });
    let some = groups
        .filter(|(group, faces)| !faces.is_empty() && (!group.is_object || faces.len() < in_file.len()));
    some.map(|(group, faces)| (group.name.as_str(), faces)).collect()
}

/// Returns a mesh without points. It is shown as it is, and from both sides if it is open.
pub(super) fn mesh_prim(name: &str, names: &mut Names, mesh: &Mesh) -> Prim {
    let (counts, indices) = faces(mesh);
    Prim::new("Mesh", name, names)
        .uniform("bool", "doubleSided", is_open(mesh))
        .constant("int[]", "faceVertexCounts", Value::Integers(counts))
        .constant("int[]", "faceVertexIndices", Value::Integers(indices))
        .uniform("token", "subdivisionScheme", token("none"))
}

fn is_open(mesh: &Mesh) -> Value {
    Value::Bool(!mesh.is_closed())
}

/// Returns the numbers of corners of the faces, and all corners.
fn faces(mesh: &Mesh) -> (Vec<i32>, Vec<i32>) {
    let counts = mesh.faces().map(|face| face.len() as i32).collect();
    (counts, mesh.faces().flatten().map(|&corner| corner as i32).collect())
}
