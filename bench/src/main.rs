//! `situ-bench`.
fn main() {}
