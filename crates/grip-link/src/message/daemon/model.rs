//! SETUP and LOAD: which model the daemon works with, and another one for it.

use crate::message::Firmware;
use slip_msg::message;

message! {
    /// SETUP (A7), daemon to client.
    #[derive(Eq)]
    Setup<'a> {
        0 settings: u32, "+1 for every reload", "Settings put in force since the daemon's start.";
        4 firmware: Firmware, "zeros where no gripper was seen yet", "Of the gripper.";
        8 in_force: [u8; 32], "SHA-256", "Of the file of the model in force.";
        40 configured: [u8; 32], "SHA-256", "Of the file of the model that the configuration names.";
        72 text: &'a [u8], "bytes of text m, then UTF-8", "Name of the model that the configuration names.";
    }
}

impl<'a> Setup<'a> {
    /// The text up to the first byte that is not UTF-8.
    #[must_use]
    pub fn configured_name(&self) -> &'a str {
        super::readable(self.text)
    }
}

message! {
    /// LOAD (AB), client to daemon: a piece of a model file. With the last one the model is put in force.
    #[derive(Eq)]
    Load<'a> {
        0 sha256: [u8; 32], "SHA-256", "Of the whole file.";
        32 size: u32, "bytes; 0 = the model of the configuration", "Of the whole file.", in ..=Load::MOST;
        36 offset: u32, "bytes", "Where this piece begins; 0 begins a file.";
        40 bytes: &'a [u8], "bytes n, then as many", "The piece.";
    }
}

impl Load<'_> {
    /// The longest file (bytes).
    pub const MOST: u32 = 1 << 20;
    /// The longest piece (bytes).
    pub const PIECE: usize = 255;
}
