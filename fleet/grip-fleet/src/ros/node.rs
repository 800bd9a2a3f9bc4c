//! Names of a gripper's node and topics, and those that Zenoh has for them.

use super::topic::RosTopic;
use crate::key::Member;
use grip_session::config::Site;

/// Where tokens stand.
const TOKENS: &str = "@ros2_lv";
/// The node's name within its namespace.
const NAME: &str = "gripd";
/// No enclave, as rmw_zenoh writes it.
const ENCLAVE: &str = "%";
/// Reliable, volatile, the last ten, no deadlines. What rmw_zenoh has by default is left out: of all this only the ten.
const QOS: &str = "::,10:,:,:,,";

/// The node of one gripper.
///
/// Its namespace is `/SITE/gripper_UID`, its name `gripd`. Names of ROS are of letters, digits and underscores, none of them twice in a row, and
/// begin with a letter: what else a site's name holds becomes an underscore, and one that begins with something else begins with `site_`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RosNode {
    domain: u16,
    namespace: String,
}

impl RosNode {
    /// The node of a gripper in a domain (`ROS_DOMAIN_ID`, 0 to 232).
    #[must_use]
    pub fn new(member: &Member, domain: u16) -> Self {
        let namespace = format!("/{}/gripper_{}", word(&member.site), member.uid);
        Self { domain, namespace }
    }

    /// Its full name.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{}/{NAME}", self.namespace)
    }

    /// The full name of a topic: what `ros2 topic echo` is given.
    #[must_use]
    pub fn topic(&self, topic: RosTopic) -> String {
        format!("{}/{}", self.namespace, topic.name())
    }

    /// Under which name Zenoh carries a topic.
    #[must_use]
    pub fn key(&self, topic: RosTopic) -> String {
        format!("{}{}/{}/{}", self.domain, self.topic(topic), topic.dds_type(), topic.hash())
    }

    /// The token that states that the node is there; `session` is the number of its Zenoh session, as that prints it.
    #[must_use]
    pub fn token(&self, session: &str) -> String {
        self.entity(session, 0, "NN")
    }

    /// The token that states that it publishes a topic.
    #[must_use]
    pub fn publisher_token(&self, session: &str, topic: RosTopic) -> String {
        let entity = self.entity(session, topic as usize + 1, "MP");
        let name = mangled(&self.topic(topic));
        format!("{entity}/{name}/{}/{}/{QOS}", topic.dds_type(), topic.hash())
    }

    /// What all tokens of the node begin with. It is the only one of its session, number 0.
    fn entity(&self, session: &str, number: usize, kind: &str) -> String {
        let namespace = mangled(&self.namespace);
        format!("{TOKENS}/{}/{session}/0/{number}/{kind}/{ENCLAVE}/{namespace}/{NAME}", self.domain)
    }
}

/// A name as one part of a token.
fn mangled(name: &str) -> String {
    name.replace('/', "%")
}

/// A site's name as ROS can write it.
fn word(site: &Site) -> String {
    let site = site.to_string();
    let parts = site.split(|letter: char| !letter.is_ascii_alphanumeric());
    let mut parts: Vec<&str> = parts.filter(|part| !part.is_empty()).collect();
    if !site.starts_with(|letter: char| letter.is_ascii_alphabetic()) {
        parts.insert(0, "site");
    }
    parts.join("_")
}

#[cfg(test)]
mod tests {
    use super::{Member, RosNode, RosTopic, Site, word};
    use grip_session::config::Uid;

    const UID: &str = "07070707070707070707070707070707";
    const SESSION: &str = "8b20917502ee955ac4476e0266340d5c";

    fn node(site: &str) -> RosNode {
        let member = Member { site: site.parse().unwrap(), uid: Uid([7; 16]) };
        RosNode::new(&member, 2)
    }

    #[test]
    fn names_are_those_of_the_design_document() {
        let node = node("hall-2");
        let place = format!("hall_2/gripper_{UID}");
        assert_eq!(node.name(), format!("/{place}/gripd"));
        assert_eq!(
            node.key(RosTopic::JointStates),
            format!(
                "2/{place}/joint_states/sensor_msgs::msg::dds_::JointState_/{}",
                RosTopic::JointStates.hash()
            )
        );
        let mangled = format!("%hall_2%gripper_{UID}");
        assert_eq!(node.token(SESSION), format!("@ros2_lv/2/{SESSION}/0/0/NN/%/{mangled}/gripd"));
        assert_eq!(
            node.publisher_token(SESSION, RosTopic::Slip),
            format!(
                "@ros2_lv/2/{SESSION}/0/3/MP/%/{mangled}/gripd/{mangled}%slip/grip_msgs::msg::dds_::SlipEvent_/{}/::,10:,:,:,,",
                RosTopic::Slip.hash()
            )
        );
    }

    #[test]
    fn every_site_has_a_name_that_ros_takes() {
        for (site, wanted) in [
            ("hall", "hall"),
            ("Hall-2.east", "Hall_2_east"),
            ("a__b", "a_b"),
            ("a-._b-", "a_b"),
            ("2-east", "site_2_east"),
            ("_x", "site_x"),
            ("-.-", "site"),
        ] {
            assert_eq!(word(&site.parse().unwrap()), wanted, "{site}");
        }
        let longest: Site = "9".repeat(64).parse().unwrap();
        let member = Member { site: longest, uid: Uid([7; 16]) };
        let node = RosNode::new(&member, 232);
        // The longest topic name that DDS takes is 255 bytes, of which ROS needs eight.
        assert!(node.topic(RosTopic::JointStates).len() < 240);
    }
}
