//! Log times, from times of daemon and gripper.

use grip_link::message::daemon::Gripper;

/// Where an offset between the clocks comes from, the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Source {
    /// The arrival of samples here.
    Arrival,
    /// A frame's end at the daemon: as late as the line was.
    Frame,
    /// The clocks, as the daemon compares them.
    Clocks,
}

/// The clocks of one run of a daemon.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Clocks {
    /// Number of the daemon's start, and the wall time (ns since 1970) of its host time 0.
    run: Option<(u32, u64)>,
    gripper: Option<([u8; 16], u32)>,
    /// Host time minus device time (us).
    offset: Option<(i64, Source)>,
}

impl Clocks {
    /// A daemon reports what time it is; whether it is another start than before.
    pub(super) fn greeted(&mut self, run_id: u32, host_us: u64, now_ns: u64) -> bool {
        if self.run.is_some_and(|(known, _)| known == run_id) {
            return false;
        }
        *self = Self { run: Some((run_id, now_ns.saturating_sub(ns(host_us)))), ..Self::default() };
        true
    }

    /// Another gripper, or another start of it, counts from elsewhere.
    pub(super) fn meets(&mut self, gripper: &Gripper) {
        let now = (gripper.uid, gripper.boot_id);
        if self.gripper.replace(now).is_some_and(|before| before != now) {
            self.offset = None;
        }
    }

    /// Wall time of a host time; now, as long as the daemon has not said what time it is.
    pub(super) fn host_ns(&self, host_us: u64, now_ns: u64) -> u64 {
        self.run.map_or(now_ns, |(_, zero_ns)| zero_ns.saturating_add(ns(host_us)))
    }

    /// Something is known of both clocks at one time.
    pub(super) fn learn(&mut self, offset_us: i64, source: Source) {
        if self.offset.is_none_or(|(_, known)| known <= source) {
            self.offset = Some((offset_us, source));
        }
    }

    /// Samples up to this device time have come now: that is their offset where nothing better is known.
    pub(super) fn came(&mut self, device_us: u64, now_ns: u64) {
        if self.offset.is_none() {
            let zero_ns = self.run.map_or(0, |(_, zero_ns)| zero_ns);
            let host_us = now_ns.saturating_sub(zero_ns) / 1000;
            self.learn(
                host_us.cast_signed().wrapping_sub(device_us.cast_signed()),
                Source::Arrival,
            );
        }
    }

    /// Wall time of a device time; now, where the clocks are not known.
    pub(super) fn device_ns(&self, device_us: u64, now_ns: u64) -> u64 {
        let Some((offset_us, _)) = self.offset else { return now_ns };
        let zero_ns = self.run.map_or(0, |(_, zero_ns)| zero_ns);
        zero_ns.saturating_add(ns(device_us.saturating_add_signed(offset_us)))
    }
}

const fn ns(us: u64) -> u64 {
    us.saturating_mul(1000)
}

#[cfg(test)]
mod tests {
    use super::{Clocks, Source};
    use grip_link::message::daemon::Gripper;

    #[test]
    fn better_offsets_replace_worse_ones_and_another_start_forgets_them() {
        let mut clocks = Clocks::default();
        assert_eq!((clocks.host_ns(5, 77), clocks.device_ns(5, 77)), (77, 77));
        assert!(clocks.greeted(1, 1_000_000, 5_000_000_000));
        assert_eq!(clocks.host_ns(1_000_001, 0), 5_000_001_000);
        assert!(!clocks.greeted(1, 1_000_000, 6_000_000_000));
        clocks.came(200_000, 5_000_500_000);
        assert_eq!(clocks.device_ns(200_000, 0), 5_000_500_000);
        clocks.learn(700_000, Source::Frame);
        clocks.learn(600_000, Source::Clocks);
        clocks.learn(900_000, Source::Frame);
        assert_eq!(clocks.device_ns(200_000, 0), 4_800_000_000);
        clocks.meets(&Gripper::NONE);
        assert_eq!(clocks.device_ns(200_000, 0), 4_800_000_000);
        clocks.meets(&Gripper { boot_id: 2, ..Gripper::NONE });
        assert_eq!(clocks.device_ns(200_000, 9), 9);
        assert!(clocks.greeted(2, 0, 7_000_000_000));
        assert_eq!(clocks.host_ns(1, 0), 7_000_001_000);
    }
}
