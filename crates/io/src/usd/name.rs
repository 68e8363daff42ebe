//! Names of prims.

use std::collections::HashSet;

/// The names of the children of a prim.
#[derive(Debug, Default)]
pub(super) struct Names(HashSet<String>);

impl Names {
    /// Returns an identifier like `name` that no other child has: ASCII letters, digits and `_`, not beginning with a
    /// digit. Other characters become `_`, because many programs refuse them; a number makes it unique.
    pub(super) fn unique(&mut self, name: &str) -> String {
        let valid = |character: char| if character.is_ascii_alphanumeric() { character } else { '_' };
        let mut identifier: String = name.chars().map(valid).collect();
        if identifier.starts_with(|first: char| first.is_ascii_digit()) || identifier.is_empty() {
            identifier.insert(0, '_');
        }
        let mut unique = identifier.clone();
        let mut number = 1;
        while !self.0.insert(unique.clone()) {
            number += 1;
            unique = format!("{identifier}_{number}");
        }
        unique
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_identifiers() {
        let mut names = Names::default();
        let found = ["bust", "bust", "bust_2", "2nd.bust", "", "_", "кот"].map(|name| names.unique(name));
        assert_eq!(found, ["bust", "bust_2", "bust_2_2", "_2nd_bust", "_", "__2", "___"]);
    }
}
