//! A gripper as a node of ROS 2 beside a real router in this process: found by its tokens, received under the names that subscribers of rmw_zenoh ask
//! for, gone when it goes.
use super::rig::{self, at, endpoint, notice, patient, router};
use core::time::Duration;
use grip_fleet::{
    EventId, Member,
    net::{RosAnnounced, RosTimes, Session},
    ros::{Attachment, Gid},
    wire,
};
use grip_link::message::Kind;
use std::collections::{BTreeMap, BTreeSet};
use zenoh::{Wait as _, handlers::FifoChannelHandler, pubsub::Subscriber, sample::Sample};

/// More than any answer takes on a busy computer.
const PATIENCE: Duration = Duration::from_secs(30);
const LOOK: Duration = Duration::from_millis(300);
const TIMES: RosTimes =
    RosTimes { start_ns: 1_763_766_000_000_000_000, now_ns: 1_763_766_009_000_000_000 };
const PLACE: &str = "hall_2/gripper_07070707070707070707070707070707";
const JOINTS: &str = "joint_states/sensor_msgs::msg::dds_::JointState_/RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e";

/// A STATE of zeros: idle, no force.
fn state() -> Vec<u8> {
    wire(Kind::STATE, |_| 60)
}

fn slip(number: u8) -> Vec<u8> {
    wire(Kind::SLIP, |out| {
        out[0] = number;
        72
    })
}

/// A router, a gripper's session and that of a ROS computer.
fn network() -> [Session; 3] {
    let endpoint = endpoint();
    let router = router(&endpoint);
    [router, at(&endpoint).open().unwrap(), at(&endpoint).open().unwrap()]
}

/// Of a site whose name ROS cannot write.
fn member() -> Member {
    Member { site: "hall-2".parse().unwrap(), ..rig::member(7) }
}

type Received = Subscriber<FifoChannelHandler<Sample>>;

fn subscribe(session: &Session, key: &str) -> Received {
    session.declare_subscriber(key.to_owned()).wait().unwrap()
}

/// The tokens of a domain, as a ROS computer asks for them when it starts.
fn tokens(session: &Session, domain: u16) -> BTreeSet<String> {
    let all = format!("@ros2_lv/{domain}/**");
    let replies = session.liveliness().get(all).timeout(PATIENCE).wait().unwrap();
    replies.iter().map(|reply| reply.result().unwrap().key_expr().to_string()).collect()
}

/// Waits until as many tokens are there: declarations need their time.
fn tokens_of(session: &Session, domain: u16, count: usize) -> BTreeSet<String> {
    for _ in 0..300 {
        let tokens = tokens(session, domain);
        if tokens.len() == count {
            return tokens;
        }
        // Nothing is published in these names: only time passes.
        let silence = subscribe(session, &format!("{domain}/silence"));
        assert!(silence.recv_timeout(LOOK / 3).unwrap().is_none());
    }
    panic!("{:?}", tokens(session, domain))
}

/// Publishes until a subscriber gets the last one: a subscription needs its time, and a busy network may drop a publication.
fn next(node: &mut RosAnnounced, received: &Received, wire: &[u8], published: &mut i64) -> Sample {
    for _ in 0..100 {
        node.publish(EventId { run: 1, seq: 1 }, wire, TIMES);
        *published += 1;
        while let Some(sample) = received.recv_timeout(LOOK).unwrap() {
            if attachment(&sample).0 == *published {
                return sample;
            }
        }
    }
    panic!("nothing is heard")
}

fn attachment(sample: &Sample) -> (i64, i64, Vec<u8>) {
    let bytes = sample.attachment().unwrap().to_bytes();
    assert_eq!((bytes.len(), bytes[16]), (Attachment::SIZE, 16));
    let number = |at: usize| i64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
    (number(0), number(8), bytes[17..].to_vec())
}

