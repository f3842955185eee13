//! The `lumigon` command.

fn main() {}
