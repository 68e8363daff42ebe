//! The `supple` binary.

fn main() {}
