//! The system calls of Linux.

use core::num::NonZeroU64;
use rustix::{
    io::Errno,
    mm::{MlockAllFlags, mlockall},
    process::{Resource, getrlimit},
    thread::{
        CapabilitySet, CpuSet, capabilities, sched_getaffinity, sched_setaffinity,
        set_current_timer_slack,
    },
};
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

/// Pages stay in memory from their first use on: locking them all at once would fill the stacks of all threads.
///
/// With a limit in force a later allocation would fail instead of going without, so a limit is a refusal.
pub(super) fn lock_memory() -> Result<(), Errno> {
    let limited = getrlimit(Resource::Memlock).current.is_some();
    let free =
        capabilities(None).is_ok_and(|sets| sets.effective.contains(CapabilitySet::IPC_LOCK));
    if limited && !free {
        return Err(Errno::NOMEM);
    }
    mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE | MlockAllFlags::ONFAULT)
}

pub(super) fn end_timers_in_time() -> Result<(), Errno> {
    set_current_timer_slack(Some(NonZeroU64::MIN))
}

pub(super) fn stay_on(cpu: usize) -> Result<(), Errno> {
    // Also refuses numbers that no set holds.
    if cpu >= CpuSet::MAX_CPU || !sched_getaffinity(None)?.is_set(cpu) {
        return Err(Errno::INVAL);
    }
    let mut set = CpuSet::new();
    set.set(cpu);
    sched_setaffinity(None, &set)
}

pub(super) fn go_first(priority: u8) -> Result<(), Errno> {
    let value = ThreadPriorityValue::try_from(priority).map_err(|_| Errno::INVAL)?;
    set_thread_priority_and_policy(
        thread_native_id(),
        ThreadPriority::Crossplatform(value),
        ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo),
    )
    .map_err(|error| match error {
        thread_priority::Error::OS(number) => Errno::from_raw_os_error(number),
        _ => Errno::INVAL,
    })
}
