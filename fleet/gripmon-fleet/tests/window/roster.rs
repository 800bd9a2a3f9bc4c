//! Messages as they come from the network in, what the table states of them.

use crate::grippers::{health_of, message, of, reported, state};
use grip_fleet::{About, Uid};
use grip_link::message::daemon::{
    GripState, Health, LinkState, Method, Phase, PipelineState, Scene, SensorHealth, SlipReport,
};
use grip_link::message::{FaultCode, Kind};
use grip_scope::feed::SourceStatus;
use gripmon_fleet::grippers::{
    Column, FleetFeed, Member, Received, Roster, Row, Sorting, Summary, Trouble, order,
};

fn member(site: &str, uid: u8) -> Member {
    Member { site: site.parse().unwrap(), uid: Uid([uid; 16]) }
}

/// One that has lost 7 samples.
fn holding() -> PipelineState {
    PipelineState { lost: 7, ..state(4.875) }
}

fn slip(number: u32, phase: Phase) -> Received {
    let slip = SlipReport { number, phase, method: Method::Stylus, ..SlipReport::UNKNOWN };
    message(Kind::SLIP, |out| slip.write(out).unwrap())
}

fn receive(roster: &mut Roster, member: &Member, at_s: f64, what: Received) {
    roster.take(of(member, at_s, what));
}

fn row<'a>(roster: &'a Roster, member: &Member) -> &'a Row {
    roster.rows().iter().find(|row| row.member == *member).unwrap()
}

/// What the table states of a gripper, column by column.
fn states(roster: &Roster, member: &Member) -> Vec<String> {
    let row = row(roster, member);
    Column::ALL.map(|column| column.text(row, roster.now_s())).to_vec()
}

fn uids(roster: &Roster, sorting: Sorting, filter: &str) -> Vec<u8> {
    let order = order(roster, sorting, filter);
    order.into_iter().map(|place| roster.rows()[place].member.uid.0[0]).collect()
}

#[test]
fn a_row_states_what_its_messages_reported() {
    let (mut roster, one) = (Roster::default(), member("hall-2", 0x1a));
    let uid = "1a".repeat(16);
    receive(&mut roster, &one, 1.0, Received::Came);
    let nothing = ["ok", "hall-2", &uid, "here", "-", "-", "-", "-", "-", "-", "-", "-", "0", "-"];
    assert_eq!(states(&roster, &one)[..14], nothing);
    assert_eq!(states(&roster, &one)[14..], ["-"; 4]);
    receive(&mut roster, &one, 1.5, health_of(12, 9));
    receive(&mut roster, &one, 1.6, reported(&holding()));
    let row = states(&roster, &one);
    assert_eq!(row[3..9], ["here", "stream", "holding", "holding", "5.00", "4.88"]);
    assert_eq!(row[9..], ["4.88", "0.250", "12", "0", "9", "good", "-", "-", "-"]);
    let worse = PipelineState {
        scene: Scene::Slipping,
        grip: GripState::Slipping,
        sensors: [
            SensorHealth::Drifting,
            SensorHealth::Frozen,
            SensorHealth::Frozen,
            SensorHealth::Good,
        ],
        statistic: Some(30.0),
        applied_n: None,
        lost: 11,
        ..holding()
    };
    receive(&mut roster, &one, 1.8, reported(&worse));
    let row = states(&roster, &one);
    assert_eq!(row[0], "sensor");
    assert_eq!(row[5..9], ["slipping", "slipping", "5.00", "-"]);
    // Without a measured force the commanded one is drawn; the highest of three minutes stands.
    assert_eq!(row[9..], ["5.00", "30.00", "12", "0", "11", "travel frozen", "-", "-", "-"]);
    let health = Health { link: LinkState::Degraded, ..Health::default() };
    receive(&mut roster, &one, 1.9, message(Kind::HEALTH, |out| health.write(out).unwrap()));
    let row = states(&roster, &one);
    assert_eq!(
        (row[0].as_str(), row[4].as_str(), roster.summary().links),
        ("no link", "degraded", 1)
    );
    let fault = PipelineState { fault: FaultCode(0x12), grip: GripState::Fault, ..holding() };
    receive(&mut roster, &one, 2.0, reported(&fault));
    let row = states(&roster, &one);
    assert_eq!((row[0].as_str(), row[15].as_str()), ("fault", "0012"));
    let model = Some("m".repeat(1000));
    let about = About { firmware: Some("1.2.3".to_owned()), model, ..About::default() };
    receive(&mut roster, &one, 2.1, Received::About(about.clone()));
    assert_eq!(states(&roster, &one)[16..], ["m".repeat(64), "1.2.3".to_owned()]);
    assert_eq!(uids(&roster, Sorting::default(), "1.2.3"), [0x1a]);
    // An answer alone is no gripper that is there.
    receive(&mut roster, &member("hall-2", 2), 2.2, Received::About(about));
    assert_eq!(roster.rows().len(), 1);
}

