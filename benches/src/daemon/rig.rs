//! The hot loop of gripd on a given clock, with all its rings and their other ends.

use grip_daemon::{
    HotCounters,
    hot::{Ends, Hot, HotOptions, Lost, Settings, Shared},
    rings::{Inbox, Sizes, rings},
};
use grip_port::Line;
use grip_session::{HostConfig, Session, SessionOptions, model};
use rtrb::{Consumer, Producer, RingBuffer};
use slip_core::ClientCommand;
use std::sync::Arc;

/// Room in the small rings.
const FEW: usize = 4;

/// The other ends of the rings.
#[derive(Debug)]
pub struct Far {
    /// Lines for the loop.
    pub lines: Producer<Line>,
    /// Lines that it has lost.
    pub lost: Consumer<Lost>,
    /// Settings for it.
    pub settings: Producer<Box<Settings>>,
    /// Settings that were replaced.
    pub replaced: Consumer<Box<Settings>>,
    /// Commands for it.
    pub commands: Producer<ClientCommand>,
    /// Copies of its counters.
    pub pulses: Consumer<HotCounters>,
    /// What the service thread would get.
    pub service: Inbox,
    /// What the recorder would get.
    pub recorder: Inbox,
    /// What is shared.
    pub shared: Arc<Shared>,
}

/// A loop that waits for a line, as gripd makes it: for a patient daemon that records. `clock` gives nanoseconds since the start.
///
/// # Errors
/// Where settings or model are refused.
pub fn rig<C: Fn() -> u64>(config: HostConfig, clock: C) -> anyhow::Result<(Hot<C>, Far)> {
    let estimator = model::default_estimator()?;
    let spin_us = config.realtime.spins_us();
    let session = Session::new(config, estimator, SessionOptions::default())?;
    let shared = Arc::new(Shared::default());
    let (service_in, service) = rings(Sizes::SERVICE);
    let (recorder_in, recorder) = rings(Sizes::RECORDER);
    let (lines, lines_out) = RingBuffer::new(FEW);
    let (lost_in, lost) = RingBuffer::new(FEW);
    let (settings, settings_out) = RingBuffer::new(FEW);
    let (replaced_in, replaced) = RingBuffer::new(FEW);
    let (commands, commands_out) = RingBuffer::new(FEW);
    let (pulses_in, pulses) = RingBuffer::new(FEW);
    let ends = Ends {
        lines: lines_out,
        lost: lost_in,
        settings: settings_out,
        replaced: replaced_in,
        commands: commands_out,
        service: service_in,
        recorder: Some(recorder_in),
        pulses: pulses_in,
        shared: Arc::clone(&shared),
    };
    let options = HotOptions { end_us: u64::MAX, patient: true, spin_us };
    let far = Far { lines, lost, settings, replaced, commands, pulses, service, recorder, shared };
    Ok((Hot::new(session, clock, options, ends), far))
}
