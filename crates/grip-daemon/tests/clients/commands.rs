//! Who may command what.

use crate::rig::{PATIENCE, Rig, tcp, wanted};
use core::time::Duration;
use grip_daemon::clients::{Clients, ClientsConfig, ListenError};
use grip_daemon::{Item, LinkNote};
use grip_link::message::daemon::{Command, LinkState, Operation, ToClient, Topics};
use grip_link::message::{
    DeviceState, Event, EventKind, FaultCode, ForceClamp, Status, StatusFlags,
};
use slip_core::ClientCommand;

const EVERY: [Operation; 6] = [
    Operation::AtLeast,
    Operation::Release,
    Operation::Grasp,
    Operation::Stop,
    Operation::ClearFault,
    Operation::Expect,
];

fn drain(rig: &mut Rig) -> Vec<ClientCommand> {
    core::iter::from_fn(|| rig.clients.next_command()).collect()
}

/// Commands are allowed, and samples of the gripper come.
fn streaming() -> Rig {
    let mut rig = Rig::new(ClientsConfig { allow_commands: true, ..tcp() });
    rig.link(&LinkNote::State(LinkState::Stream));
    rig
}

/// Fingers would move when the gripper has power again, or the fault is cleared: long after whoever ordered it has gone.
#[test]
fn fingers_that_cannot_move_now_are_not_ordered_to_move_later() {
    let latched = Status {
        last_cmd_id: 1,
        state: DeviceState::Fault,
        clamp: ForceClamp(0),
        fault: FaultCode(0x0201),
        applied_mn: 0,
        target_mn: 0,
        age_us: 5,
        flags: StatusFlags(0),
        rejected: 0,
    };
    let notes = [
        (LinkNote::PortLost, "WrongState"),
        (LinkNote::State(LinkState::Hello), "WrongState"),
        (LinkNote::Status(latched), "Latched"),
    ];
    for (note, reason) in notes {
        let mut rig = streaming();
        let mut viewer = rig.viewer(1, wanted(Topics::default(), 0));
        rig.link(&note);
        let release = Command { token: viewer.seen.token, ..Command::new(Operation::Release) };
        for command in [release, Command::new(Operation::Grasp), Command::new(Operation::Stop)] {
            viewer.client.command(&command).unwrap();
        }
        rig.until(&mut viewer, |seen| seen.nacks.len() == 2 && seen.acks.len() == 1);
        assert!(viewer.seen.nacks.iter().all(|(_, why)| why == reason), "{:?}", viewer.seen.nacks);
        assert_eq!(drain(&mut rig), [ClientCommand::Stop]);
    }
}

#[test]
fn nothing_is_commanded_unless_it_is_allowed() {
    let mut rig = Rig::new(tcp());
    let mut viewer = rig.viewer(1, wanted(Topics::default(), 0));
    assert_eq!(viewer.seen.token, 0);
    for operation in EVERY {
        viewer.client.command(&Command::new(operation)).unwrap();
    }
    rig.until(&mut viewer, |seen| seen.nacks.len() == EVERY.len());
    assert!(viewer.seen.nacks.iter().all(|(_, reason)| reason == "Forbidden"));
    assert_eq!((drain(&mut rig), viewer.seen.acks.len()), (vec![], 0));
}

#[test]
fn what_is_allowed_reaches_the_hot_thread_in_order() {
    let mut rig = streaming();
    let mut viewer = rig.viewer(1, wanted(Topics::default(), 0));
    let token = viewer.seen.token;
    assert_ne!(token, 0);
    let force = Command { force_mn: 4_250, ..Command::new(Operation::AtLeast) };
    let expect = Command { force_mn: 9_500, ..Command::new(Operation::Expect) };
    let clear = Command { fault: FaultCode(0x0201), ..Command::new(Operation::ClearFault) };
    let release = Command { token, ..Command::new(Operation::Release) };
    let grasp = Command::new(Operation::Grasp);
    for command in [force, release, grasp, Command::new(Operation::Stop), clear, expect] {
        viewer.client.command(&command).unwrap();
    }
    rig.until(&mut viewer, |seen| seen.acks.len() == 6);
    let wanted = [
        ClientCommand::AtLeast(4.25),
        ClientCommand::Release,
        ClientCommand::Grasp,
        ClientCommand::Stop,
        ClientCommand::ClearFault(FaultCode(0x0201)),
        ClientCommand::Expect(9.5),
    ];
    assert_eq!(drain(&mut rig), wanted);
}

