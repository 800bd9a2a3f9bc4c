//! Seeded grasps in, the times from writing a frame to reading the command, through the kernel and another thread, out.
//!
//! The gripper writes its bytes, the host answers each read with one write: the command first, then what else is due,
//! or a lone delimiter, which means nothing on the link. Both share the simulated time, which stands still in between.

use crate::{
    now,
    session::{GRASP, pair},
    table::{histogram, record},
};
use core::{
    error::Error,
    sync::atomic::{AtomicBool, AtomicU64, Ordering},
};
use grip_link::frame::MAX_WIRE;
use grip_session::Session;
use grip_sim::VirtualMcu;
use hdrhistogram::Histogram;
use std::{
    io::{self, Read, Write},
    os::unix::net::UnixStream,
    thread,
};

/// Room for every answer: it arrives with one read.
const ANSWER: usize = 8 * MAX_WIRE;

/// What both threads know beside the bytes.
#[derive(Debug, Default)]
struct Shared {
    now_us: AtomicU64,
    commanded: AtomicBool,
}

/// Times there and back of the frames answered with a command, over `count` grasps.
pub(crate) fn grasps(count: u64) -> Result<Histogram<u64>, Box<dyn Error>> {
    let mut times = histogram()?;
    for seed in 0..count {
        let (mut mcu, mut session) = pair(seed)?;
        let (device, host) = UnixStream::pair()?;
        let shared = Shared::default();
        thread::scope(|threads| {
            let answering = threads.spawn(|| answer(&mut session, host, &shared));
            let played = play(&mut mcu, device, &shared, &mut times);
            let answered = answering.join().map_err(|_| io::Error::other("the host panicked"))?;
            played.and(answered)
        })?;
    }
    Ok(times)
}

/// The gripper's side, until the grasp is over; closing the socket then ends the host's side.
fn play(
    mcu: &mut VirtualMcu,
    mut socket: UnixStream,
    shared: &Shared,
    times: &mut Histogram<u64>,
) -> io::Result<()> {
    let (mut bytes, mut answer) = (Vec::with_capacity(4 * MAX_WIRE), [0; ANSWER]);
    loop {
        let t = mcu.next_due();
        if t > GRASP {
            return Ok(());
        }
        mcu.advance(t);
        // Nothing to send is sent as an empty block, so that the host can speak first.
        bytes.clear();
        bytes.push(0);
        mcu.transmit(t, &mut bytes);
        shared.now_us.store(t.0, Ordering::Release);
        let start = now();
        socket.write_all(&bytes)?;
        let len = socket.read(&mut answer)?;
        let time = start.elapsed();
        if len == 0 {
            return Err(io::Error::other("the host gave up"));
        }
        if shared.commanded.load(Ordering::Acquire) {
            record(times, time);
        }
        mcu.receive(t, answer.get(..len).unwrap_or(&answer));
    }
}

/// The host's side, until the socket closes.
fn answer(session: &mut Session, mut socket: UnixStream, shared: &Shared) -> io::Result<()> {
    let (mut bytes, mut out) = ([0; ANSWER], [0; MAX_WIRE]);
    let mut reply = Vec::with_capacity(ANSWER);
    loop {
        let len = socket.read(&mut bytes)?;
        let received = match bytes.get(..len) {
            None | Some([]) => return Ok(()),
            Some(received) => received,
        };
        let now_us = shared.now_us.load(Ordering::Acquire);
        let command = session.answer(now_us, received, &mut out).map_err(io::Error::other)?;
        reply.clear();
        reply.extend(out.iter().take(command.unwrap_or(0)));
        while let Some(len) = session.poll_transmit(now_us, &mut out) {
            reply.extend(out.iter().take(len));
        }
        if reply.is_empty() {
            reply.push(0);
        }
        shared.commanded.store(command.is_some(), Ordering::Release);
        socket.write_all(&reply)?;
    }
}
