//! Requests of the hot thread to the system: what it was granted, and what would grant the rest.
//!
//! Nothing here is needed for correct work: it keeps other programs, page faults and sleeping timers from delaying an answer. All of
//! it works without root where the limits RTPRIO and MEMLOCK are raised, as the unit of the package does.

use core::{fmt, hint::black_box};
pub use grip_session::config::{RealtimeConfig, RealtimeMode};
use rustix::io::Errno;
use std::{io, panic::resume_unwind, thread};

#[cfg_attr(not(target_os = "linux"), path = "realtime/elsewhere.rs")]
mod system;

/// How much of the stack is touched beforehand (bytes): more than the hot thread uses.
const STACK_BYTES: usize = 256 * 1024;

slip_core::named! {
    /// One thing that is asked for.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Measure {
        fn name: "The name in messages.";
    }
    LockedMemory: "Memory of the whole process is never paged out (mlockall).", "locked memory";
    TouchedStack: "The thread's stack is in memory before it is used.", "prefaulted stack";
    Priority: "SCHED_FIFO.", "SCHED_FIFO";
    Affinity: "One processor.", "processor affinity";
    TimerSlack: "Timers that end to the nanosecond instead of 50 us late.", "timer slack";
}

impl Measure {
    /// What would grant it.
    #[must_use]
    pub const fn remedy(self) -> &'static str {
        match self {
            Self::LockedMemory => {
                "LimitMEMLOCK=infinity in the unit, `memlock unlimited` in /etc/security/limits.conf, or CAP_IPC_LOCK"
            }
            Self::Priority => {
                "LimitRTPRIO=50 in the unit, `rtprio 50` in /etc/security/limits.conf, or CAP_SYS_NICE; a container needs --cap-add"
            }
            Self::Affinity => "a processor of those this process may use; see taskset -p",
            Self::TouchedStack | Self::TimerSlack => "a Linux kernel",
        }
    }
}

/// What became of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It is so from now on.
    Granted,
    /// Nobody wished for it.
    NotAsked,
    /// The system refused.
    Refused(Errno),
}

/// A request and what became of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attempt {
    /// What was asked for.
    pub measure: Measure,
    /// What became of it.
    pub outcome: Outcome,
}

impl fmt::Display for Attempt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.measure.name();
        match self.outcome {
            Outcome::Granted => write!(f, "{name}: granted"),
            Outcome::NotAsked => write!(f, "{name}: not asked for"),
            Outcome::Refused(error) => {
                write!(f, "{name}: refused ({error}); granted by {}", self.measure.remedy())
            }
        }
    }
}

/// What a thread was granted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Granted {
    attempts: [Attempt; 5],
}

impl Granted {
    /// Every request, for the console and the state.
    #[must_use]
    pub fn attempts(&self) -> &[Attempt] {
        &self.attempts
    }

    /// The requests that were refused.
    pub fn refused(&self) -> impl Iterator<Item = &Attempt> {
        self.attempts.iter().filter(|attempt| matches!(attempt.outcome, Outcome::Refused(_)))
    }

    /// Whether `mode` lets the program go on.
    ///
    /// # Errors
    /// The first refusal, where the mode is strict.
    pub fn check(&self, mode: RealtimeMode) -> Result<(), RealtimeRefused> {
        match self.refused().next() {
            Some(attempt) if mode == RealtimeMode::Strict => Err(RealtimeRefused(*attempt)),
            _ => Ok(()),
        }
    }
}

/// Real time is a condition, and was not granted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("--realtime strict: {0}; --realtime warn goes on without")]
pub struct RealtimeRefused(pub Attempt);