#[test]
fn a_release_without_the_token_and_a_negative_force_are_refused() {
    let mut rig = streaming();
    let mut viewer = rig.viewer(1, wanted(Topics::default(), 0));
    viewer.client.command(&Command::new(Operation::Release)).unwrap();
    let negative = Command { force_mn: -1, ..Command::new(Operation::AtLeast) };
    viewer.client.command(&negative).unwrap();
    rig.until(&mut viewer, |seen| seen.nacks.len() == 2);
    let reasons: Vec<&str> = viewer.seen.nacks.iter().map(|(_, why)| why.as_str()).collect();
    assert_eq!((reasons, drain(&mut rig)), (vec!["Token", "Malformed"], vec![]));
}

/// One that floods fills its own places and its own second, and STOP needs neither.
#[test]
fn a_stop_is_taken_whatever_a_flood_has_filled() {
    let mut rig = streaming();
    let mut flood = rig.viewer(1, wanted(Topics::default(), 0));
    let mut victim = rig.viewer(2, wanted(Topics::default(), 0));
    for _ in 0..230 {
        flood.client.command(&Command::new(Operation::Expect)).unwrap();
    }
    rig.until(&mut flood, |seen| seen.acks.len() + seen.nacks.len() == 230);
    assert_eq!(flood.seen.acks.len(), 16);
    for operation in [Operation::Stop, Operation::Stop, Operation::Expect] {
        victim.client.command(&Command::new(operation)).unwrap();
    }
    rig.until(&mut victim, |seen| seen.acks.len() + seen.nacks.len() == 3);
    flood.client.command(&Command::new(Operation::Stop)).unwrap();
    rig.until(&mut flood, |seen| seen.acks.len() == 17);
    assert_eq!(victim.seen.nacks, vec![]);
    let last = [ClientCommand::Stop, ClientCommand::Expect(0.0), ClientCommand::Stop];
    assert_eq!(drain(&mut rig).get(16..), Some(&last[..]));
}

#[test]
fn a_name_is_fetched_once_answered_and_told_to_whoever_asks() {
    let mut rig = Rig::new(ClientsConfig { allow_commands: true, ..tcp() });
    let mut viewer = rig.viewer(1, wanted(Topics::NEWS, 0));
    viewer.client.object("bottle").unwrap();
    let naming = (0..PATIENCE).find_map(|_| {
        rig.turn();
        rig.clients.next_name()
    });
    let naming = naming.unwrap();
    assert_eq!((naming.name.as_str(), rig.clients.next_name().is_none()), ("bottle", true));
    rig.clients.named(&naming, Ok(()));
    rig.clients.object(5, "bottle: known", 3);
    rig.until(&mut viewer, |seen| seen.acks.len() == 1 && seen.texts.len() == 1);
    let mut late = rig.viewer(2, wanted(Topics::default(), 0));
    late.client.query().unwrap();
    rig.until(&mut late, |seen| seen.acks.len() == 1);
    assert_eq!(
        (viewer.seen.texts, late.seen.texts),
        (vec!["bottle: known".to_owned()], vec!["bottle: known".to_owned()])
    );
}

#[test]
fn names_are_refused_where_nothing_is_commanded_and_where_one_waits() {
    for (allow_commands, reasons) in [(false, ["Forbidden"; 2].as_slice()), (true, &["Busy"])] {
        let mut rig = Rig::new(ClientsConfig { allow_commands, ..tcp() });
        let mut viewer = rig.viewer(1, wanted(Topics::NEWS, 0));
        viewer.client.object("bottle").unwrap();
        viewer.client.object("cup").unwrap();
        rig.until(&mut viewer, |seen| seen.nacks.len() == reasons.len());
        let seen: Vec<&str> = viewer.seen.nacks.iter().map(|(_, why)| why.as_str()).collect();
        assert_eq!((seen, rig.clients.next_name().is_some()), (reasons.to_vec(), allow_commands));
    }
}

#[test]
fn commands_that_nobody_fetches_are_refused_when_too_many_wait() {
    let mut rig = streaming();
    let mut viewer = rig.viewer(1, wanted(Topics::default(), 0));
    for _ in 0..100 {
        viewer.client.command(&Command::new(Operation::Grasp)).unwrap();
    }
    rig.until(&mut viewer, |seen| seen.nacks.len() + seen.acks.len() == 100);
    assert!(viewer.seen.nacks.iter().all(|(_, reason)| reason == "Busy"));
    assert_eq!((viewer.seen.acks.len(), drain(&mut rig).len()), (16, 16));
}

