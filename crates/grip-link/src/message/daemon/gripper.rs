//! GRIPPER: which gripper the daemon holds.

use super::LinkState;
use crate::message::Unit;
use slip_msg::message;

message! {
    /// GRIPPER (A4), daemon to client.
    Gripper {
        0 uid: [u8; 16], "as in IDENT; zeros where no gripper was seen yet", "Identity.";
        16 boot_id: u32, "as in IDENT", "Number of its starts.";
        20 rate_hz: u32, "Hz, in force; 0 = none yet", "Sample rate in force.";
        24 force_max_n as "force_max": Option<f32>, "N, largest force of the controller", "Largest force of the controller.";
        28 link: LinkState, "link state", "State of the link.";
        29 taxels: u8, "of its array", "Taxels of its array.";
        30 stylus: Unit, "unit: 1 metres; 0 a vibration in a unit of its own, or not known", "Unit of the stylus.", reserved 1;
    }
}

impl Gripper {
    /// None was seen yet.
    pub const NONE: Self = Self {
        uid: [0; 16],
        boot_id: 0,
        rate_hz: 0,
        force_max_n: None,
        link: LinkState::Closed,
        taxels: 0,
        stylus: Unit::None,
    };
}
