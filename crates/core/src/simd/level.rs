//! The SIMD level of the kernels.

use std::sync::OnceLock;

use fearless_simd::Level;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::Simd;

/// The environment variable that forces a SIMD level.
const LEVEL_VARIABLE: &str = "SUPPLE_SIMD";

/// Returns the SIMD level of the kernels: the level named by `SUPPLE_SIMD` if the machine supports it, else
/// the best level of the machine.
pub(crate) fn level() -> Level {
    static LEVEL: OnceLock<Level> = OnceLock::new();
    *LEVEL.get_or_init(|| {
        let best = Level::new();
        std::env::var(LEVEL_VARIABLE).ok().and_then(|name| find_level(best, &name)).unwrap_or(best)
    })
}

/// `SUPPLE_SIMD` names a SIMD level that the machine does not support; the best level is used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[error("{LEVEL_VARIABLE} is {name:?}, which this machine does not support; it has {}", known.join(", "))]
pub struct SimdError {
    /// The requested name.
    pub name: String,
    /// The names of the supported levels.
    pub known: Vec<&'static str>,
}

/// Checks that the machine supports the SIMD level named by the environment variable `SUPPLE_SIMD`.
///
/// The names are `sse2`, `sse4.2`, `avx2`, `avx512` and `neon`, and `scalar` on a machine that supports no
/// other level. An empty variable counts as not set.
///
/// # Errors
///
/// An unknown or unsupported level. The best level of the machine is then used.
pub fn check_simd_request() -> Result<(), SimdError> {
    let Some(name) = std::env::var_os(LEVEL_VARIABLE) else { return Ok(()) };
    let (name, best) = (name.to_string_lossy().into_owned(), Level::new());
    if name.is_empty() || find_level(best, &name).is_some() {
        return Ok(());
    }
    Err(SimdError { name, known: levels(best).map(|(name, _)| name).collect() })
}

/// Returns the level called `name`, or `None` if `best` does not include it.
fn find_level(best: Level, name: &str) -> Option<Level> {
    levels(best).find(|(known, _)| *known == name).map(|(_, level)| level)
}

/// Returns the name of the SIMD level of the kernels. `supple inspect` prints it, and checkpoints record it.
pub fn simd_level() -> &'static str {
    levels(level()).last().map_or("scalar", |(name, _)| name)
}

/// The levels up to `best` with their names in increasing order; `scalar` only if there is no other.
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
    fn best_level_is_found_by_its_name() {
        let best = Level::new();
        let (name, _) = levels(best).last().expect("a level");
        let found = find_level(best, name).expect("the best level");
        assert_eq!(levels(found).last().map(|(name, _)| name), Some(name));
        assert!(find_level(best, "none").is_none());
    }
}
