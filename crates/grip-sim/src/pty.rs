//! Pseudo-terminal, with a link to it where a path is given: the virtual gripper's serial port.
//!
//! The host opens [`Pty::port`] (or the link) as if it were a serial port; the virtual microcontroller reads and
//! writes the other side without ever blocking. The line is raw: every byte passes unchanged. The
//! host's side stays open inside, so a host may come, go and come back.
//!
//! Only Linux has it so far: elsewhere [`Pty::open`] states that it does not.

use std::path::PathBuf;

#[cfg_attr(not(target_os = "linux"), path = "pty/absent.rs")]
mod terminal;

pub use terminal::Pty;

/// Why the pseudo-terminal could not be opened or used.
#[derive(Debug, thiserror::Error)]
pub enum PtyError {
    /// A system call failed.
    #[error("pseudo-terminal: {call} failed")]
    Call {
        /// Which one.
        call: &'static str,
        /// Why.
        source: std::io::Error,
    },
    /// The link could not be made.
    #[error("cannot link {link} to {port}")]
    Link {
        /// Path asked for.
        link: PathBuf,
        /// The terminal it should point at.
        port: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// Something that is not a link stands at the path of the link.
    #[error("{0} exists and is not a symbolic link; it stays untouched")]
    Occupied(PathBuf),
}

/// What a wait ended with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ready {
    /// Bytes can be read.
    pub read: bool,
    /// Bytes can be written.
    pub write: bool,
}

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests {
    use super::*;
    use std::fs::OpenOptions;
    use std::io::{Read, Write};

    #[test]
    fn every_byte_passes_unchanged_both_ways() {
        let pty = Pty::open(None).unwrap();
        let mut host = OpenOptions::new().read(true).write(true).open(pty.port()).unwrap();
        let all: Vec<u8> = (0..=255).collect();
        host.write_all(&all).unwrap();
        let mut got = Vec::new();
        while got.len() < all.len() {
            assert!(pty.wait(1_000_000, false).unwrap().read);
            let mut buffer = [0; 64];
            let count = pty.read(&mut buffer).unwrap();
            got.extend_from_slice(&buffer[..count]);
        }
        assert_eq!(got, all);
        assert_eq!(pty.write(&all).unwrap(), all.len());
        let mut back = [0; 256];
        host.read_exact(&mut back).unwrap();
        assert_eq!(back.as_slice(), all);
    }

    #[test]
    fn a_silent_host_never_blocks_and_a_lost_one_is_no_error() {
        let pty = Pty::open(None).unwrap();
        assert_eq!(pty.read(&mut [0; 8]).unwrap(), 0);
        assert_eq!(pty.wait(0, false).unwrap(), Ready::default());
        let mut taken = 0;
        for _ in 0..10_000 {
            let count = pty.write(&[7; 512]).unwrap();
            if count == 0 {
                break;
            }
            taken += count;
        }
        assert!(taken > 0 && pty.write(&[7; 512]).unwrap() == 0);
        drop(OpenOptions::new().read(true).open(pty.port()).unwrap());
        assert_eq!(pty.read(&mut [0; 8]).unwrap(), 0);
    }

    #[test]
    fn the_link_comes_and_goes() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("gripper");
        let pty = Pty::open(Some(&link)).unwrap();
        assert_eq!(std::fs::read_link(&link).unwrap(), pty.port());
        let second = Pty::open(Some(&link)).unwrap();
        drop(pty);
        assert_eq!(std::fs::read_link(&link).unwrap(), second.port());
        drop(second);
        assert!(link.symlink_metadata().is_err());
        std::fs::write(&link, "mine").unwrap();
        assert!(matches!(Pty::open(Some(&link)), Err(PtyError::Occupied(_))));
        assert_eq!(std::fs::read_to_string(&link).unwrap(), "mine");
    }
}
