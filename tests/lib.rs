//! Tests of supple's crates as their users see them: see `rust/` and `python/`.
