//! Lives that chance hardly finds.

use crate::player::Player;
use crate::python::{answers, interpreter};
use crate::targets::directed::{judge, lives};
use grip_link::message::Reaction;

#[test]
fn the_python_device_does_what_is_wanted() {
    let Some(python) = interpreter() else { return };
    for life in lives() {
        judge(&life, &Player::new(Reaction::Hold).play(&life.script));
        judge(&life, &answers(python, "directed", "device", &life.script));
    }
}
