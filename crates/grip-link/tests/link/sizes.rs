//! How much memory the link takes: fixed, known, and for one frame at most 512 bytes.

use core::mem::size_of;
use grip_link::decoder::{Counters, Decoder};
use grip_link::device::DeviceLink;
use grip_link::frame::{MAX_BLOCK, MAX_WIRE};
use grip_link::host::HostLink;

#[test]
fn one_frame_takes_at_most_512_bytes() {
    assert_eq!((MAX_BLOCK, MAX_WIRE), (494, 496));
    let beside_counters = size_of::<Decoder>() - size_of::<Counters>();
    assert!(beside_counters <= MAX_BLOCK + 48, "{beside_counters}: one block and a little state");
    println!("decoder {} bytes, of these counters {}", size_of::<Decoder>(), size_of::<Counters>());
}

#[test]
fn both_ends_have_a_fixed_size() {
    println!("device {} bytes, host {} bytes", size_of::<DeviceLink>(), size_of::<HostLink>());
    assert!(size_of::<DeviceLink>() <= 5 * 1024, "{}", size_of::<DeviceLink>());
    assert!(size_of::<HostLink>() <= 5 * 1024, "{}", size_of::<HostLink>());
}
