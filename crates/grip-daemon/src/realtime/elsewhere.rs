//! Other systems than Linux: nothing is granted so far.

use rustix::io::Errno;

pub(super) const fn lock_memory() -> Result<(), Errno> {
    Err(Errno::OPNOTSUPP)
}

pub(super) const fn end_timers_in_time() -> Result<(), Errno> {
    Err(Errno::OPNOTSUPP)
}

pub(super) const fn stay_on(_cpu: usize) -> Result<(), Errno> {
    Err(Errno::OPNOTSUPP)
}

pub(super) const fn go_first(_priority: u8) -> Result<(), Errno> {
    Err(Errno::OPNOTSUPP)
}
