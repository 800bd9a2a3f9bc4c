//! A virtual gripper of Robotiq, for tests of this crate and of gripd: it answers requests of Modbus RTU.

/// A gripper on the other end of the line, by its manual: registers, and no physics but an object that stops the fingers.
pub(crate) struct Device {
    pub(crate) registers: [u16; 3],
    /// Answers, and with what: status byte, fault byte.
    pub(crate) answers: bool,
    pub(crate) activated: bool,
    pub(crate) object: bool,
    pub(crate) fault: u8,
    /// Current register (10 mA).
    pub(crate) current: u8,
    /// Every write, in order.
    pub(crate) writes: Vec<[u16; 3]>,
}

impl Device {
    pub(crate) fn new(activated: bool) -> Self {
        let registers = if activated { [0x0900, 0, 0] } else { [0; 3] };
        Self {
            registers,
            answers: true,
            activated,
            object: false,
            fault: 0,
            current: 10,
            writes: Vec::new(),
        }
    }

    /// What comes back for a whole request.
    pub(crate) fn answer(&mut self, request: &[u8]) -> Option<Vec<u8>> {
        let word = |at: usize| u16::from_be_bytes([request[at], request[at + 1]]);
        assert_eq!(request[0], 9);
        let mut bytes = match request[1] {
            0x10 => {
                assert_eq!((word(2), word(4), request[6]), (0x03E8, 3, 6));
                self.registers = [word(7), word(9), word(11)];
                self.writes.push(self.registers);
                self.activated = self.registers[0] & 0x0100 != 0;
                vec![9, 0x10, 3, 0xE8, 0, 3]
            }
            4 => {
                assert!(word(2) == 0x07D0 && (1..=3).contains(&word(4)));
                let [action, position, _] = self.registers;
                let follows = u8::from(action & 0x0800 != 0) << 3;
                let closes = follows != 0 && position >= 200;
                let object = if closes && self.object { 2 << 6 } else { 3 << 6 };
                let state = if self.activated { 0x31 | follows | object } else { 0 };
                let status = [state, 0, self.fault, position.to_be_bytes()[1], 100, self.current];
                let count = 2 * request[5];
                [&[9, 4, count], &status[..usize::from(count)]].concat()
            }
            other => panic!("function {other}"),
        };
        bytes.extend(crc(&bytes).to_le_bytes());
        self.answers.then_some(bytes)
    }
}

/// CRC-16 of Modbus, bit by bit, as its specification has it.
pub(crate) fn crc(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xFFFF, |crc, byte| {
        (0..8).fold(
            crc ^ u16::from(*byte),
            |crc, _| {
                if crc & 1 == 1 { crc >> 1 ^ 0xA001 } else { crc >> 1 }
            },
        )
    })
}
