//! Where there is no pseudo-terminal yet: one that cannot be opened.

use super::{PtyError, Ready};
use core::convert::Infallible;
use std::{io, path::Path};

/// A pseudo-terminal, of which there are none on this system.
#[derive(Debug)]
pub struct Pty(Infallible);

impl Pty {
    /// Refuses.
    ///
    /// # Errors
    /// Always: [`PtyError::Call`].
    pub fn open(_link: Option<&Path>) -> Result<Self, PtyError> {
        let source = io::Error::new(
            io::ErrorKind::Unsupported,
            "the built-in gripper and `gripctl sim` run on Linux only so far",
        );
        Err(PtyError::Call { call: "openpt", source })
    }

    /// As on Linux.
    #[must_use]
    pub fn port(&self) -> &Path {
        match self.0 {}
    }

    /// As on Linux.
    ///
    /// # Errors
    /// Never.
    pub fn wait(&self, _timeout_us: u64, _to_write: bool) -> Result<Ready, PtyError> {
        match self.0 {}
    }

    /// As on Linux.
    ///
    /// # Errors
    /// Never.
    pub fn read(&self, _buffer: &mut [u8]) -> Result<usize, PtyError> {
        match self.0 {}
    }

    /// As on Linux.
    ///
    /// # Errors
    /// Never.
    pub fn write(&self, _bytes: &[u8]) -> Result<usize, PtyError> {
        match self.0 {}
    }
}