#[test]
fn slips_count_once_each_and_a_minute_forgets_them() {
    let (mut roster, one) = (Roster::default(), member("a", 1));
    let minute = |roster: &Roster| Column::Minute.text(row(roster, &one), roster.now_s());
    for (at_s, number, phase) in [
        (10.0, 1, Phase::Incipient),
        (10.1, 2, Phase::Gross),
        (10.3, 3, Phase::Ended),
        (30.0, 4, Phase::Gross),
        (30.2, 5, Phase::Ended),
    ] {
        receive(&mut roster, &one, at_s, slip(number, phase));
    }
    assert_eq!(minute(&roster), "2");
    roster.take(FleetFeed::Now(71.0));
    assert_eq!(minute(&roster), "1");
    roster.take(FleetFeed::Now(91.0));
    assert_eq!(minute(&roster), "0");
    // The end of the first one, with others, is missing.
    receive(&mut roster, &one, 92.0, slip(6, Phase::Gross));
    receive(&mut roster, &one, 93.0, Received::Missing(4));
    receive(&mut roster, &one, 93.0, slip(11, Phase::Gross));
    assert_eq!(minute(&roster), "2");
}

#[test]
fn who_is_silent_or_gone_is_reported_and_keeps_what_was_known() {
    let (mut roster, one) = (Roster::default(), member("a", 1));
    let there = |roster: &Roster| Column::Here.text(row(roster, &one), roster.now_s());
    receive(&mut roster, &one, 0.0, Received::Came);
    receive(&mut roster, &one, 1.0, reported(&holding()));
    roster.take(FleetFeed::Now(3.5));
    assert_eq!(there(&roster), "here");
    roster.take(FleetFeed::Now(4.5));
    assert_eq!(there(&roster), "silent");
    // Figures do not state what the gripper does.
    receive(&mut roster, &one, 62.0, health_of(0, 0));
    assert_eq!(there(&roster), "silent 1 min");
    receive(&mut roster, &one, 70.0, Received::Gone);
    assert_eq!((there(&roster).as_str(), roster.summary().gone), ("gone", 1));
    roster.take(FleetFeed::Now(70.0 + 7300.0));
    assert_eq!(there(&roster), "gone 2 h");
    assert_eq!(states(&roster, &one)[7], "5.00");
    receive(&mut roster, &one, 8000.0, Received::Came);
    assert_eq!(there(&roster), "here");
    // Who was never here is not gone.
    receive(&mut roster, &member("a", 2), 8000.0, Received::Gone);
    assert_eq!(roster.rows().len(), 1);
}

