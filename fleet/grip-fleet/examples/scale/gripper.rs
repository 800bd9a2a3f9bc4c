//! An address in; many pipelines that report their slips to it, and lines about what they did, out.

use super::{Args, network, now_us, pause, tape};
use anyhow::Context as _;
use core::time::Duration;

use grip_fleet::net::{Announced, Network, Session};
use grip_fleet::{EventId, EventLog as KeptEvents, Member, Spool, Topic, Uid, wire};
use grip_link::message::Kind;
use grip_link::message::daemon::{Gripper as Identity, Health, SlipReport};
use grip_session::report::{Event, EventLog};
use grip_session::{HostConfig, HostEstimator, model};
use slip_core::units::Hertz;
use slip_core::{Pipeline, PipelineConfig, Sample};
use slip_core::{Signal, units::Micros};
use std::sync::Arc;

/// Samples of a frame, as a gripper sends them: ten milliseconds.
const BATCH: u64 = 10;
/// Frames from one HEALTH to the next.
const FIGURES: u64 = 100;
/// Room for events (bytes).
const ROOM: usize = 1 << 20;
/// How long events may still travel after the last sample.
const AFTER: Duration = Duration::from_secs(15);

struct Gripper {
    uid: Uid,
    pipeline: Pipeline<Arc<[f32]>>,
    log: EventLog,
    tape: Arc<[Sample]>,
    /// Where on the tape it began.
    offset: u64,
    spool: Spool,
    slips: u32,
    announced: Announced,
    _session: Session,
    identity: Vec<u8>,
    figures: Vec<u8>,
}

/// Runs grippers for the time asked for and reports what each of them has sent.
pub(crate) fn run(address: &str, first: u16, count: u16, args: &Args) -> anyhow::Result<()> {
    let tapes = (0..6).map(|seed| tape::record(seed).map(Arc::from));
    let tapes = tapes.collect::<anyhow::Result<Vec<Arc<[Sample]>>>>()?;
    let estimator = model::default_estimator()?;
    let way = network::client(args, address)?;
    let made = tapes.iter().cycle().zip(first..first + count);
    let made = made.map(|(tape, uid)| Gripper::new(tape, uid, &estimator, &way.network));
    let mut grippers = made.collect::<anyhow::Result<Vec<Gripper>>>()?;
    println!("ready");
    let frames = u64::from(args.seconds) * u64::from(tape::RATE_HZ) / BATCH;
    let start_us = now_us();
    let mut latest_us = 0;
    for frame in 0..frames {
        // A frame goes when its last sample is there.
        let due_us = start_us + sample_us((frame + 1) * BATCH);
        pause(Duration::from_micros(due_us.saturating_sub(now_us())));
        grippers.iter_mut().try_for_each(|gripper| gripper.frame(frame, start_us))?;
        latest_us = latest_us.max(now_us().saturating_sub(due_us));
    }
    for gripper in &grippers {
        let head = gripper.spool.log().head();
        println!("sent {} {} {}", gripper.uid, head.run, head.seq);
    }
    println!("late {latest_us}");
    println!("done");
    // Whoever has missed something asks for it.
    let end_us = now_us() + u64::try_from(AFTER.as_micros())?;
    let mut turn = 0;
    while now_us() < end_us {
        grippers.iter_mut().for_each(|gripper| gripper.rest(turn));
        turn += 1;
        pause(Duration::from_millis(10));
    }
    Ok(())
}

impl Gripper {
    fn new(
        tape: &Arc<[Sample]>,
        number: u16,
        estimator: &HostEstimator,
        network: &Network,
    ) -> anyhow::Result<Self> {
        let rate = Hertz(1000.0);
        let config = PipelineConfig {
            grip: None,
            ..HostConfig::default().pipeline(Signal::Displacement, rate)
        };
        let mut uid = [0; 16];
        uid[..2].copy_from_slice(&(number + 1).to_be_bytes());
        let identity = Identity { uid, boot_id: 1, ..Identity::NONE };
        let session = network.open()?;
        let member = Member { site: "scale".parse()?, uid: Uid(uid) };
        Ok(Self {
            uid: Uid(uid),
            pipeline: Pipeline::new(config, Some(estimator.clone()))?,
            log: EventLog::default(),
            tape: Arc::clone(tape),
            offset: 37 * u64::from(number),
            spool: Spool::in_memory(1, ROOM),
            slips: 0,
            announced: Announced::new(&session, &member, &[])?,
            _session: session,
            identity: wire(Kind::GRIPPER, |out| identity.write(out).unwrap_or(0)),
            figures: wire(Kind::HEALTH, |out| Health::default().write(out).unwrap_or(0)),
        })
    }

    /// Ten milliseconds of samples, and what a daemon does with what comes of them.
    fn frame(&mut self, frame: u64, start_us: u64) -> anyhow::Result<()> {
        for number in frame * BATCH..(frame + 1) * BATCH {
            let sample = tape::sample(&self.tape, self.offset + number).context("an empty tape")?;
            let step = self.pipeline.handle(&sample);
            for line in self.log.events(&step).into_iter().flatten() {
                self.report(start_us + sample_us(number + 1), &line)?;
            }
        }
        self.rest(frame);
        Ok(())
    }

    /// Keeps a slip, then reports it. Its time is that of the sample that showed it: waiting for the frame, and for the other grippers of this
    /// thread, is a part of the delay.
    fn report(&mut self, sampled_us: u64, line: &Event) -> anyhow::Result<()> {
        let Event::Slip(slip) = line else { return Ok(()) };
        self.slips += 1;
        let slip = SlipReport { number: self.slips, host: Micros(sampled_us), ..*slip };
        let wire = wire(Kind::SLIP, |out| slip.write(out).unwrap_or(0));
        let id = self.spool.append(wire.clone());
        self.publish(Topic::Events, id, &wire);
        Ok(())
    }

    fn publish(&mut self, topic: Topic, id: EventId, wire: &[u8]) {
        self.announced.publish(topic, id, wire);
    }

    /// What goes on without samples: figures still state what the last event was. Grippers of their own are not switched on in the same
    /// millisecond, so each has another moment of the second for them.
    fn rest(&mut self, turn: u64) {
        if (turn + self.offset).is_multiple_of(FIGURES) {
            let head = self.spool.log().head();
            self.publish(Topic::Health, head, &self.figures.clone());
        }
        self.answer();
    }

    fn answer(&mut self) {
        let with_log = |use_it: &mut dyn FnMut(&KeptEvents)| use_it(self.spool.log());
        self.announced.answer(&with_log, &[&self.identity, &self.figures], "");
    }
}

/// When so many samples are there (us).
fn sample_us(count: u64) -> u64 {
    count * 1_000_000 / u64::from(tape::RATE_HZ)
}
