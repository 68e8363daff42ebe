//! Selects the SIMD level of the kernels: the instruction set that they use.

use std::sync::OnceLock;

use fearless_simd::{Level, Simd};

/// Name of the environment variable that selects the SIMD level.
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

/// Returns whether an instruction of the SIMD level can leave out lanes. The selection from the result of an operation
/// and its first operand is then a single instruction. Otherwise it is faster to replace the values in these lanes by
/// zeros before.
#[inline(always)]
pub(crate) fn has_masked_arithmetic<S: Simd>(simd: S) -> bool {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    return matches!(simd.level(), Level::Avx512(_));
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    {
        let _ = simd;
        false
    }
}

/// The error that `SUPPLE_SIMD` names an unknown SIMD level, or one that the machine does not support. The
/// kernels then use the best level of the machine.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[error("{LEVEL_VARIABLE} is {name:?}, which this machine does not support; it has {}", known.join(", "))]
pub struct SimdError {
    /// Requested name.
    pub name: String,
    /// Names of the levels that the machine supports.
    pub known: Vec<&'static str>,
}

/// Checks that the machine supports the SIMD level named by the environment variable `SUPPLE_SIMD`.
///
/// The names are `sse2`, `sse4.2`, `avx2`, `avx512`, `neon` and `simd128` (WebAssembly), and `scalar` on a machine
/// that supports no other level. An empty value has the same effect as an unset variable.
///
/// # Errors
///
/// If the variable names an unknown level or a level that the machine does not support. The kernels then use
/// the best level of the machine.
pub fn check_simd_request() -> Result<(), SimdError> {
    let Some(name) = std::env::var_os(LEVEL_VARIABLE) else { return Ok(()) };
    let (name, best) = (name.to_string_lossy().into_owned(), Level::new());
    if name.is_empty() || find_level(best, &name).is_some() {
        return Ok(());
    }
    Err(SimdError { name, known: levels(best).map(|(name, _)| name).collect() })
}

/// Returns the level called `name`, or `None` if a machine with the best level `best` does not support it.
fn find_level(best: Level, name: &str) -> Option<Level> {
    levels(best).find(|(known, _)| *known == name).map(|(_, level)| level)
}

/// Returns the name of the SIMD level of the kernels, which `supple inspect` prints. Results have the same bits at each
/// level.
pub fn simd_level() -> &'static str {
    levels(level()).last().map_or("scalar", |(name, _)| name)
}

/// Returns the levels up to `best`, each with its name, in increasing order. `scalar` is included only if
/// there is no other level.
fn levels(best: Level) -> impl Iterator<Item = (&'static str, Level)> {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    let levels = [
        ("sse2", best.as_sse2().map(Simd::level)),
        ("sse4.2", best.as_sse4_2().map(Simd::level)),
        ("avx2", best.as_avx2().map(Simd::level)),
        ("avx512", best.as_avx512().map(Simd::level)),
    ];
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    let name = if cfg!(target_family = "wasm") { "simd128" } else { "neon" };
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    let levels = [(name, (!best.is_fallback()).then_some(best))];
    let scalar = levels.iter().all(|(_, level)| level.is_none()).then_some(best);
    [("scalar", scalar)].into_iter().chain(levels).filter_map(|(name, level)| Some((name, level?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn best_level_is_found_by_its_name() {
        let best = Level::new();
        let (name, _) = levels(best).last().expect("every machine has at least one level");
        let found = find_level(best, name).expect("the best level is found by its own name");
        assert_eq!(levels(found).last().map(|(name, _)| name), Some(name));
        assert!(find_level(best, "none").is_none());
    }
}
