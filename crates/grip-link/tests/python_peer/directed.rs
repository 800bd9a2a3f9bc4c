//! Lives that chance hardly finds.

use crate::python::answers;
use crate::targets::directed::{judge, lives};
use crate::targets::player::Player;

#[test]
#[ignore = "needs Python 3.9 (CONTRIBUTING.md)"]
fn the_python_device_does_what_is_wanted() {
    for life in lives() {
        judge(&life, &Player::default().play(&life.script));
        judge(&life, &answers("directed", "device", &life.script));
    }
}