/// Makes the calling thread a real-time thread as far as the system lets it, and locks the memory of the process. The service threads keep
/// their ordinary priority if they were started before, or are started by another thread.
#[must_use]
pub fn enter(config: &RealtimeConfig) -> Granted {
    let asked = config.mode != RealtimeMode::Off;
    let attempt = |measure, request: &dyn Fn() -> Outcome| {
        let outcome = if asked { request() } else { Outcome::NotAsked };
        Attempt { measure, outcome }
    };
    let outcome =
        |result: Result<(), Errno>| result.map_or_else(Outcome::Refused, |()| Outcome::Granted);
    Granted {
        attempts: [
            attempt(Measure::LockedMemory, &|| outcome(system::lock_memory())),
            attempt(Measure::TouchedStack, &|| {
                touch_stack();
                Outcome::Granted
            }),
            attempt(Measure::TimerSlack, &|| outcome(system::end_timers_in_time())),
            attempt(Measure::Affinity, &|| {
                config
                    .cpu
                    .map_or(Outcome::NotAsked, |cpu| outcome(system::stay_on(usize::from(cpu))))
            }),
            attempt(Measure::Priority, &|| outcome(system::go_first(config.priority))),
        ],
    }
}

/// Starts threads whose work comes before that of the real-time thread: on a busy computer what they bring late is answered late. They go
/// before others as well, but behind that thread, as far as the system lets them; the caller keeps its own priority.
///
/// # Errors
/// Where the system has no thread for it.
pub fn starting<T: Send>(
    config: &RealtimeConfig,
    start: impl FnOnce() -> T + Send,
) -> io::Result<T> {
    if config.mode == RealtimeMode::Off {
        return Ok(start());
    }
    // A thread has the priority of the one that starts it.
    let first = || {
        let _refused_there_too = system::go_first(config.priority.saturating_sub(1).max(1));
        start()
    };
    thread::scope(|threads| {
        let started = thread::Builder::new().spawn_scoped(threads, first)?.join();
        Ok(started.unwrap_or_else(|panic| resume_unwind(panic)))
    })
}

