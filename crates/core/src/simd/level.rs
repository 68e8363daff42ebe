//! The SIMD level that runs.

use std::sync::OnceLock;

use fearless_simd::Level;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::Simd;

/// The environment variable that forces a SIMD level, one of [`LEVELS`].
const LEVEL_VARIABLE: &str = "SUPPLE_SIMD";

/// The SIMD level that runs: the best that the machine has, or what `SUPPLE_SIMD` names if the machine has it.
pub(crate) fn level() -> Level {
    static LEVEL: OnceLock<Level> = OnceLock::new();
    *LEVEL.get_or_init(|| {
        let best = Level::new();
        std::env::var(LEVEL_VARIABLE).ok().and_then(|name| lowered(best, &name)).unwrap_or(best)
    })
}

/// The levels that `SUPPLE_SIMD` may name, of all machines; `scalar` of one that has no other.
const LEVELS: [&str; 6] = ["scalar", "sse2", "sse4.2", "avx2", "avx512", "neon"];

/// A SIMD level was asked for that is not there; the best one runs.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{LEVEL_VARIABLE} is {name:?}, which this machine does not have; it has {}", known.join(", "))]
pub struct SimdError {
    /// What was asked for.
    pub name: String,
    /// The levels that there are.
    pub known: Vec<&'static str>,
}

/// Whether the SIMD level that the environment variable `SUPPLE_SIMD` names is the one that runs: one of `sse2`,
/// `sse4.2`, `avx2`, `avx512`, `neon`, and `scalar` on a machine with none of these. Empty is as not set.
///
/// # Errors
///
/// If the machine has no such level, or there is none of that name. The best level runs then.
pub fn check_simd_request() -> Result<(), SimdError> {
    let Some(name) = std::env::var_os(LEVEL_VARIABLE) else { return Ok(()) };
    let (name, best) = (name.to_string_lossy().into_owned(), Level::new());
    if name.is_empty() || lowered(best, &name).is_some() {
        return Ok(());
    }
    let known = LEVELS.into_iter().filter(|level| lowered(best, level).is_some()).collect();
    Err(SimdError { name, known })
}

/// `best` lowered to the level called `name`; `None` if the machine lacks it.
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fn lowered(best: Level, name: &str) -> Option<Level> {
    match name {
        "sse2" => best.as_sse2().map(|token| token.level()),
        "sse4.2" => best.as_sse4_2().map(|token| token.level()),
        "avx2" => best.as_avx2().map(|token| token.level()),
        "avx512" => best.as_avx512().map(|token| token.level()),
        _ => (name == level_name_of(best)).then_some(best),
    }
}

#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
fn lowered(best: Level, name: &str) -> Option<Level> {
    (name == level_name_of(best)).then_some(best)
}

/// The name of the SIMD level that runs, as `supple inspect` shows it and a checkpoint records it.
pub fn simd_level() -> &'static str {
    level_name_of(level())
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fn level_name_of(level: Level) -> &'static str {
    if level.as_avx512().is_some() {
        "avx512"
    } else if level.as_avx2().is_some() {
        "avx2"
    } else if level.as_sse4_2().is_some() {
        "sse4.2"
    } else if level.as_sse2().is_some() {
        "sse2"
    } else {
        "scalar"
    }
}

#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
fn level_name_of(level: Level) -> &'static str {
    if level.is_fallback() { "scalar" } else { "neon" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_level_can_be_asked_for_by_its_name() {
        let best = Level::new();
        let name = level_name_of(best);
        assert!(LEVELS.contains(&name), "{name}");
        assert_eq!(lowered(best, name).map(level_name_of), Some(name));
    }
}
