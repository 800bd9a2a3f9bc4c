//! The built-in gripper: a virtual microcontroller on a thread of its own, behind a real pseudo-terminal.

use crate::clock::Clock;
use anyhow::{Context as _, anyhow};
use core::sync::atomic::{AtomicBool, Ordering};
use grip_sim::{Pty, Scene, Truth, VirtualMcu, port};
use std::{
    sync::Arc,
    thread::{self, JoinHandle},
};

/// The running simulator.
#[derive(Debug)]
pub(crate) struct Simulator {
    port: String,
    stop: Arc<AtomicBool>,
    thread: JoinHandle<anyhow::Result<Truth>>,
}

impl Simulator {
    pub(crate) fn start(scene: &Scene, clock: Clock) -> anyhow::Result<Self> {
        let mut mcu = VirtualMcu::new(scene, 1).context("the scene makes no gripper")?;
        let pty = Pty::open(None).context("cannot open a pseudo-terminal")?;
        let port = pty.port().display().to_string();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let thread = thread::Builder::new().name("simulator".to_owned()).spawn(move || {
            port::run(&mut mcu, &pty, &stopped, || clock.now_us())
                .context("the simulator's line failed")?;
            Ok(mcu.truth())
        })?;
        Ok(Self { port, stop, thread })
    }

    pub(crate) fn port(&self) -> String {
        self.port.clone()
    }

    pub(crate) fn stop(self) -> anyhow::Result<Truth> {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.join().map_err(|_| anyhow!("the simulator thread failed"))?
    }
}