#[test]
fn a_flood_is_refused_but_the_newest_least_force_is_carried_out() {
    let mut rig = streaming();
    let mut viewer = rig.viewer(1, wanted(Topics::default(), 0));
    let mut came = Vec::new();
    for n in 1..=200 {
        let least = Command { force_mn: 10 * n, ..Command::new(Operation::AtLeast) };
        viewer.client.command(&least).unwrap();
        viewer.client.command(&Command::new(Operation::Grasp)).unwrap();
        let answers = usize::try_from(2 * n).unwrap();
        rig.until(&mut viewer, |seen| seen.acks.len() + seen.nacks.len() == answers);
        came.append(&mut drain(&mut rig));
    }
    for _ in 0..11 {
        rig.turn();
    }
    came.append(&mut drain(&mut rig));
    assert_eq!((viewer.seen.acks.len(), viewer.seen.nacks.len()), (300, 100));
    assert!(viewer.seen.nacks.iter().all(|(_, reason)| reason == "Busy"));
    let least = |command: &&ClientCommand| matches!(command, ClientCommand::AtLeast(_));
    assert!(came.iter().filter(least).count() < 100, "{came:?}");
    assert_eq!(came.iter().rfind(least), Some(&ClientCommand::AtLeast(2.0)));
    rig.now_us += 1_000_000;
    viewer.client.command(&Command::new(Operation::Stop)).unwrap();
    rig.until(&mut viewer, |seen| seen.acks.len() == 301);
}

/// A program that crashes lets nothing fall, and none takes back what another one has asked for.
#[test]
fn a_least_force_stays_its_clients_own() {
    let mut rig = streaming();
    let least = |force_mn| Command { force_mn, ..Command::new(Operation::AtLeast) };
    let mut first = rig.viewer(1, wanted(Topics::default(), 0));
    let mut second = rig.viewer(2, wanted(Topics::default(), 0));
    first.client.command(&least(20_000)).unwrap();
    rig.until(&mut first, |seen| seen.acks.len() == 1);
    rig.now_us += 10_000;
    second.client.command(&least(0)).unwrap();
    rig.until(&mut second, |seen| seen.acks.len() == 1);
    assert_eq!(drain(&mut rig), [ClientCommand::AtLeast(20.0), ClientCommand::AtLeast(20.0)]);
    drop(first);
    while rig.clients.count() > 1 {
        rig.turn();
    }
    for _ in 0..100 {
        rig.turn();
    }
    assert_eq!(drain(&mut rig), [], "nothing falls");
    second.client.command(&least(0)).unwrap();
    rig.until(&mut second, |seen| seen.acks.len() == 2);
    assert_eq!(drain(&mut rig), [ClientCommand::AtLeast(0.0)]);
}

#[test]
fn other_computers_are_kept_out_unless_it_is_stated() {
    let open = ClientsConfig { listen: "tcp:0.0.0.0:0".parse().unwrap(), ..tcp() };
    let refused = Clients::listen(open.clone(), crate::rig::about()).unwrap_err();
    assert!(matches!(refused, ListenError::Remote { .. }), "{refused}");
    let allowed = ClientsConfig { allow_remote: true, ..open };
    let clients = Clients::listen(allowed, crate::rig::about()).unwrap();
    assert!(clients.warning().is_some_and(|text| text.contains("encrypted")));
    assert_eq!(Rig::new(tcp()).clients.warning(), None);
}

/// While a fault is latched the gripper rejects every command, a thousand times a second.
#[test]
fn rejected_commands_are_updates_once() {
    let mut rig = Rig::new(tcp());
    let mut viewer = rig.viewer(1, wanted(Topics::NEWS, 0));
    let event = |kind| Event {
        tick: 0,
        kind,
        before: DeviceState::Estop,
        after: DeviceState::Estop,
        fault: FaultCode::ESTOP,
        dropped: 0,
        value: 0,
    };
    let rejected = [EventKind::CommandRejected; 50];
    for kind in rejected.into_iter().chain([EventKind::FaultCleared]) {
        let note = LinkNote::Device(event(kind));
        rig.clients.take(&Item::Link { host_us: rig.now_us, note: &note });
    }
    let mut reported = Vec::new();
    for _ in 0..PATIENCE {
        rig.turn();
        let mut on = |message: &ToClient<'_>| {
            if let ToClient::Notice(notice) = message {
                reported.push(notice.as_str().to_owned());
            }
        };
        viewer.client.wait(Duration::from_millis(1), &mut on).unwrap();
        if reported.last().is_some_and(|text| text.contains("free of fault 0001")) {
            break;
        }
    }
    assert_eq!(reported.len(), 2, "{reported:?}");
}
