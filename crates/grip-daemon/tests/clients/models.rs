//! Who may bring a model, and what becomes of its pieces.

use crate::rig::{Rig, Viewer, tcp, wanted};
use grip_daemon::clients::{Brought, ClientsConfig, Loading, Setup};
use grip_link::message::NackReason;
use grip_link::message::daemon::{Estimates, Load, Topics, Unsure};
use slip_core::units::Micros;

const FILE: [u8; 600] = [b'x'; 600];
const SHA256: [u8; 32] = [7; 32];

fn pieces(viewer: &mut Viewer, file: &[u8], from: usize) {
    for (at, bytes) in file.chunks(Load::PIECE).enumerate().skip(from) {
        let offset = u32::try_from(at * Load::PIECE).unwrap();
        let size = u32::try_from(file.len()).unwrap();
        viewer.client.load(&Load { sha256: SHA256, size, offset, bytes }).unwrap();
    }
}

fn back(viewer: &mut Viewer) {
    viewer.client.load(&Load { sha256: [0; 32], size: 0, offset: 0, bytes: &[] }).unwrap();
}

fn reasons(viewer: &Viewer) -> Vec<&str> {
    viewer.seen.nacks.iter().map(|(_, why)| why.as_str()).collect()
}

#[test]
fn no_model_is_taken_unless_it_is_allowed_but_the_way_back_is_open() {
    let mut rig = Rig::new(tcp());
    let mut viewer = rig.viewer(1, wanted(Topics::default(), 0));
    pieces(&mut viewer, &FILE, 0);
    rig.until(&mut viewer, |seen| seen.nacks.len() == 3);
    assert_eq!(reasons(&viewer), ["Forbidden"; 3]);
    assert!(rig.clients.next_load().is_none());
    back(&mut viewer);
    let load = loop {
        rig.turn();
        if let Some(load) = rig.clients.next_load() {
            break load;
        }
    };
    assert_eq!(load.model, None);
    rig.clients.loaded(&load, Ok(false));
    rig.until(&mut viewer, |seen| seen.acks.len() == 1);
}

#[test]
fn a_whole_model_is_answered_when_it_is_in_force() {
    let mut rig = Rig::new(ClientsConfig { allow_models: true, ..tcp() });
    let mut viewer = rig.viewer(1, wanted(Topics::NEWS, 0));
    pieces(&mut viewer, &FILE, 1);
    rig.until(&mut viewer, |seen| seen.nacks.len() == 2);
    assert_eq!(reasons(&viewer), ["Malformed"; 2], "it has no beginning");
    pieces(&mut viewer, &FILE, 0);
    rig.until(&mut viewer, |seen| seen.acks.len() == 2);
    // Another one comes before the first was fetched.
    back(&mut viewer);
    rig.until(&mut viewer, |seen| seen.nacks.len() == 3);
    assert_eq!(reasons(&viewer)[2], "Busy");
    let load = rig.clients.next_load().unwrap();
    assert_eq!(load.model, Some(Brought { sha256: SHA256, bytes: FILE.to_vec() }));
    let name = "default".to_owned();
    rig.clients.set_setup(Setup { settings: 0, in_force: SHA256, configured: [1; 32], name });
    rig.clients.loaded(&load, Err(NackReason::WrongState));
    rig.until(&mut viewer, |seen| seen.nacks.len() == 4 && seen.setups == [SHA256]);
    assert_eq!(reasons(&viewer)[3], "WrongState");
}

#[test]
fn a_model_goes_with_the_client_that_brought_it() {
    let mut rig = Rig::new(ClientsConfig { allow_models: true, ..tcp() });
    let mut viewer = rig.viewer(1, wanted(Topics::default(), 0));
    pieces(&mut viewer, &FILE, 0);
    let next = |rig: &mut Rig| {
        (0..1000).find_map(|_| {
            rig.turn();
            rig.clients.next_load()
        })
    };
    let load = next(&mut rig).unwrap();
    assert!(load.model.is_some());
    rig.clients.loaded(&load, Ok(true));
    assert!(next(&mut rig).is_none(), "it is here");
    drop(viewer);
    let back = next(&mut rig).unwrap();
    assert_eq!(back.model, None);
    rig.clients.loaded(&back, Err(NackReason::WrongState));
    let again = next(&mut rig).unwrap();
    rig.clients.loaded(&again, Err(NackReason::Malformed));
    assert!(next(&mut rig).is_none(), "what fails is not tried for ever");
}

