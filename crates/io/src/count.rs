//! Formats counts for messages.

/// Formats a count and its noun: `1 frame`, `2 frames`, `1 lattice vertex`, `2 lattice vertices`, `2 bodies`.
pub fn counted(count: usize, singular: &str) -> String {
    match (count, singular.strip_suffix("vertex")) {
        (1, _) => format!("1 {singular}"),
        (_, Some(start)) => format!("{count} {start}vertices"),
        (_, None) if singular == "body" => format!("{count} bodies"),
        _ => format!("{count} {singular}s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_of_one_have_a_singular_noun() {
        assert_eq!([0, 1, 2].map(|count| counted(count, "cell")), ["0 cells", "1 cell", "2 cells"]);
        assert_eq!([1, 2].map(|count| counted(count, "mesh vertex")), ["1 mesh vertex", "2 mesh vertices"]);
        assert_eq!([1, 2].map(|count| counted(count, "body")), ["1 body", "2 bodies"]);
    }
}
