//! See [`grip_link_fuzz::targets::chunks`].
#![cfg_attr(fuzzing, no_main)]

#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| grip_link_fuzz::targets::chunks::check(data));

#[cfg(not(fuzzing))]
fn main() {
    eprintln!("run me with: cargo +nightly fuzz run chunks");
}
