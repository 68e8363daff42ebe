//! Says what to write in place of an unknown name.

/// Names of other programs and symbols of physics, each with what it is here: the first of the names that is known.
const SYNONYMS: [(&[&str], &[&str]); 30] = [
    (&["E", "young", "youngs", "young_modulus", "modulus", "elastic_modulus"], &["youngs_modulus"]),
    (&["nu", "poisson", "poissons_ratio"], &["poisson_ratio"]),
    (&["mass", "rho", "weight"], &["density"]),
    (&["position", "pos", "location", "loc", "origin", "offset", "center", "translation"], &["translate"]),
    (&["rotation", "rot", "orientation", "angles", "euler", "quaternion"], &["rotate"]),
    (&["size", "scaling", "units"], &["scale"]),
    (&["timestep", "time_step", "delta_t", "delta_time", "step", "h"], &["dt", "substeps"]),
    (&["substep", "num_substeps", "sub_steps", "iterations", "steps"], &["substeps"]),
    (&["framerate", "frame_rate", "rate"], &["fps"]),
    (&["num_frames", "n_frames", "duration", "frame_count", "length"], &["frames"]),
    (&["g", "gravitation"], &["gravity"]),
    (&["num_threads", "n_threads", "n_jobs", "jobs", "workers", "cpus"], &["threads"]),
    (&["ground", "floor", "obstacle", "obstacles", "colliders", "collider"], &["colliders", "collider"]),
    (&["bodies", "object", "objects"], &["body"]),
    (&["mu", "friction_coefficient", "static_friction"], &["friction"]),
    (&["bounce", "bounciness", "bouncy"], &["restitution"]),
    (&["damping", "damp", "zeta"], &["damping_ratio"]),
    (&["resolution", "n", "num_vertices", "lattice_resolution", "nodes"], &["lattice_vertices", "vertices"]),
    (&["voxel_size", "spacing", "dx", "cell", "grid_size"], &["cell_size"]),
    (&["file", "path", "obj", "model", "filename", "shape"], &["mesh"]),
    (&["pinned", "fixed", "pins", "anchor", "fix"], &["pin"]),
    (&["handles", "keyframes", "animate"], &["handle"]),
    (&["angular_velocity", "omega", "w"], &["spin"]),
    (&["linear_velocity", "vel", "v"], &["velocity"]),
    (&["self_collision", "self_collide", "self_collisions"], &["self_contact"]),
    (&["collision", "collisions", "collide"], &["contact"]),
    (&["plasticity", "yield_stress"], &["plastic"]),
    (&["tear", "tearing", "breaking", "toughness"], &["fracture"]),
    (&["out", "output_dir", "output_directory", "folder"], &["output", "directory"]),
    (&["triangles", "tris", "indices"], &["faces"]),
];

/// Returns what to write in place of `word`: the name that a synonym stands for, the name that it resembles, or the list
/// of `known` names. `quote` quotes a name.
pub fn way_out(word: &str, known: &[&str], quote: impl Fn(&str) -> String) -> String {
    let names = SYNONYMS.iter().filter(|(words, _)| words.contains(&word)).flat_map(|(_, names)| *names);
    if let Some(name) = names.into_iter().find(|name| known.contains(*name)) {
        let meaning = match (word, *name) {
            ("mass" | "weight", "density") => ", the mass per volume",
            ("step" | "timestep" | "time_step" | "delta_t" | "delta_time" | "h", "substeps") => {
                ", the number of steps per frame"
            }
            _ => "",
        };
        return format!("write {}{meaning}", quote(name));
    }
    let is_near = |name: &&str| {
        let length = word.chars().count().max(name.chars().count());
        3 * strsim::damerau_levenshtein(start_of(word), name) <= length
    };
    match nearest(word, known).filter(is_near) {
        Some(name) => format!("the nearest one is {}", quote(name)),
        None => {
            format!("give one of {}", known.iter().map(|name| quote(name)).collect::<Vec<_>>().join(", "))
        }
    }
}

/// Returns the candidate with the smallest edit distance (Damerau-Levenshtein) to `word`. If several
/// candidates have this distance, returns the first one. Only the first 64 characters count.
pub fn nearest<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    let word = start_of(word);
    let distance = |candidate: &&str| strsim::damerau_levenshtein(word, start_of(candidate));
    candidates.iter().copied().min_by_key(distance)
}

/// Returns whether the edit distance of `word` to a candidate is at most a third of its length.
pub(super) fn resembles(word: &str, candidates: &[&str]) -> bool {
    let word = start_of(word);
    candidates
        .iter()
        .any(|candidate| 3 * strsim::damerau_levenshtein(word, candidate) <= word.chars().count())
}

/// Returns the first 64 characters of a word, which no name of a key exceeds. The time of an edit distance is
/// the product of the lengths.
fn start_of(word: &str) -> &str {
    word.char_indices().nth(64).map_or(word, |(end, _)| &word[..end])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn synonyms_come_before_spelling_and_a_list_of_names_is_the_last_resort() {
        let known = ["name", "youngs_modulus", "density", "translate", "friction", "substeps"];
        let said = |word| way_out(word, &known, |name| format!("<{name}>"));
        assert_eq!(said("E"), "write <youngs_modulus>");
        assert_eq!(said("mass"), "write <density>, the mass per volume");
        assert_eq!(said("position"), "write <translate>");
        assert_eq!(said("timestep"), "write <substeps>, the number of steps per frame");
        assert_eq!(said("frictoin"), "the nearest one is <friction>");
        assert_eq!(said("nme"), "the nearest one is <name>");
        assert!(said("color").starts_with("give one of <name>, <youngs_modulus>"), "{}", said("color"));
        // The word is in the list, but no name for it is known here.
        assert!(said("nu").starts_with("give one of"), "{}", said("nu"));
    }

    #[test]
    fn no_synonym_is_listed_twice_or_stands_for_itself_alone() {
        let mut words: Vec<&str> = SYNONYMS.iter().flat_map(|(words, _)| *words).copied().collect();
        let count = words.len();
        words.sort_unstable();
        words.dedup();
        assert_eq!(words.len(), count);
    }
}
