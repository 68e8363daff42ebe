//! The memory of the machine.

#[cfg(not(target_family = "wasm"))]
use std::path::Path;

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
    let machine = Some(system.total_memory()).filter(|&bytes| bytes > 0)?;
    let group = std::fs::read_to_string("/proc/self/cgroup").ok();
    let group = group.and_then(|groups| group_limit(&groups, Path::new("/sys/fs/cgroup")));
    Some(group.map_or(machine, |limit| limit.min(machine)))
}

/// Returns the least limit of the control groups of a process of Linux and of the groups that contain them, in bytes.
/// `groups`: the text of `/proc/self/cgroup`, lines `ID:CONTROLLERS:PATH`; `root`: the folder of all groups.
///
/// sysinfo reads only the outermost group, which is that of the process in a container, but not in a task of Slurm.
#[cfg(not(target_family = "wasm"))]
fn group_limit(groups: &str, root: &Path) -> Option<u64> {
    let limit = |line: &str| {
        let mut parts = line.splitn(3, ':').skip(1);
        let (controllers, group) = (parts.next()?, parts.next()?);
        let (root, file) = match controllers {
            "" => (root.to_owned(), "memory.max"),
            _ if controllers.split(',').any(|name| name == "memory") => {
                (root.join("memory"), "memory.limit_in_bytes")
            }
            _ => return None,
        };
        let innermost = root.join(group.trim_start_matches('/'));
        let groups = innermost.ancestors().take_while(|group| group.starts_with(&root));
        // A group without a limit has the text `max`.
        let limits =
            groups.filter_map(|group| std::fs::read_to_string(group.join(file)).ok()?.trim().parse().ok());
        limits.min()
    };
    groups.lines().filter_map(limit).min()
}

#[cfg(target_family = "wasm")]
fn memory() -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::group_limit;

    #[test]
    fn the_least_limit_of_the_groups_of_a_process_counts() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        let job = root.join("slurm/job_7/step_0");
        fs::create_dir_all(&job).unwrap();
        fs::create_dir_all(root.join("memory/task")).unwrap();
        fs::write(root.join("slurm/memory.max"), "max\n").unwrap();
        assert_eq!(group_limit("0::/slurm/job_7/step_0\n", root), None);
        fs::write(root.join("slurm/job_7/memory.max"), "4000000\n").unwrap();
        assert_eq!(group_limit("0::/slurm/job_7/step_0\n", root), Some(4_000_000));
        fs::write(job.join("memory.max"), "1000000\n").unwrap();
        assert_eq!(group_limit("0::/slurm/job_7/step_0\n", root), Some(1_000_000));
        // A path of the machine that a container does not have: the outermost group is that of the container.
        fs::write(root.join("memory.max"), "9000000\n").unwrap();
        assert_eq!(group_limit("0::/docker/a:b\n", root), Some(9_000_000));
        // The first version of control groups.
        fs::write(root.join("memory/task/memory.limit_in_bytes"), "2000000\n").unwrap();
        assert_eq!(group_limit("5:cpu,memory:/task\n3:cpuset:/\n", root), Some(2_000_000));
        assert_eq!(group_limit("3:cpuset:/\n\nno group\n", root), None);
    }

    #[test]
    fn the_memory_of_this_machine_is_known_and_plausible() {
        let bytes = super::memory().expect("known on the systems that run tests");
        assert!((1 << 27..1 << 50).contains(&bytes), "{bytes}");
    }
}
