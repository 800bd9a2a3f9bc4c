//! The virtual gripper for programs that know only [`Peer`]s.

use super::VirtualMcu;
use crate::grasp::Phase;
use crate::scene;
use grip_link::{
    device::{DeviceLink, Fate, Peer, Truth},
    frame::MAX_WIRE,
};
use slip_core::units::Micros;

impl Peer for VirtualMcu {
    fn now_us(&self) -> u64 {
        self.grasp().now().0
    }

    fn next_due_us(&self) -> u64 {
        self.next_due().0
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) {
        Self::receive(self, Micros(now_us), bytes);
    }

    fn poll_transmit(&mut self, now_us: u64, out: &mut [u8; MAX_WIRE]) -> Option<usize> {
        Self::poll_transmit(self, Micros(now_us), out)
    }

    fn link(&self) -> &DeviceLink {
        Self::link(self)
    }

    #[expect(clippy::cast_possible_truncation, reason = "newtons of a finger")]
    fn truth(&self) -> Option<Truth> {
        let truth = Self::truth(self);
        let fate = match truth.phase {
            Phase::Open | Phase::Supported => None,
            Phase::Dropped => Some(Fate::Dropped),
            Phase::Lifted if truth.crushed => Some(Fate::Crushed),
            Phase::Lifted if truth.slipping => Some(Fate::Slipping),
            Phase::Lifted => Some(Fate::Held),
        };
        Some(Truth { needed_n: truth.needed_now_n as f32, fate })
    }
}

/// The gripper of a scene, by its name or its file, with the object of `seed`; and a sentence about that object.
///
/// # Errors
/// A sentence, where there is no such scene or it makes no gripper.
pub fn peer(scene: &str, seed: u64, boot_id: u32) -> Result<(Box<dyn Peer>, String), String> {
    let scene = scene::open(scene).map_err(|error| error.to_string())?;
    let scene = scene.reseeded(seed).map_err(|error| error.to_string())?;
    let object = scene.object();
    let text = format!(
        "next object: {:.0} g, friction {:.2}, needs {:.2} N",
        1e3 * object.mass_kg,
        object.friction,
        object.force_needed_n()
    );
    let mcu = VirtualMcu::new(&scene, boot_id).map_err(|error| error.to_string())?;
    Ok((Box::new(mcu), text))
}
