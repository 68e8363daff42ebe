//! Attributes of the surface of a body that breaks, whose faces differ between frames.

use std::path::Path;

use super::material::Materials;
use super::name::Names;
use super::pieces::{Places, TopologyPlace};
use super::prim::{Prim, Property, Stored, Value, face_varying, integers, subset_prim, token};
use crate::obj::{Document, cap_material};

/// The pieces of a body in all frames.
pub(super) struct SurfacePieces<'a> {
    /// For each frame, its topology: 0 if the body is whole, or 1 and the index in `topologies`.
    of_frame: Vec<usize>,
    topologies: Vec<&'a TopologyPlace>,
    /// Offset of each frame, and the field values of its points, velocities and normals if the body is broken.
    frames: Vec<(u64, Option<[u64; 3]>)>,
}

impl<'a> SurfacePieces<'a> {
    /// Returns the pieces of a body; `None` if it is whole in all frames.
    pub(super) fn new(places: &'a Places, body: usize) -> Option<Self> {
        let mut pieces = Self {
            of_frame: vec![0; places.starts.len()],
            topologies: Vec::new(),
            frames: places.starts.iter().map(|start| (*start, None)).collect(),
        };
        for place in places.pieces.iter().filter(|place| place.body == body) {
            pieces.topologies.extend(&place.topology);
            pieces.of_frame[place.frame] = pieces.topologies.len();
            pieces.frames[place.frame].1 = Some([place.points, place.velocities, place.normals]);
        }
        (!pieces.topologies.is_empty()).then_some(pieces)
    }

    /// Returns an attribute with a value for the whole body and one for each topology.
    fn attribute(
        &self,
        (type_name, name): (&str, &str),
        whole: Value,
        of_topology: impl Fn(&TopologyPlace) -> Value,
    ) -> Property {
        let values =
            std::iter::once(whole).chain(self.topologies.iter().map(|place| of_topology(place))).collect();
        Property::chosen(type_name, name, values, &self.of_frame)
    }

    /// Adds the attributes of the mesh that the topology determines. `counts` and `corners`: those of the whole body.
    pub(super) fn with_faces(&self, prim: Prim, counts: Vec<i32>, corners: Vec<i32>) -> Prim {
        let counts = self.attribute(("int[]", "faceVertexCounts"), Value::Integers(counts), |place| {
            Value::Written(place.counts)
        });
        let corners = self.attribute(("int[]", "faceVertexIndices"), Value::Integers(corners), |place| {
            Value::Written(place.corners)
        });
        prim.property(counts).property(corners)
    }

    /// Adds the points with their bounds and velocities, and the normals, each with the index of each corner of the
    /// whole body.
    pub(super) fn with_points(
        &self,
        prim: Prim,
        (points, bounds, velocities): (Stored, Stored, Option<Stored>),
        normals: Option<(Vec<i32>, Stored)>,
    ) -> Prim {
        let every: Vec<usize> = (0..self.frames.len()).collect();
        // `array`: index of the field value of a broken body.
        let of_frames = |(type_name, name): (&str, &str), whole: Stored, array: usize| {
            let values = self.frames.iter().map(|(start, broken)| {
                Value::Written(broken.map_or(whole.in_frame(*start), |arrays| arrays[array]))
            });
            Property::chosen(type_name, name, values.collect(), &every)
        };
        let prim = prim.animated("float3[]", "extent", bounds).property(of_frames(
            ("point3f[]", "points"),
            points,
            0,
        ));
        let prim = match velocities {
            Some(stored) => prim.property(of_frames(("vector3f[]", "velocities"), stored, 1)),
            None => prim,
        };
        let Some((whole, stored)) = normals else { return prim };
        let normals = of_frames(("normal3f[]", "primvars:normals"), stored, 2);
        let indices =
            self.attribute(("int[]", "primvars:normals:indices"), Value::Integers(whole), |place| {
                Value::Written(place.normals)
            });
        prim.property(normals.with("interpolation", face_varying())).property(indices)
    }

    /// Adds the texture coordinates of the corners. `whole`: those of the whole body.
    pub(super) fn with_textures(&self, prim: Prim, whole: Vec<[f32; 2]>) -> Prim {
        let textures = self.attribute(("texCoord2f[]", "primvars:st"), Value::Vectors2(whole), |place| {
            Value::Written(place.textures)
        });
        prim.property(textures.with("interpolation", face_varying()))
    }

    /// Returns the prim of some faces of the whole body, and of their parts.
    pub(super) fn subset(&self, name: &str, faces: &[u32], family: &str, names: &mut Names) -> Prim {
        let largest = faces.iter().max().map_or(0, |face| *face as usize + 1);
        let mut is_inside = vec![false; largest];
        faces.iter().for_each(|&face| is_inside[face as usize] = true);
        self.subset_of(name, (integers(faces), family), names, |source| {
            usize::try_from(source).is_ok_and(|face| is_inside.get(face) == Some(&true))
        })
    }

    /// Adds the caps of the body `name`, with a material of their own: that of the libraries of its file, or a gray one.
    pub(super) fn with_caps<'m>(
        &self,
        prim: &mut Prim,
        (name, document): (&str, Option<&'m Document>),
        materials: &mut Materials<'m>,
        names: &mut Names,
    ) {
        let body = name;
        let name = cap_material(body);
        let color = document.and_then(|document| document.material_colors().remove(&name));
        let file = document.map_or(Path::new(""), Document::path);
        let path = materials.path_of(file, &name, &color.unwrap_or_default(), body);
        let whole = (Value::Integers(Vec::new()), "materialBind");
        let caps = self.subset_of(&name, whole, names, |source| source < 0);
        prim.children.push(caps.bound(&path));
        let family = "subsetFamily:materialBind:familyType";
        if !prim.properties.iter().any(|property| property.name == family) {
            let kind = Property::attribute("token", family, token("nonOverlapping"));
            prim.properties.push(kind.with("variability", Value::Uniform));
        }
    }

    fn subset_of(
        &self,
        name: &str,
        (whole, family): (Value, &str),
        names: &mut Names,
        contains: impl Fn(i32) -> bool,
    ) -> Prim {
        let indices = self.attribute(("int[]", "indices"), whole, |place| {
            let faces = (0..).zip(&place.sources).filter(|(_, source)| contains(**source));
            Value::Integers(faces.map(|(face, _)| face).collect())
        });
        subset_prim(name, family, names).property(indices)
    }
}
