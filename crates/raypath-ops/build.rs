//! Cargo does not know that `automod` reads the folder of operations: without this, a file that is added there is not
//! compiled until something else changes.

fn main() {
    println!("cargo::rerun-if-changed=src/operations");
}
