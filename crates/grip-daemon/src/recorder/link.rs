//! Kind and JSON of a Link message, from updates of the link.

use crate::LinkNote;
use grip_session::{config::Uid, session::explain};
use serde_json::{Value, json};

/// Kind and details, as in the Link message.
pub(super) fn reported(note: &LinkNote) -> (&'static str, Value) {
    match note {
        LinkNote::State(state) => ("state", json!({ "state": state.name() })),
        LinkNote::Identified { uid, boot_id, firmware, rebooted } => {
            let firmware = firmware.to_string();
            let reported = json!({ "uid": Uid(*uid).to_string(), "boot_id": boot_id, "firmware": firmware, "rebooted": rebooted });
            ("identified", reported)
        }
        LinkNote::OtherGripper { uid } => {
            ("other_gripper", json!({ "uid": Uid(*uid).to_string() }))
        }
        LinkNote::Configured(clamped) => ("configured", json!({ "clamped": clamped.0 })),
        LinkNote::Rebooted => ("rebooted", json!({})),
        LinkNote::Status(status) => (
            "status",
            json!({
                "last_cmd_id": status.last_cmd_id,
                "state": status.state.name(),
                "clamp": status.clamp.0,
                "fault": status.fault.0,
                "applied_mn": status.applied_mn,
                "target_mn": status.target_mn,
                "age_us": status.age_us,
                "flags": status.flags.0,
                "rejected": status.rejected,
            }),
        ),
        LinkNote::Device(event) => (
            "device",
            json!({
                "tick": event.tick,
                "event": event.kind.name(),
                "before": event.before.name(),
                "after": event.after.name(),
                "fault": event.fault.0,
                "dropped": event.dropped,
                "value": event.value,
            }),
        ),
        LinkNote::Refused(nack) => (
            "refused",
            json!({ "request": nack.kind.0, "reason": nack.reason.name(), "seq": nack.seq }),
        ),
        LinkNote::Closed(reason) => {
            ("closed", json!({ "reason": reason.name(), "text": explain(reason) }))
        }
        LinkNote::Late(late_us) => ("late", json!({ "late_us": late_us })),
        LinkNote::Steady => ("steady", json!({})),
        LinkNote::PortOpened => ("port_opened", json!({})),
        LinkNote::PortLost => ("port_lost", json!({})),
    }
}
