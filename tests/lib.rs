//! Tests of supple's crates through their public interfaces: see `rust/` and `python/`.

pub mod counting_allocator;
