//! Finds which points are inside a surface.

use nalgebra::Point3;

use super::csr::Csr;
use super::description::OpenSurface;
use super::polygons::Mesh;
use super::winding_tree::WindingTree;

/// Rule by which points are inside a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Interior {
    /// The surface is closed. Points are inside where it winds around them.
    Closed,
    /// The surface is not closed, but encloses a space with openings, as a scan without a base does. Points are inside
    /// where the magnitude of the generalized winding number (Jacobson et al. 2013) exceeds 1/2.
    WindingNumber,
    /// The surface is a sheet, as a leaf or a cloth is. No point is inside.
    Sheet,
}

impl Interior {
    /// Returns the name of the rule in reports: `closed`, `winding_number` or `sheet`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Closed => "closed",
            Self::WindingNumber => "winding_number",
            Self::Sheet => "sheet",
        }
    }
}

/// Greatest amount by which the mean winding number on an open component may be below that on a closed surface, 1/2,
/// if the component encloses a space. On a flat sheet the difference is 1/2; on half of a sphere it is 0.2, on a cube
/// without one face 0.09.
const GREATEST_DEFICIT: f64 = 0.125;

/// Greatest mean number of solid angles for the winding number at a point, if a component encloses a space. It is a few
/// hundred where triangles are small beside the surface, and nearly all triangles where they cross the whole surface:
/// such surfaces enclose nothing, and the time of a lattice stays bounded.
const GREATEST_COST: f64 = 2048.0;

/// The same where it is more than half of the triangles.
const GREATEST_COST_OF_MOST: f64 = 512.0;

/// Greatest number of triangles of a component at which the winding number is computed, and of all components together.
const SAMPLES: (usize, usize) = (64, 8192);

impl Mesh {
    /// Returns the rule by which points are inside the surface. It is found at the first call and cached.
    pub fn interior(&self) -> Interior {
        match self.open_surface() {
            None => Interior::Closed,
            Some(OpenSurface { solid: Some(_), .. }) => Interior::WindingNumber,
            Some(OpenSurface { solid: None, .. }) => Interior::Sheet,
        }
    }

    /// Returns the parts of the surface, or `None` if it is closed.
    pub(crate) fn open_surface(&self) -> Option<&OpenSurface> {
        (!self.is_closed()).then(|| self.open.get_or_init(|| OpenSurface::new(self)))
    }
}

impl OpenSurface {
    /// Divides the components of a mesh into those that enclose a space and sheets.
    ///
    /// A component encloses a space if it is closed, or if the winding number of the whole surface at its triangles,
    /// without the triangle itself, is nearly 1/2 as on a closed surface, or -1/2 if the normals point inwards.
    /// Panels that are not joined enclose a space together. A greater number belongs to a surface that lies there
    /// twice, or of a sheet inside another surface; then the component alone decides.
    fn new(mesh: &Mesh) -> Self {
        let (surface, weld) = (mesh.surface(), mesh.weld());
        let (count, labels) = mesh.face_components();
        let label = |corner: u32| labels[weld[corner as usize] as usize];
        let members =
            Csr::sorted(count, (0..).zip(surface).map(|(index, triangle)| (label(triangle[0]), index)));
        let components = &mesh.topology().components;
        let corners = |triangle: &[u32; 3]| triangle.map(|corner| mesh.vertices()[corner as usize]);
        let tree = WindingTree::new(surface.iter().map(corners));
        let samples = (SAMPLES.1 / components.len()).clamp(1, SAMPLES.0);
        let cost = mean_cost(&tree, surface, corners);
        let is_of_most = cost > 0.5 * surface.len() as f64;
        let is_cheap = cost <= if is_of_most { GREATEST_COST_OF_MOST } else { GREATEST_COST };
        let mut is_solid = vec![false; count];
        for component in components {
            let Some(&corner) = mesh.face(component.first_face).first() else { continue };
            let label = label(corner) as usize;
            is_solid[label] = component.closed || {
                let members = members.row(label);
                let number = mean_number(&tree, surface, members, samples, corners).abs();
                let is_enough = |number: f64| number > 0.5 - GREATEST_DEFICIT;
                is_enough(number)
                    && is_cheap
                    && (number < 0.5 + GREATEST_DEFICIT || {
                        let own: Vec<_> = members.iter().map(|&index| surface[index as usize]).collect();
                        let tree = WindingTree::new(own.iter().map(corners));
                        let all: Vec<u32> = (0..own.len() as u32).collect();
                        is_enough(mean_number(&tree, &own, &all, samples, corners).abs())
                    })
            };
        }
        let is_solid = |triangle: &&[u32; 3]| is_solid[label(triangle[0]) as usize];
        let (solid, sheets): (Vec<_>, Vec<_>) = surface.iter().partition(|triangle| is_solid(triangle));
        let solid = match (solid.is_empty(), sheets.is_empty()) {
            (true, _) => None,
            (false, true) => Some(tree),
            (false, false) => Some(WindingTree::new(solid.iter().map(corners))),
        };
        Self { solid, sheets }
    }
}

/// Returns the mean number of solid angles for the winding number at some triangles.
fn mean_cost(
    tree: &WindingTree,
    surface: &[[u32; 3]],
    corners: impl Fn(&[u32; 3]) -> [Point3<f64>; 3],
) -> f64 {
    let step = surface.len().div_ceil(SAMPLES.0).max(1);
    let costs = surface.iter().step_by(step).map(|triangle| tree.cost(&corners(triangle)[0]) as f64);
    let (sum, count) = costs.fold((0.0, 0.0), |(sum, count), cost| (sum + cost, count + 1.0));
    sum / f64::max(count, 1.0)
}

/// Returns the mean of the winding number over some triangles, weighted by area, from samples at equal distances of
/// area.
fn mean_number(
    tree: &WindingTree,
    surface: &[[u32; 3]],
    members: &[u32],
    samples: usize,
    corners: impl Fn(&[u32; 3]) -> [Point3<f64>; 3],
) -> f64 {
    let triangle = |index: u32| corners(&surface[index as usize]);
    let area = |index: u32| {
        let [a, b, c] = triangle(index);
        (b - a).cross(&(c - a)).norm()
    };
    let total: f64 = members.iter().map(|&index| area(index)).sum();
    let (mut sum, mut taken, mut passed) = (0.0, 0, 0.0);
    for &index in members {
        passed += area(index);
        let reached = ((passed / total * samples as f64).round() as usize).min(samples);
        if reached > taken {
            let [a, b, c] = triangle(index).map(|corner| corner.coords);
            sum += (reached - taken) as f64 * tree.number(&Point3::from((a + b + c) / 3.0), Some(index));
            taken = reached;
        }
    }
    if taken > 0 { sum / taken as f64 } else { 0.0 }
}
