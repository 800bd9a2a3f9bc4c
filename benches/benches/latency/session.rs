//! Latency of a session over seeded grasps: the times from the bytes of a frame to the bytes of the command.

use crate::{histogram, now, record};
use core::error::Error;
use grip_link::frame::MAX_WIRE;
use grip_session::{HostConfig, Session, SessionOptions, model};
use grip_sim::{VirtualMcu, scene};
use hdrhistogram::Histogram;
use slip_core::units::Micros;

/// Simulated time of a grasp: closing, lift, slip and hold.
const GRASP: Micros = Micros(2_000_000);

/// The gripper and its host for the object of `seed`, both before the first byte.
fn pair(seed: u64) -> Result<(VirtualMcu, Session), Box<dyn Error>> {
    let scene = scene::load("default")?.reseeded(seed)?;
    let estimator = model::default_estimator()?;
    let mut session = Session::new(HostConfig::default(), estimator, SessionOptions::default())?;
    session.open(0, 1)?;
    Ok((VirtualMcu::new(&scene, 1)?, session))
}

/// Times of the calls of `Session::answer` that answer samples with a command, over `count` grasps in lockstep.
pub(crate) fn grasps(count: u64) -> Result<Histogram<u64>, Box<dyn Error>> {
    let mut times = histogram()?;
    for seed in 0..count {
        grasp(seed, &mut times)?;
    }
    Ok(times)
}

fn grasp(seed: u64, times: &mut Histogram<u64>) -> Result<(), Box<dyn Error>> {
    let (mut mcu, mut session) = pair(seed)?;
    let (mut bytes, mut out) = (Vec::with_capacity(4 * MAX_WIRE), [0; MAX_WIRE]);
    loop {
        let t = mcu.next_due();
        if t > GRASP {
            return Ok(());
        }
        mcu.advance(t);
        bytes.clear();
        mcu.transmit(t, &mut bytes);
        let start = now();
        let command = session.answer(t.0, &bytes, &mut out)?;
        let time = start.elapsed();
        if let Some(len) = command {
            record(times, time);
            mcu.receive(t, out.get(..len).unwrap_or(&out));
        }
        while let Some(len) = session.poll_transmit(t.0, &mut out) {
            mcu.receive(t, out.get(..len).unwrap_or(&out));
        }
    }
}
