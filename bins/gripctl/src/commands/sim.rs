//! `gripctl sim`: a virtual gripper on a pseudo-terminal.

use crate::{cli::SimArgs, output};
use anyhow::Context as _;
use core::{
    hash::{BuildHasher as _, Hasher as _},
    sync::atomic::Ordering,
};
use grip_session::exit::{Exit, WrongArgument};
use grip_sim::{Pty, VirtualMcu, port};
use std::{hash::RandomState, time::Instant};

/// Another number at every start, as the link asks for.
fn boot_id() -> u32 {
    let [a, b, c, d, ..] = RandomState::new().build_hasher().finish().to_le_bytes();
    u32::from_le_bytes([a, b, c, d])
}

pub(crate) fn run(args: &SimArgs) -> anyhow::Result<Exit> {
    if let Some(duration) = args.duration.filter(|s| !(*s > 0.0 && *s <= 1e9)) {
        let message = format!("--duration {duration}: expected seconds, more than 0");
        return Err(WrongArgument(message).into());
    }
    let scene = super::scene(&args.scene, args.seed)?;
    let mut mcu = VirtualMcu::new(&scene, boot_id()).context("the scene makes no gripper")?;
    let pty = Pty::open(Some(&args.pty)).context("cannot open a pseudo-terminal")?;
    let stop = output::stopped().context("cannot take over Ctrl-C")?;
    eprintln!(
        "gripctl: scene {} is a gripper at {}; attach with: gripd --port {}",
        scene.config().name,
        args.pty.display(),
        args.pty.display()
    );
    let start = now();
    let clock = || {
        let elapsed = start.elapsed();
        if args.duration.is_some_and(|s| elapsed.as_secs_f64() >= s) {
            stop.store(true, Ordering::Relaxed);
        }
        u64::try_from(elapsed.as_micros()).unwrap_or(u64::MAX)
    };
    port::run(&mut mcu, &pty, &stop, clock)?;
    let truth = mcu.truth();
    eprintln!(
        "gripctl: force {:.2} N of {:.2} N needed, slipped {:.2} mm{}",
        truth.applied_n,
        truth.force_needed_n,
        truth.slip_mm(),
        if truth.dropped() { ", dropped" } else { "" }
    );
    Ok(Exit::Done)
}

#[expect(clippy::disallowed_methods, reason = "the one clock of this command")]
fn now() -> Instant {
    Instant::now()
}
