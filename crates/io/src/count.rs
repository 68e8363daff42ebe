//! Formats counts and lists for messages.

/// Formats a count and its noun: `1 frame`, `2 frames`, `1 lattice vertex`, `2 lattice vertices`, `2 bodies`.
pub fn counted(count: usize, singular: &str) -> String {
    match (count, singular.strip_suffix("vertex")) {
        (1, _) => format!("1 {singular}"),
        (_, Some(start)) => format!("{count} {start}vertices"),
        (_, None) if singular == "body" => format!("{count} bodies"),
        _ => format!("{count} {singular}s"),
    }
}

/// Formats names as alternatives: `obj, ply or pc2`.
pub(crate) fn alternatives(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [name] => (*name).to_owned(),
        [others @ .., last] => format!("{} or {last}", others.join(", ")),
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

    #[test]
    fn the_last_alternative_follows_an_or() {
        let texts = [&[][..], &["a"], &["a", "b"], &["a", "b", "c"]].map(alternatives);
        assert_eq!(texts, ["", "a", "a or b", "a, b or c"]);
    }
}
