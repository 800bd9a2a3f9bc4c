//! Lives that chance hardly finds, and what the C side refuses to start with.

use crate::peer::{assert_same, run};
use crate::targets::directed::{judge, lives};
use crate::targets::player::Player;

#[test]
fn both_do_what_is_wanted() {
    for life in lives() {
        let rust = Player::default().play(&life.script);
        let c = run("device", &(life.script.join("\n") + "\n"));
        judge(&life, &rust);
        assert_same(life.name, &rust, &c);
    }
}

#[test]
fn gl_init_refuses_what_cannot_be() {
    let said = run("init", "");
    assert!(said.len() >= 25, "{said:#?}");
    for reason in ["ok", "tick rate", "limits", "no stylus", "row"] {
        assert!(said.iter().any(|line| line.ends_with(&format!(": {reason}"))), "no {reason}");
    }
}
