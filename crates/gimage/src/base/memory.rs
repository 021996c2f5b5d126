//! Memory that this process can still get.

use sysinfo::System;

/// Memory \[bytes\] that the system can give, swap included, within the limit of a container; `None` where neither is told.
pub(crate) fn available() -> Option<u64> {
    let mut system = System::new();
    system.refresh_memory();
    let free = system.available_memory().saturating_add(system.free_swap());
    // Cached files are counted as used there, but are given up on demand: only resident memory is taken off.
    let container = system.cgroup_limits().map(|c| c.total_memory.saturating_sub(c.rss).saturating_add(c.free_swap));
    [Some(free), container].into_iter().flatten().filter(|&bytes| bytes > 0).min()
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_system_tells_how_much_memory_there_is() {
        assert!(super::available().is_some_and(|bytes| bytes > 1 << 20));
    }
}