fn shadow(viewer: &mut Viewer, file: &[u8]) {
    let size = u32::try_from(file.len()).unwrap();
    for (at, bytes) in file.chunks(Load::PIECE).enumerate() {
        let offset = u32::try_from(at * Load::PIECE).unwrap();
        viewer.client.shadow(&Load { sha256: SHA256, size, offset, bytes }).unwrap();
    }
    if file.is_empty() {
        viewer.client.shadow(&Load { sha256: [0; 32], size, offset: 0, bytes: &[] }).unwrap();
    }
}

fn next(rig: &mut Rig) -> Option<Loading> {
    (0..1000).find_map(|_| {
        rig.turn();
        rig.clients.next_load()
    })
}

#[test]
fn a_shadow_is_taken_as_a_model_is_and_is_that_of_one_client() {
    let mut rig = Rig::new(tcp());
    let mut viewer = rig.viewer(1, wanted(Topics::default(), 0));
    shadow(&mut viewer, &FILE);
    rig.until(&mut viewer, |seen| seen.nacks.len() == 3);
    assert_eq!(reasons(&viewer), ["Forbidden"; 3]);

    let mut rig = Rig::new(ClientsConfig { allow_models: true, ..tcp() });
    let mut first = rig.viewer(1, wanted(Topics::default(), 0));
    let mut second = rig.viewer(2, wanted(Topics::default(), 0));
    shadow(&mut first, &FILE);
    let load = next(&mut rig).unwrap();
    assert!(load.is_shadow() && load.model.is_some());
    rig.clients.loaded(&load, Ok(true));
    rig.until(&mut first, |seen| seen.acks.len() == 3);
    // A model in force goes its own way.
    pieces(&mut second, &FILE, 0);
    let load = next(&mut rig).unwrap();
    assert!(!load.is_shadow());
    rig.clients.loaded(&load, Ok(true));
    shadow(&mut second, &FILE);
    rig.until(&mut second, |seen| seen.nacks.len() == 1);
    assert_eq!(reasons(&second), ["Busy"]);
    shadow(&mut second, &[]);
    rig.until(&mut second, |seen| seen.acks.len() == 3 + 2 + 1);
    assert!(rig.clients.next_load().is_none(), "the shadow is not its own");
    drop(first);
    let end = next(&mut rig).unwrap();
    assert!(end.is_shadow() && end.model.is_none());
    rig.clients.loaded(&end, Ok(false));
    shadow(&mut second, &FILE);
    let load = next(&mut rig).unwrap();
    assert!(load.is_shadow() && load.model.is_some());
}

#[test]
fn both_estimates_go_to_those_who_asked_for_them() {
    let mut rig = Rig::new(tcp());
    let mut asked = rig.viewer(1, wanted(Topics::ESTIMATES, 0));
    let older = Topics(Topics::ALL.0 & !Topics::ESTIMATES.0);
    let mut other = rig.viewer(2, wanted(older, 0));
    let made = Estimates {
        slip: 0,
        t: Micros(5),
        host: Micros(0),
        slipped_n: Some(2.0),
        in_force_n: Some(4.0),
        shadow_n: None,
        unsure: Unsure::IN_FORCE,
    };
    rig.clients.estimates(77, &made);
    rig.updates();
    rig.until(&mut asked, |seen| !seen.estimates.is_empty());
    assert_eq!(asked.seen.estimates, [Estimates { host: Micros(77), ..made }]);
    rig.until(&mut other, |seen| seen.grippers > 0);
    assert_eq!(other.seen.estimates, []);
}
