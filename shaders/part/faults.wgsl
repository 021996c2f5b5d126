// Counters of faults. See `FaultRow` in crates/runtime/src/layout.rs.
@group(0) @binding(23) var<storage, read_write> faults: array<atomic<u32>>;
