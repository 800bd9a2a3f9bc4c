//! SETUP, LOAD, SHADOW and ESTIMATES: which model the daemon works with, another one for it, and one beside it.

use crate::message::{Firmware, bits::bits};
use slip_msg::{message, units::Micros};

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
    /// LOAD (AB), client to daemon: a piece of a model file. With the last one the model is put in force. SHADOW (AD) has the same payload: with
    /// the last piece the model estimates beside the one in force, and moves nothing.
    #[derive(Eq)]
    Load<'a> {
        0 sha256: [u8; 32], "SHA-256", "Of the whole file.";
        32 size: u32, "bytes; 0 = the model of the configuration, or no shadow", "Of the whole file.", in ..=Load::MOST;
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
        0 slip: u32, "1..", "Number of the SLIP with its end.";
        4 t: Micros, "us", "Device time of the end.";
        12 host: Micros, "us", "Host time since the daemon's start.";
        20 slipped_n: Option<f32>, "N", "Mean normal force of one finger over the stretch that both were asked about.";
        24 in_force_n: Option<f32>, "N", "Adequate force by the model in force.";
        28 shadow_n: Option<f32>, "N", "Adequate force by the shadow model.";
        32 unsure: Unsure, "", "Which of the two may not move the fingers.", reserved 2;
    }
}
