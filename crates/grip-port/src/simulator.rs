//! The built-in gripper: a virtual microcontroller on a thread of its own, behind a real pseudo-terminal.

use crate::PortError;
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
    thread: JoinHandle<Result<Truth, PortError>>,
}

impl Simulator {
    /// Starts the gripper of `scene`; `clock` gives microseconds and never goes back.
    pub(crate) fn start(
        scene: &Scene,
        clock: impl FnMut() -> u64 + Send + 'static,
    ) -> Result<Self, PortError> {
        let mut mcu = VirtualMcu::new(scene, 1).map_err(PortError::Device)?;
        let pty = Pty::open(None).map_err(PortError::Pty)?;
        let port = pty.port().display().to_string();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let run = move || {
            port::run(&mut mcu, &pty, &stopped, clock).map_err(PortError::SimulatedLine)?;
            Ok(mcu.truth())
        };
        let thread = thread::Builder::new()
            .name("simulator".to_owned())
            .spawn(run)
            .map_err(|error| PortError::Thread(Some(error)))?;
        Ok(Self { port, stop, thread })
    }

    pub(crate) fn port(&self) -> &str {
        &self.port
    }

    pub(crate) fn stop(self) -> Result<Truth, PortError> {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.join().map_err(|_| PortError::Thread(None))?
    }
}