#[test]
fn a_node_and_its_publishers_are_found_and_gone_with_it() {
    let [_router, gripper, ros] = network();
    let node = RosAnnounced::new(&gripper, &member(), 42).unwrap();
    assert_eq!(node.name(), format!("/{PLACE}/gripd"));
    let found = tokens_of(&ros, 42, 4);
    let begin = format!("@ros2_lv/42/{}/0", gripper.zid());
    let place = format!("%/%{}", PLACE.replace('/', "%"));
    assert!(found.contains(&format!("{begin}/0/NN/{place}/gripd")), "{found:?}");
    let publisher =
        format!("{begin}/1/MP/{place}/gripd/%{}%{JOINTS}/::,10:,:,:,,", PLACE.replace('/', "%"));
    assert!(found.contains(&publisher), "{publisher} {found:?}");
    // Another domain does not see it.
    assert!(tokens(&ros, 4).is_empty());
    drop(node);
    tokens_of(&ros, 42, 0);
}

#[test]
fn a_node_is_found_again_when_the_router_has_started_again() {
    let (folder, endpoint) = (tempfile::tempdir().unwrap(), endpoint());
    let network = patient(folder.path(), &endpoint);
    let first = router(&endpoint);
    let gripper = network.open().unwrap();
    let mut node = RosAnnounced::new(&gripper, &member(), 0).unwrap();
    let before = tokens_of(&network.open().unwrap(), 0, 4);
    first.close().wait().unwrap();
    let _router = router(&endpoint);
    let ros = network.open().unwrap();
    assert_eq!(tokens_of(&ros, 0, 4), before);
    let received = subscribe(&ros, &format!("0/{PLACE}/{JOINTS}"));
    next(&mut node, &received, &state(), &mut 0);
}

#[test]
fn a_subscriber_receives_joints_under_the_name_it_asks_for_numbered_and_signed() {
    let [_router, gripper, ros] = network();
    let mut node = RosAnnounced::new(&gripper, &member(), 0).unwrap();
    let received = subscribe(&ros, &format!("0/{PLACE}/{JOINTS}"));
    let elsewhere = subscribe(&ros, &format!("1/{PLACE}/{JOINTS}"));
    let mut published = 0;
    let sample = next(&mut node, &received, &state(), &mut published);
    let payload = sample.payload().to_bytes();
    assert_eq!(payload[..4], [0, 1, 0, 0]);
    assert_eq!(payload[4..8], 1_763_766_000_u32.to_le_bytes());
    let (_, time, gid) = attachment(&sample);
    assert_eq!(time, 1_763_766_009_000_000_000);
    let token = tokens_of(&ros, 0, 4).into_iter().find(|token| token.contains("JointState"));
    assert_eq!(gid, Gid::of(&token.unwrap()).0);
    next(&mut node, &received, &state(), &mut published);
    assert!(elsewhere.try_recv().unwrap().is_none());
    assert_eq!(node.refused(), 0);
}

/// What comes until nothing comes any more: the last number of each topic.
fn numbers(received: &Received) -> BTreeMap<String, i64> {
    let mut numbers = BTreeMap::new();
    while let Some(sample) = received.recv_timeout(LOOK).unwrap() {
        let topic = sample.key_expr().as_str().split('/').nth(3).unwrap().to_owned();
        numbers.insert(topic, attachment(&sample).0);
    }
    numbers
}

#[test]
fn each_topic_is_counted_by_itself_and_other_updates_do_not_travel() {
    let [_router, gripper, ros] = network();
    let mut node = RosAnnounced::new(&gripper, &member(), 0).unwrap();
    let all = subscribe(&ros, &format!("0/{PLACE}/**"));
    let notice = notice("open");
    let mut received = BTreeMap::new();
    for round in 1..=100 {
        for wire in [&state(), &notice, &slip(7), &notice, &slip(8)] {
            node.publish(EventId::default(), wire, TIMES);
        }
        received = numbers(&all);
        let published = [("joint_states", round), ("slip", 2 * round), ("state", round)];
        if received == published.map(|(topic, number)| (topic.to_owned(), number)).into() {
            return;
        }
    }
    panic!("{received:?}");
}
