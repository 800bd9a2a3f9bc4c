//! `gripctl sim`: a gripper on a pseudo-terminal. That a host grips with it, the story of the clients shows (`tests/client.rs`).

#[test]
fn the_time_it_lives_can_be_limited() {
    let folder = tempfile::tempdir().unwrap();
    let args = "sim --scene light_rough --pty p --duration 0.2 --seed 3";
    let ran = crate::run::gripctl(&folder, args).done();
    for words in ["light_rough", "gripd --port p", "force 0.00 N"] {
        assert!(ran.err.contains(words), "no {words:?} in {ran:?}");
    }
    assert!(folder.path().join("p").symlink_metadata().is_err(), "the link is gone");
}
