//! SETUP, LOAD, SHADOW and ESTIMATES: which model the daemon works with, another one for it, and one beside it.

use crate::message::{Firmware, bits::bits};
use slip_msg::{message, units::Micros};

message! {
    /// SETUP (A7), daemon to client.
    #[derive(Eq)]
    Setup<'a> {
        0 settings: u32, "+1 for every reload since the daemon's start", "Settings put in force since the daemon's start.";
        4 firmware: Firmware, "firmware version of the gripper; zeros where none was seen yet", "Of the gripper.";
        8 in_force: [u8; 32], "SHA-256 of the file of the model in force", "Of the file of the model in force.";
        40 configured: [u8; 32], "SHA-256 of the file of the model that the configuration names", "Of the file of the model that the configuration names.";
        72 text: &'a [u8], "name of the model that the configuration names, UTF-8", "Name of the model that the configuration names.";
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
    /// LOAD (AB), client to daemon: a piece of a model file. With the last one the model is put in force. SHADOW (AD) has the same payload: with
    /// the last piece the model estimates beside the one in force, and moves nothing.
    #[derive(Eq)]
    Load<'a> {
        0 sha256: [u8; 32], "SHA-256 of the whole file", "Of the whole file.";
        32 size: u32, "bytes of the whole file, 0..1048576; more is malformed; 0 = the model of the configuration, of SHADOW no shadow any more", "Of the whole file.", in ..=Load::MOST;
        36 offset: u32, "bytes before this piece", "Where this piece begins; 0 begins a file.";
        40 bytes: &'a [u8], "the piece", "The piece.";
    }
}

impl Load<'_> {
    /// The longest file (bytes).
    pub const MOST: u32 = 1 << 20;
    /// The longest piece (bytes).
    pub const PIECE: usize = 255;
}

bits! {
    /// Which of two estimates may not move the fingers, as bits: made outside the range of the model, or too unsure.
    Unsure(u16) {
        0 IN_FORCE "that of the model in force.",
        1 SHADOW "that of the shadow model.",
    }
}

message! {
    /// ESTIMATES (AE), daemon to client: what the model in force and the shadow model made of a slip that has ended.
    Estimates {
        0 slip: u32, "`number` of the SLIP with its end", "Number of the SLIP with its end.";
        4 t as "device_us": Micros, "us, device time of the end", "Device time of the end.";
        12 host as "host_us": Micros, "us since the daemon's start", "Host time since the daemon's start.";
        20 slipped_n as "slipped": Option<f32>, "N, mean normal force of one finger over the stretch that both were asked about", "Mean normal force of one finger over the stretch that both were asked about.";
        24 in_force_n as "in_force": Option<f32>, "N, by the model in force", "Adequate force by the model in force.";
        28 shadow_n as "shadow": Option<f32>, "N, by the shadow model", "Adequate force by the shadow model.";
        32 unsure: Unsure, "unsure estimates", "Which of the two may not move the fingers.", reserved 2;
    }
}
