//! The SIMD level that runs.

use std::sync::OnceLock;

use fearless_simd::Level;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::Simd;

/// The environment variable that forces a SIMD level.
const LEVEL_VARIABLE: &str = "SUPPLE_SIMD";

/// The SIMD level that runs: the best that the machine has, or what `SUPPLE_SIMD` names if the machine has it.
pub(crate) fn level() -> Level {
    static LEVEL: OnceLock<Level> = OnceLock::new();
    *LEVEL.get_or_init(|| {
        let best = Level::new();
        std::env::var(LEVEL_VARIABLE).ok().and_then(|name| lowered(best, &name)).unwrap_or(best)
    })
}

/// A SIMD level was asked for that is not there; the best one runs.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
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
    Err(SimdError { name, known: levels(best).map(|(name, _)| name).collect() })
}

/// `best` lowered to the level called `name`; `None` if the machine lacks it.
fn lowered(best: Level, name: &str) -> Option<Level> {
    levels(best).find(|(known, _)| *known == name).map(|(_, level)| level)
}

/// The name of the SIMD level that runs, as `supple inspect` shows it and a checkpoint records it.
pub fn simd_level() -> &'static str {
    levels(level()).last().map_or("scalar", |(name, _)| name)
}

/// The levels up to `best`, with their names; `scalar` of a machine that has no other.
fn levels(best: Level) -> impl Iterator<Item = (&'static str, Level)> {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    let levels = [
        ("sse2", best.as_sse2().map(Simd::level)),
        ("sse4.2", best.as_sse4_2().map(Simd::level)),
        ("avx2", best.as_avx2().map(Simd::level)),
        ("avx512", best.as_avx512().map(Simd::level)),
    ];
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    let levels = [("neon", (!best.is_fallback()).then_some(best))];
    let scalar = levels.iter().all(|(_, level)| level.is_none()).then_some(best);
    [("scalar", scalar)].into_iter().chain(levels).filter_map(|(name, level)| Some((name, level?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_level_can_be_asked_for_by_its_name() {
        let best = Level::new();
        let (name, _) = levels(best).last().expect("a level");
        let asked = lowered(best, name).expect("the best level");
        assert_eq!(levels(asked).last().map(|(name, _)| name), Some(name));
        assert!(lowered(best, "none").is_none());
    }
}
