//! The `lumigon` command.
mod bench;
fn main() {
    bench::run()
}
