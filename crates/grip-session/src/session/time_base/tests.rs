use super::{ClockHealth, TimeBase};
use proptest::prelude::*;

/// A device of 10 kHz in frames of ten rows, one every millisecond, at a line without delay.
struct Device {
    time: TimeBase,
    index: u32,
    host_us: u64,
    /// Tick of the row at host time 0, and ticks per us.
    clock: (u64, u64),
    last_us: Option<u64>,
    /// Longest step between usable rows (us), and longest time without one.
    longest_us: u64,
    refused: u32,
    seen: Vec<(u64, ClockHealth)>,
}

impl Device {
    fn new(tick: u64) -> Self {
        let time = TimeBase::new(1_000_000, 10_000);
        let (clock, seen) = ((tick, 1), vec![(0, ClockHealth::Good)]);
        Self { time, index: 7, host_us: 0, clock, last_us: None, longest_us: 0, refused: 0, seen }
    }

    fn tick(&self) -> u64 {
        self.clock.0.wrapping_add(self.host_us * self.clock.1)
    }

    /// Sets the rate from now on, without a step.
    fn rate(&mut self, rate: u64) {
        let tick = self.tick();
        self.clock = (tick.wrapping_sub(self.host_us * rate), rate);
    }

    fn run(&mut self, ms: u64) {
        for _ in 0..ms {
            self.host_us += 1000;
            let tick = self.tick();
            self.frame(tick);
        }
    }

    fn frame(&mut self, tick: u64) {
        self.time.frame(self.host_us);
        for row in 0..10 {
            let stamp = self.time.row(self.index, tick.wrapping_add(100 * row));
            self.index = self.index.wrapping_add(1);
            if !stamp.usable {
                self.refused += 1;
                continue;
            }
            if let Some(last_us) = self.last_us.replace(stamp.t.0) {
                assert!(stamp.t.0 > last_us, "{last_us} to {stamp:?}");
                self.longest_us = self.longest_us.max(stamp.t.0 - last_us);
            }
        }
        let health = self.time.health();
        if self.seen.last().is_some_and(|(_, last)| *last != health) {
            self.seen.push((self.host_us, health));
        }
    }

    fn names(&self) -> Vec<&'static str> {
        self.seen.iter().map(|(_, health)| health.name()).collect()
    }
}

#[test]
fn device_time_is_pipeline_time_while_nothing_is_wrong() {
    for (tick_hz, step) in [(1_000_000, 100), (168_000_000, 16_800), (48_000, 5)] {
        let mut time = TimeBase::new(tick_hz, 10_000);
        for row in 0..1000_u32 {
            time.frame(u64::from(row) * 100);
            let tick = 5_000_000 + u64::from(row) * step;
            let stamp = time.row(row, tick);
            assert_eq!((stamp.t.0, stamp.usable), (super::micros(tick, tick_hz), true));
        }
    }
}

#[test]
fn a_clock_that_stops_is_replaced_by_row_numbers_and_followed_when_it_runs_again() {
    let mut device = Device::new(7_200_000_000);
    device.run(500);
    device.rate(0);
    device.run(2000);
    assert!(!device.time.follows_ticks());
    let lag_us = (device.host_us + 7_200_000_000).abs_diff(device.last_us.unwrap());
    device.rate(1);
    device.run(2000);
    assert_eq!(device.names(), ["good", "stopped", "good"]);
    assert!(device.seen[1].0 - 500_000 <= 50_000, "{:?}", device.seen);
    assert_eq!((device.refused, device.longest_us), (0, 100));
    assert!(lag_us < 1000 && device.time.take_resync() && device.time.follows_ticks());
}

#[test]
fn a_clock_that_jumps_is_followed_from_where_it_was() {
    let jumps = [
        (-3_000_000, "back"),
        (-3_600_000_000, "back"),
        (-500, "back"),
        (3_600_000_000, "forward"),
        (1 << 61, "forward"),
    ];
    for (jump, name) in jumps {
        let mut device = Device::new(7_200_000_000);
        device.run(500);
        device.clock.0 = device.clock.0.wrapping_add_signed(jump);
        device.run(45);
        assert!(device.time.take_resync() && device.time.follows_ticks(), "{jump}");
        device.run(3000);
        assert_eq!(device.names(), ["good", name, "good"], "{jump}");
        assert!(device.seen[1].0 - 500_000 <= 50_000, "{:?}", device.seen);
        assert_eq!((device.refused, device.longest_us), (0, 100), "{jump}");
    }
}

#[test]
fn counters_that_begin_anew_are_followed_within_50_ms() {
    let mut device = Device::new(7_200_000_000);
    device.run(500);
    (device.index, device.clock.0) = (0, 0);
    device.run(45);
    assert!(device.longest_us <= 50_000 && device.refused < 450, "{} us", device.longest_us);
    device.run(2000);
    assert_eq!(device.names(), ["good", "back", "good"]);
}

#[test]
fn old_frames_that_come_again_are_refused_and_change_nothing() {
    let mut device = Device::new(1000);
    device.run(100);
    for _ in 0..50 {
        device.run(3);
        let (index, host_us) = (device.index, device.host_us);
        device.index -= 25;
        device.frame(device.tick() - 3000);
        (device.index, device.host_us) = (index, host_us);
    }
    assert_eq!((device.names(), device.refused, device.longest_us), (vec!["good"], 500, 100));
}

