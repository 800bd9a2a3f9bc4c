//! Lives that chance hardly finds.

use crate::python::{answers, interpreter};
use crate::targets::directed::{judge, lives};
use crate::targets::player::Player;

#[test]
fn the_python_device_does_what_is_wanted() {
    let Some(python) = interpreter() else { return };
    for life in lives() {
        judge(&life, &Player::default().play(&life.script));
        judge(&life, &answers(python, "directed", "device", &life.script));
    }
}
