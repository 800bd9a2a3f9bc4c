//! Hand of an older controller, from bytes of a gripper to commands: the link of gripd without its pipeline.

use super::ForceLaw;
use crate::grasp::hand::Hand;
use grip_link::{
    frame::MAX_WIRE,
    host::{GripCommand, HostConfig as LinkSettings, HostEvent, HostLink},
    message::{ChannelKind, Row, Samples},
};
use grip_session::{
    config::HostConfig,
    session::{SessionError, device_config},
};
use grip_sim::Truth;
use slip_core::{Sample, units::Micros};

/// How long the fingers stay open while the noise is learned.
const LEARN: Micros = Micros(200_000);

/// A hand that follows an older law.
pub(crate) struct Baseline {
    link: HostLink,
    law: Box<dyn ForceLaw>,
    f_max_n: f64,
    begun: Option<Micros>,
    command_n: Option<f32>,
    samples: u64,
}

impl Baseline {
    pub(crate) fn new(config: &HostConfig, law: Box<dyn ForceLaw>) -> Result<Self, SessionError> {
        let mut link = HostLink::new(LinkSettings::new(device_config(config)))?;
        link.open(0, 1)?;
        let f_max_n = f64::from(config.grip.f_max_n);
        Ok(Self { link, law, f_max_n, begun: None, command_n: None, samples: 0 })
    }

    fn take(&mut self, now_us: u64, mut bytes: &[u8]) -> bool {
        let mut fresh = false;
        let Self { link, law, f_max_n, begun, command_n, samples } = self;
        while let Some(event) = link.receive(now_us, &mut bytes) {
            let HostEvent::Samples { header, .. } = event else { continue };
            for row in link.samples(header).iter().flat_map(Samples::rows) {
                let sample = sample_of(&row);
                let first = *begun.get_or_insert(sample.t);
                *samples += 1;
                fresh = true;
                if sample.t.since(first) < LEARN {
                    law.learn(&sample);
                    continue;
                }
                let force_n = law.force_n(&sample).min(*f_max_n);
                #[expect(clippy::cast_possible_truncation, reason = "a force needs no more digits")]
                let force_n = force_n as f32;
                *command_n = Some(force_n);
            }
        }
        fresh
    }
}

impl Hand for Baseline {
    fn serve(
        &mut self,
        now_us: u64,
        bytes: &[u8],
        send: &mut dyn FnMut(&[u8]),
    ) -> Result<(), SessionError> {
        let mut out = [0; MAX_WIRE];
        if self.take(now_us, bytes) {
            let command = self.command_n.and_then(GripCommand::newtons);
            let len = command.and_then(|command| self.link.grip(now_us, &command, &mut out));
            if let Some(len) = len {
                send(out.get(..len).unwrap_or(&out));
            }
        }
        while let Some(len) = self.link.poll_transmit(now_us, &mut out) {
            send(out.get(..len).unwrap_or(&out));
        }
        Ok(())
    }

    fn witness(&mut self, truth: &Truth) {
        self.law.witness(truth);
    }

    fn command_n(&self) -> f32 {
        self.command_n.unwrap_or(0.0)
    }

    fn slips(&self) -> u64 {
        self.law.slips()
    }

    fn samples(&self) -> (u64, u64) {
        (self.samples, self.link.loss().lost)
    }
}

/// The simulated gripper ticks in microseconds.
fn sample_of(row: &Row<'_>) -> Sample {
    let channel = |kind| row.read(kind).filter(|value| !value.is_nan());
    Sample {
        normal_force_n: channel(ChannelKind::NormalForce),
        tangential_n: channel(ChannelKind::TangentialForce),
        ..Sample::stylus(Micros(row.tick), row.read(ChannelKind::Stylus).unwrap_or(f32::NAN))
    }
}