#[test]
fn counters_wrap() {
    for tick in [u64::MAX - 200_000, (1 << 63) - 200_000, (1 << 32) - 200_000, u64::MAX - 5] {
        let mut device = Device::new(tick);
        device.index = u32::MAX - 1000;
        device.run(1000);
        assert_eq!(
            (device.names(), device.refused, device.longest_us),
            (vec!["good"], 0, 100),
            "{tick}"
        );
    }
}

#[test]
fn gaps_and_stalls_are_no_faults() {
    let mut device = Device::new(1000);
    device.run(100);
    // The device pauses for a second, with and without counting rows.
    device.host_us += 1_000_000;
    device.run(100);
    device.host_us += 1_000_000;
    device.index += 10_000;
    device.run(100);
    // The line holds 300 ms of frames back and delivers them at once.
    let now_us = device.host_us + 300_000;
    for _ in 0..300 {
        let real_us = device.host_us + 1000;
        device.host_us = real_us;
        let tick = device.tick();
        device.host_us = now_us;
        device.frame(tick);
        device.host_us = real_us;
    }
    device.run(100);
    assert_eq!((device.names(), device.refused), (vec!["good"], 0));
}

#[test]
fn a_wrong_rate_is_reported_and_ends() {
    let mut time = TimeBase::new(1_000_000, 1000);
    let mut health = |off| {
        time.set_rate_error(off);
        time.health()
    };
    assert_eq!(health(Some(0.05)), ClockHealth::Fast);
    assert_eq!(health(None), ClockHealth::Fast);
    assert_eq!(health(Some(0.009)), ClockHealth::Fast);
    assert_eq!(health(Some(-0.002)), ClockHealth::Good);
    assert_eq!(health(Some(-0.02)), ClockHealth::Slow);
}

/// What a frame does to the counters of the device and to the line.
#[derive(Clone, Debug)]
enum Step {
    Good,
    TickJump(i64),
    Tick(u64),
    IndexJump(i32),
    Stop,
    Pause(u64),
    Burst,
}

fn any_step() -> impl Strategy<Value = Step> {
    prop_oneof![
        6 => Just(Step::Good),
        1 => (-10_000_000_i64..10_000_000).prop_map(Step::TickJump),
        1 => any::<i64>().prop_map(Step::TickJump),
        1 => any::<u64>().prop_map(Step::Tick),
        1 => (-5000_i32..5000).prop_map(Step::IndexJump),
        1 => any::<i32>().prop_map(Step::IndexJump),
        1 => Just(Step::Stop),
        1 => (0_u64..2_000_000).prop_map(Step::Pause),
        1 => Just(Step::Burst),
    ]
}

proptest! {
    /// Whatever the counters do: time goes forward, by no more than host time, row numbers and the allowances state, and no more than
    /// 50 ms of frames in a row are refused.
    #[test]
    fn pipeline_time_only_goes_forward(
        first in any::<u64>(), dt in 0_u64..70_000, tick_hz in 1_u64..200_000_000, rate in 1_u32..50_000,
        steps in prop::collection::vec((any_step(), 1_usize..40), 1..40)
    ) {
        let mut time = TimeBase::new(tick_hz, rate);
        let (mut tick, mut index, mut host_us) = (first, 0_u32, 0_u64);
        let mut last: Option<(u64, u64)> = None;
        let mut refused_us: Option<u64> = None;
        for (step, frames) in steps {
            for k in 0..frames {
                host_us += if matches!(step, Step::Burst) { 0 } else { 1000 };
                match step {
                    Step::TickJump(by) if k == 0 => tick = tick.wrapping_add_signed(by),
                    Step::Tick(to) if k == 0 => tick = to,
                    Step::IndexJump(by) if k == 0 => index = index.wrapping_add_signed(by),
                    Step::Pause(us) if k == 0 => host_us += us,
                    _ => {}
                }
                time.frame(host_us);
                let mut usable = false;
                for row in 0..10 {
                    let stamp = time.row(index, tick.wrapping_add(row * dt));
                    index = index.wrapping_add(1);
                    let Some((t_us, at_us)) = last else {
                        (last, usable) = (Some((stamp.t.0, host_us)), true);
                        continue;
                    };
                    if !stamp.usable {
                        prop_assert_eq!(stamp.t.0, t_us);
                        continue;
                    }
                    usable = true;
                    prop_assert!(stamp.t.0 > t_us, "{} after {}", stamp.t.0, t_us);
                    let most_us = 3 * (host_us - at_us) + 2_000_000 + 2_100_000 + 2_000_000 / u64::from(rate);
                    prop_assert!(stamp.t.0 - t_us <= most_us, "{} us", stamp.t.0 - t_us);
                    last = Some((stamp.t.0, host_us));
                }
                let since = (!usable).then(|| refused_us.unwrap_or(host_us));
                refused_us = since;
                prop_assert!(since.is_none_or(|since| host_us - since <= 50_000 || matches!(step, Step::Pause(_))));
                if !matches!(step, Step::Stop) {
                    tick = tick.wrapping_add(10 * dt);
                }
            }
        }
    }
}
