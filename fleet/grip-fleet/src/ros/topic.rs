//! Topics of a gripper's node: name, type and hash of the type for each kind of message.

slip_core::named! {
    /// What the node of a gripper publishes.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum RosTopic {
        fn name: "Its name within the node's namespace.";
        fn hash: "RIHS01 of its type: SHA-256 of names and kinds of all fields, those of the types in it included. Subscribers with another definition receive nothing. The test `ros_types` computes it from the definitions.";
    }
    JointStates:
        "The force of the fingers, as every tool of ROS understands it.",
        "joint_states", "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e";
    State:
        "What the pipeline thinks.",
        "state", "RIHS01_7838f15d0e70ce95e86c6532ff5d4091e1630859a07365c9f99676b771ddb389";
    Slip: "Slips.", "slip", "RIHS01_211c6ae58e973937edde81c0b2761708c129e379ce3a41b985869d20e6cdb1a2";
}

impl RosTopic {
    /// Package and name of its type.
    const fn parts(self) -> (&'static str, &'static str) {
        match self {
            Self::JointStates => ("sensor_msgs", "JointState"),
            Self::State => ("grip_msgs", "GripState"),
            Self::Slip => ("grip_msgs", "SlipEvent"),
        }
    }

    /// Its type, as ROS writes it: `sensor_msgs/msg/JointState`.
    #[must_use]
    pub fn ros_type(self) -> String {
        let (package, name) = self.parts();
        format!("{package}/msg/{name}")
    }

    /// Its type, as DDS writes it: `sensor_msgs::msg::dds_::JointState_`.
    #[must_use]
    pub fn dds_type(self) -> String {
        let (package, name) = self.parts();
        format!("{package}::msg::dds_::{name}_")
    }
}