#[inline(never)]
fn touch_stack() {
    let mut stack = [0_u8; STACK_BYTES];
    black_box(&mut stack);
}

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests {
    use super::{
        Attempt, Errno, Granted, Measure, Outcome, RealtimeConfig, RealtimeMode, enter, starting,
        system,
    };
    use rustix::{
        mm::munlockall,
        thread::{
            CapabilitySet, capabilities, current_timer_slack, sched_getaffinity, set_capabilities,
        },
    };
    use std::{fs, sync::Mutex, thread};
    use thread_priority::{
        RealtimeThreadSchedulePolicy, ThreadSchedulePolicy, thread_native_id,
        thread_schedule_policy_param,
    };

    #[test]
    fn threads_of_the_signal_path_go_first_as_well_and_the_caller_does_not() {
        let allowed = thread::spawn(|| system::go_first(1).is_ok()).join().unwrap();
        let (warn, off) = (RealtimeMode::Warn, RealtimeMode::Off);
        for (mode, priority, given) in [(warn, 7, 6), (warn, 1, 1), (off, 7, 6)] {
            let config = RealtimeConfig { mode, priority, cpu: None, spin_us: 0 };
            let asks = || thread::spawn(move || is_fifo(given)).join().unwrap();
            assert_eq!(starting(&config, asks).unwrap(), allowed && mode == warn, "{config:?}");
            assert!(!asks(), "the caller");
        }
    }

    fn outcome(granted: &Granted, measure: Measure) -> Outcome {
        granted.attempts().iter().find(|attempt| attempt.measure == measure).unwrap().outcome
    }

    /// In a thread of its own: what is granted ends with it. One at a time, for memory is locked for all.
    fn aside(body: impl FnOnce() + Send) {
        static ALONE: Mutex<()> = Mutex::new(());
        let _alone = ALONE.lock();
        thread::scope(|threads| threads.spawn(body).join().unwrap());
    }

    fn locked_kb() -> u64 {
        let status = fs::read_to_string("/proc/self/status").unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix("VmLck:")).unwrap();
        line.trim().trim_end_matches(" kB").parse().unwrap()
    }

    fn is_fifo(priority: i32) -> bool {
        let (policy, params) = thread_schedule_policy_param(thread_native_id()).unwrap();
        policy == ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo)
            && params.sched_priority == priority
    }

    /// As root all is granted, as a user some of it: either way the answer is the truth.
    #[test]
    fn what_is_reported_is_what_is_in_force() {
        aside(|| {
            let allowed = sched_getaffinity(None).unwrap();
            let cpu = (0..1024).find(|cpu| allowed.is_set(*cpu)).unwrap();
            let mode = RealtimeMode::Warn;
            let granted = enter(&RealtimeConfig {
                mode,
                priority: 7,
                cpu: u16::try_from(cpu).ok(),
                spin_us: 0,
            });
            assert_eq!(is_fifo(7), outcome(&granted, Measure::Priority) == Outcome::Granted);
            assert_eq!(
                locked_kb() > 0,
                outcome(&granted, Measure::LockedMemory) == Outcome::Granted
            );
            assert_eq!(outcome(&granted, Measure::Affinity), Outcome::Granted);
            assert_eq!(sched_getaffinity(None).unwrap().count(), 1);
            assert_eq!(outcome(&granted, Measure::TimerSlack), Outcome::Granted);
            // A thread under SCHED_FIFO has no slack at all.
            assert!(current_timer_slack().unwrap() <= 1);
            assert!(granted.check(mode).is_ok());
            munlockall().unwrap();
        });
    }

    #[test]
    fn without_privileges_it_goes_on_and_states_what_is_missing() {
        aside(|| {
            let mut sets = capabilities(None).unwrap();
            sets.effective -= CapabilitySet::SYS_NICE | CapabilitySet::IPC_LOCK;
            set_capabilities(None, sets).unwrap();
            let config = RealtimeConfig {
                mode: RealtimeMode::Strict,
                priority: 99,
                ..RealtimeConfig::default()
            };
            let granted = enter(&config);
            let refused: Vec<Attempt> = granted.refused().copied().collect();
            for attempt in &refused {
                let text = attempt.to_string();
                assert!(text.contains("refused") && text.contains("Limit"), "{text}");
            }
            // Machines may raise the limits of everyone; then nothing is refused, and that is reported.
            assert_eq!(granted.check(RealtimeMode::Strict).is_ok(), refused.is_empty());
            assert!(granted.check(RealtimeMode::Warn).is_ok());
            if outcome(&granted, Measure::Priority) == Outcome::Refused(Errno::PERM) {
                assert!(!is_fifo(99));
                let error = granted.check(RealtimeMode::Strict).unwrap_err().to_string();
                assert!(error.starts_with("--realtime strict: "), "{error}");
            }
        });
    }

    #[test]
    fn wishes_that_make_no_sense_are_refused() {
        aside(|| {
            for cpu in [1023, 1024, u16::MAX] {
                let config = RealtimeConfig {
                    mode: RealtimeMode::Warn,
                    priority: 0,
                    cpu: Some(cpu),
                    spin_us: 0,
                };
                let granted = enter(&config);
                assert_eq!(outcome(&granted, Measure::Affinity), Outcome::Refused(Errno::INVAL));
                assert_eq!(outcome(&granted, Measure::Priority), Outcome::Refused(Errno::INVAL));
            }
        });
    }

    #[test]
    fn nothing_is_touched_where_nothing_is_asked() {
        aside(|| {
            let before = (current_timer_slack().unwrap(), sched_getaffinity(None).unwrap());
            let granted = enter(&RealtimeConfig { cpu: Some(0), ..RealtimeConfig::default() });
            assert!(granted.attempts().iter().all(|made| made.outcome == Outcome::NotAsked));
            assert_eq!(before, (current_timer_slack().unwrap(), sched_getaffinity(None).unwrap()));
            assert!(granted.check(RealtimeMode::Strict).is_ok());
        });
    }
}
