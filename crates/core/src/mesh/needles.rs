//! Removes needles: triangles whose corners lie almost on a line, so that their normals mean nothing.

use std::collections::HashMap;

use nalgebra::Point3;

/// Maximum number of flips of an edge, per needle. Flips of needles beside each other can make new ones.
const FLIPS: usize = 4;

/// Replaces triangles that are less than `height` high by flips of their longest edges: the triangle beyond it is split
/// at the corner that lies on the edge. The surface moves by less than `height`, and stays closed where it is. Needles
/// at open edges are removed.
pub(crate) fn flip_needles(vertices: &[Point3<f64>], triangles: &mut Vec<[u32; 3]>, height: f64) {
    // The longest edge of a needle, from its first corner to its second.
    let as_needle = |[a, b, c]: [u32; 3]| {
        let [x, y, z] = [a, b, c].map(|corner| vertices[corner as usize]);
        let edges = [(y - x).norm_squared(), (z - y).norm_squared(), (x - z).norm_squared()];
        let longest = (0..3).fold(0, |longest, k| if edges[k] > edges[longest] { k } else { longest });
        let is_needle = (y - x).cross(&(z - x)).norm_squared() < height * height * edges[longest];
        is_needle.then(|| [[a, b, c], [b, c, a], [c, a, b]][longest])
    };
    let mut needles: Vec<usize> =
        (0..triangles.len()).filter(|&t| as_needle(triangles[t]).is_some()).collect();
    if needles.is_empty() {
        return;
    }
    let edges = |[a, b, c]: [u32; 3], place: usize| [(a, b), (b, c), (c, a)].map(|edge| (edge, place));
    let all = triangles.iter().enumerate().flat_map(|(place, triangle)| edges(*triangle, place));
    let mut owner: HashMap<(u32, u32), usize> = all.collect();
    for _ in 0..FLIPS * needles.len() {
        let Some(index) = needles.pop() else { break };
        let Some([p, q, b]) = as_needle(triangles[index]) else { continue };
        let Some(&other) = owner.get(&(q, p)) else { continue };
        let d = triangles[other].into_iter().find(|corner| ![p, q].contains(corner));
        let Some(d) = d.filter(|d| *d != b && other != index && !owner.contains_key(&(b, *d))) else {
            continue;
        };
        for edge in [(p, q), (q, p)] {
            owner.remove(&edge);
        }
        for (place, triangle) in [(index, [b, p, d]), (other, [q, b, d])] {
            triangles[place] = triangle;
            owner.extend(edges(triangle, place));
            if as_needle(triangle).is_some() {
                needles.push(place);
            }
        }
    }
    triangles.retain(|triangle| as_needle(*triangle).is_none());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangle_beyond_a_needle_is_split() {
        // A square of which one side has a further corner, filled by a needle.
        let p = |x: f64, y: f64| Point3::new(x, y, 0.0);
        let vertices = [p(0.0, 0.0), p(1.0, 0.0), p(1.0, 1.0), p(0.0, 1.0), p(0.4, 0.4 + 1e-9)];
        let mut triangles = vec![[0, 2, 4], [0, 1, 2], [0, 4, 3], [4, 2, 3]];
        flip_needles(&vertices, &mut triangles, 1e-6);
        triangles.sort_unstable();
        assert_eq!(triangles.len(), 4);
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|corner| vertices[corner as usize]);
            0.5 * (b - a).cross(&(c - a)).z
        };
        assert!(triangles.iter().all(|t| area(t) > 0.1), "{triangles:?}");
        assert!((triangles.iter().map(area).sum::<f64>() - 1.0).abs() < 1e-6);
    }
}