/// Three grippers: 1 holds, 2 is gone, 3 has a fault.
fn three() -> Roster {
    let mut roster = Roster::default();
    let (one, two, three) = (member("b", 1), member("a", 2), member("b", 3));
    for (at_s, member) in [(0.0, &one), (0.1, &two), (0.2, &three)] {
        receive(&mut roster, member, at_s, Received::Came);
    }
    receive(&mut roster, &one, 1.0, reported(&PipelineState { applied_n: Some(2.0), ..holding() }));
    let fault = PipelineState { applied_n: Some(9.0), fault: FaultCode(0x21), ..holding() };
    receive(&mut roster, &three, 1.0, reported(&fault));
    receive(&mut roster, &two, 1.1, Received::Gone);
    roster
}

#[test]
fn rows_are_ordered_by_any_column_and_what_is_unknown_is_last() {
    let roster = three();
    let by = |column, descending| uids(&roster, Sorting { column, descending }, "");
    assert_eq!(uids(&roster, Sorting::default(), ""), [2, 1, 3]);
    assert_eq!(by(Column::Site, true), [1, 3, 2]);
    assert_eq!(by(Column::Gripper, true), [3, 2, 1]);
    assert_eq!(by(Column::Applied, false), [1, 3, 2]);
    assert_eq!(by(Column::Applied, true), [3, 1, 2]);
    assert_eq!(by(Column::Force, true), [3, 1, 2]);
    assert_eq!(by(Column::Scene, true), [1, 3, 2]);
    assert_eq!(by(Column::Trouble, true), [3, 2, 1]);
    assert_eq!(by(Column::Here, true), [2, 1, 3]);
    let both = Column::ALL.into_iter().flat_map(|column| [(column, false), (column, true)]);
    assert!(both.into_iter().all(|(column, descending)| by(column, descending).len() == 3));
}

#[test]
fn counts_of_all_and_the_common_scale() {
    let mut roster = three();
    let summary = Summary { all: 3, here: 2, gone: 1, faults: 1, ..Summary::default() };
    assert_eq!(roster.summary(), summary);
    assert_eq!(roster.top_n(), 9.0);
    assert_eq!(row(&roster, &member("b", 3)).trouble(1.1), Trouble::Fault);
    receive(&mut roster, &member("b", 1), 1.2, Received::Missing(4));
    assert_eq!(roster.missing(), 4);
    // A force that no gripper has does not flatten all curves.
    let huge = PipelineState { applied_n: Some(1e30), ..holding() };
    receive(&mut roster, &member("b", 1), 4.0, reported(&huge));
    assert_eq!(roster.top_n(), 9.0);
    let strange = message(Kind(0x7f), |_| 3);
    receive(&mut roster, &member("b", 1), 4.1, strange);
    roster.take(FleetFeed::Unreadable);
    assert_eq!(roster.unreadable(), 2);
}

#[test]
fn the_table_is_another_one_only_where_something_can_be_seen() {
    let mut roster = Roster::default();
    let pass = |roster: &mut Roster, now_s| {
        let before = roster.revision();
        roster.take(FleetFeed::Now(now_s));
        roster.revision() > before
    };
    assert!(!pass(&mut roster, 1.0) && !pass(&mut roster, 100.0), "an empty table stands still");
    let one = member("a", 1);
    receive(&mut roster, &one, 100.0, reported(&holding()));
    assert!(pass(&mut roster, 101.0), "a gripper that is there may fall silent");
    receive(&mut roster, &one, 101.0, Received::Gone);
    assert!(!pass(&mut roster, 101.5) && pass(&mut roster, 102.5), "its curve slides away");
    assert!(pass(&mut roster, 300.0));
    assert!(!pass(&mut roster, 302.5) && !pass(&mut roster, 359.0));
    assert!(pass(&mut roster, 360.5), "it is gone for a minute more");
    let status = SourceStatus::Live;
    let before = roster.revision();
    roster.take(FleetFeed::Status(status.clone()));
    assert_eq!(roster.revision(), before + 1);
    roster.take(FleetFeed::Status(status));
    assert_eq!(roster.revision(), before + 1);
}
