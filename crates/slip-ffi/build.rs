//! Gives the shared library the name by which programs ask for it: `libslip.so.0`, until the first release with another border.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "linux") {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libslip.so.0");
    }
}
