//! Union-find (disjoint sets) over numbered elements.

/// Disjoint sets of the elements `0..n`. The root of a set is its lowest element.
#[derive(Debug, Default)]
pub(crate) struct UnionFind {
    parent: Vec<u32>,
}

impl UnionFind {
    /// Builds `n` sets of one element each.
    pub(crate) fn new(n: usize) -> Self {
        Self { parent: (0..n as u32).collect() }
    }

    /// Replaces the sets by `n` sets of one element each. Keeps the buffer.
    pub(crate) fn reset(&mut self, n: usize) {
        self.parent.clear();
        self.parent.extend(0..n as u32);
    }

    /// Returns the lowest element of the set that contains `element`. Shortens the paths in the set.
    pub(crate) fn find(&mut self, mut element: u32) -> u32 {
        loop {
            let parent = self.parent[element as usize];
            if parent == element {
                return element;
            }
            let grandparent = self.parent[parent as usize];
            self.parent[element as usize] = grandparent;
            element = grandparent;
        }
    }

    /// Unites the sets of two elements. Returns false if the elements are in the same set already.
    pub(crate) fn unite(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b) as usize] = a.min(b);
        a != b
    }

    /// Returns the number of sets, and the number of the set of each element. Sets are numbered from 0 in the
    /// order of their lowest elements.
    pub(crate) fn labels(mut self) -> (usize, Vec<u32>) {
        let mut count = 0;
        let mut labels = vec![0; self.parent.len()];
        for element in 0..self.parent.len() {
            let root = self.find(element as u32) as usize;
            if root == element {
                labels[element] = count;
                count += 1;
            } else {
                labels[element] = labels[root];
            }
        }
        (count as usize, labels)
    }
}
