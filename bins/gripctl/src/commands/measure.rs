//! Recording of the gripper at a port at rest, and in motion where that is wanted. Nothing is commanded.

use super::{attach::Attached, checked};
use crate::{cli::CalibrateArgs, output};
use anyhow::anyhow;
use core::sync::atomic::{AtomicBool, Ordering};
use grip_record::{Channel, ChannelSet, Notes, Recording, StylusKind};
use grip_session::{HostConfig, exit::WrongArgument};
use slip_core::Sample;
use std::{
    io::{self, IsTerminal as _},
    sync::Arc,
    thread,
};

/// Longest measurement (s): an hour at 20 kHz still fits the memory of a small computer.
const LONGEST_S: f64 = 3600.0;
/// No sample for so long ends the measurement (us).
const PATIENCE_US: u64 = 5_000_000;

/// What was measured, and what was lost on the way.
#[derive(Debug)]
pub(crate) struct Measured {
    pub(crate) recording: Recording,
    pub(crate) lost: u64,
}

/// Measures at `port` as `args` state.
pub(crate) fn measure(
    port: &str,
    args: &CalibrateArgs,
    config: &HostConfig,
) -> anyhow::Result<Measured> {
    let rest_s = seconds("--rest-s", args.rest_s)?;
    let motion_s = args.motion_s.map(|s| seconds("--motion-s", s)).transpose()?;
    let gripper = Attached::open(port, args.seed, args.baud, config)?;
    let mut meter = Meter { gripper, stop: output::stopped()?, samples: Vec::new() };
    eprintln!(
        "gripctl: measuring {rest_s:.0} s of stillness: keep robot and gripper still; what is held must not slip"
    );
    meter.run(rest_s, None)?;
    if let Some(motion_s) = motion_s {
        meter.wait_for_motion(motion_s)?;
        meter.run(motion_s, Some(1.0))?;
    }
    meter.finish()
}

fn seconds(flag: &str, value: f64) -> Result<f64, WrongArgument> {
    match checked(flag, value, false)? {
        value if value <= LONGEST_S => Ok(value),
        value => Err(WrongArgument(format!("{flag} {value}: expected at most {LONGEST_S} s"))),
    }
}

/// The gripper that is being listened to.
struct Meter {
    gripper: Attached,
    stop: Arc<AtomicBool>,
    samples: Vec<Sample>,
}

impl Meter {
    /// Listens until there are `wanted_s` more of samples; `motion` overrides what the gripper reports of it.
    fn run(&mut self, wanted_s: f64, motion: Option<f32>) -> anyhow::Result<()> {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "within an hour"
        )]
        let whole = |s: f64| s.ceil() as u64;
        let bar = output::progress(usize::try_from(whole(wanted_s))?, "s");
        let mut first = None;
        let mut received_us = self.gripper.clock.now_us();
        loop {
            let from = self.samples.len();
            let now_us = self.turn(motion)?;
            if self.samples.len() > from {
                received_us = now_us;
            } else if now_us.saturating_sub(received_us) > PATIENCE_US {
                return Err(anyhow!("no samples came for {} s", PATIENCE_US / 1_000_000));
            }
            let Some(last) = self.samples.last().map(|sample| sample.t) else { continue };
            let begin = *first.get_or_insert(last);
            bar.set_position(whole(last.since(begin).as_seconds()));
            if self.samples.len() > from && last.since(begin).as_seconds() >= wanted_s {
                bar.finish();
                return Ok(());
            }
        }
    }

    /// Asks for motion: on a terminal it waits for Enter, listening meanwhile so that the link stays open.
    fn wait_for_motion(&mut self, motion_s: f64) -> anyhow::Result<()> {
        if !io::stdin().is_terminal() {
            eprintln!("gripctl: now {motion_s:.0} s of motion, as in work; nothing may slip");
            return Ok(());
        }
        eprintln!(
            "gripctl: let the robot move as in work for {motion_s:.0} s, nothing may slip; press Enter when it moves"
        );
        let ready = Arc::new(AtomicBool::new(false));
        let entered = Arc::clone(&ready);
        thread::spawn(move || {
            // A closed standard input starts the motion as well.
            let _ = io::stdin().read_line(&mut String::new());
            entered.store(true, Ordering::Relaxed);
        });
        let kept = self.samples.len();
        while !ready.load(Ordering::Relaxed) {
            self.turn(None)?;
            self.samples.truncate(kept);
        }
        Ok(())
    }

    /// One look at the line; the time (us).
    fn turn(&mut self, motion: Option<f32>) -> anyhow::Result<u64> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(anyhow!("interrupted; nothing was written"));
        }
        let samples = &mut self.samples;
        self.gripper.turn(&mut |sample| {
            samples.push(Sample { motion: motion.or(sample.motion), ..*sample });
        })
    }

    fn finish(self) -> anyhow::Result<Measured> {
        let session = self.gripper.close()?;
        let link = session.link();
        let config = link.in_force().ok_or_else(|| anyhow!("the gripper has lost its settings"))?;
        let rate_hz = config.sample_rate_hz as f32;
        let present =
            |channel: &Channel| self.samples.iter().any(|sample| channel.reading(sample).is_some());
        let channels = Channel::ALL
            .into_iter()
            .filter(present)
            .fold(ChannelSet::new(StylusKind::Displacement), ChannelSet::with);
        let lost = link.loss().lost;
        let recording = Recording {
            name: "live".to_owned(),
            channels,
            samples: self.samples,
            taxels: None,
            rate_hz,
            notes: Notes::default(),
        };
        Ok(Measured { recording, lost })
    }
}
