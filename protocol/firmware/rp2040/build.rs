//! Lets the linker find memory.x.

fn main() {
    println!("cargo:rerun-if-changed=memory.x");
    if let Ok(folder) = std::env::var("CARGO_MANIFEST_DIR") {
        println!("cargo:rustc-link-search={folder}");
    }
}
