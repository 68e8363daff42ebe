//! The memory of the machine.

use supple::LatticeOptions;

/// Returns the memory limit for a lattice and a simulation of it, in bytes, for [`LatticeOptions::memory_limit`]: half
/// of the machine's memory, or half of the limit of the process's control group if that is less. If the memory is
/// unknown, as in a browser, the limit is [`LatticeOptions::DEFAULT_MEMORY_LIMIT`].
///
/// Scenes and the Python module use this limit. The core has a fixed one, because it asks the system for nothing.
pub fn memory_limit() -> u64 {
    memory().map_or(LatticeOptions::DEFAULT_MEMORY_LIMIT, |bytes| bytes / 2)
}

/// Returns the bytes of memory that this process may use.
#[cfg(not(target_family = "wasm"))]
fn memory() -> Option<u64> {
    use sysinfo::{MemoryRefreshKind, System};
    let mut system = System::new();
    system.refresh_memory_specifics(MemoryRefreshKind::nothing().with_ram());
    // sysinfo panics if it is asked for the limit of the group while the memory of the machine is unknown.
    let machine = Some(system.total_memory()).filter(|&bytes| bytes > 0)?;
    Some(system.cgroup_limits().map_or(machine, |group| group.total_memory.min(machine)))
}

#[cfg(target_family = "wasm")]
fn memory() -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_memory_of_this_machine_is_known_and_plausible() {
        let bytes = super::memory().expect("known on the systems that run tests");
        assert!((1 << 27..1 << 50).contains(&bytes), "{bytes}");
    }
}
