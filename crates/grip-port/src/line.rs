//! An open serial line: bytes in and out, with the errors a person can use.

use crate::PortError;
use core::{
    fmt,
    hash::{BuildHasher as _, Hasher as _},
};
use serialport::SerialPort;
use std::{
    collections::hash_map::RandomState,
    io::{self, Read as _, Write as _},
};

/// A line that this process alone holds.
pub struct Line(Box<dyn SerialPort>);

impl fmt::Debug for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Line").field(&self.0.name()).finish()
    }
}

impl Line {
    pub(crate) fn new(port: Box<dyn SerialPort>) -> Self {
        Self(port)
    }

    /// Reads what has come into `input`: its length, 0 where nothing came within 2 ms or a signal ended the wait.
    ///
    /// # Errors
    /// Where the other end is gone.
    pub fn read(&mut self, input: &mut [u8]) -> Result<usize, PortError> {
        match self.0.read(input) {
            Ok(0) => Err(PortError::Closed),
            Ok(count) => Ok(count),
            Err(error)
                if matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::Interrupted) =>
            {
                Ok(0)
            }
            Err(error) => Err(PortError::Read(error)),
        }
    }

    /// Writes a whole frame with as few writes as the line allows.
    ///
    /// # Errors
    /// Where the line does not take it.
    pub fn write(&mut self, frame: &[u8]) -> Result<(), PortError> {
        self.0.write_all(frame).map_err(PortError::Write)
    }
}

/// A session number that differs from start to start, never 0.
#[must_use]
pub fn nonce() -> u16 {
    let random = RandomState::new().build_hasher().finish();
    u16::try_from(random % 0xFFFF).unwrap_or(0) + 1
}
