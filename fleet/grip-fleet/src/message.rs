//! The daemon's message in the bytes of one publication.

use grip_link::{
    cobs,
    frame::{
        self, BodyError, Direction, EncodeError, Frame, Header, MAX_BLOCK, MAX_PAYLOAD, MAX_WIRE,
    },
    message::{Kind, PayloadError, daemon::ToClient},
};

/// One frame of a daemon, checked. Number and session of the connection it came over mean nothing here and are zero.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    body: Vec<u8>,
}

/// Why bytes are no message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MessageError {
    /// Not one frame between two zeros.
    #[error("{len} bytes are not one frame")]
    Frame {
        /// Bytes given.
        len: usize,
    },
    /// The frame is damaged.
    #[error(transparent)]
    Body(#[from] BodyError),
    /// The message cannot be read.
    #[error(transparent)]
    Payload(#[from] PayloadError),
}

impl Message {
    /// Takes the bytes of a publication.
    ///
    /// # Errors
    /// [`MessageError`]: not one frame, or a damaged one.
    pub fn from_wire(wire: &[u8]) -> Result<Self, MessageError> {
        let wrong = MessageError::Frame { len: wire.len() };
        let [0, block @ .., 0] = wire else { return Err(wrong) };
        if block.len() > MAX_BLOCK || block.contains(&0) {
            return Err(wrong);
        }
        let mut block = block.to_vec();
        let body = cobs::decode_in_place(&mut block).ok_or(wrong)?;
        Frame::from_body(body)?;
        Ok(Self { body: body.to_vec() })
    }

    /// What the daemon reports.
    ///
    /// # Errors
    /// [`MessageError::Payload`], also for a type that is not known yet.
    pub fn read(&self) -> Result<ToClient<'_>, MessageError> {
        Ok(ToClient::parse(&Frame::from_body(&self.body)?)?)
    }
}

/// The bytes of the publication of what `write` writes, of which it gives the length; none, where that is too long.
pub fn wire(kind: Kind, write: impl FnOnce(&mut [u8]) -> usize) -> Vec<u8> {
    let mut payload = [0; MAX_PAYLOAD];
    let len = write(&mut payload);
    encoded(kind, payload.get(..len).unwrap_or_default()).unwrap_or_default()
}

/// The bytes of a publication.
///
/// # Errors
/// [`EncodeError::Payload`] for more than 480 bytes.
pub(crate) fn encoded(kind: Kind, payload: &[u8]) -> Result<Vec<u8>, EncodeError> {
    let mut out = [0; MAX_WIRE];
    let header = Header::new(Direction::ToHost, kind, 0, 0);
    let len = frame::encode(&header, payload, &mut out)?;
    Ok(out.get(..len).unwrap_or_default().to_vec())
}

#[cfg(test)]
mod tests {
    use super::{Message, MessageError, wire};
    use grip_link::message::{
        Kind,
        daemon::{Gripper, ToClient},
    };

    fn gripper() -> Vec<u8> {
        let gripper = Gripper { uid: [9; 16], boot_id: 3, ..Gripper::NONE };
        wire(Kind::GRIPPER, |out| gripper.write(out).unwrap())
    }

    #[test]
    fn a_message_is_read_as_it_is_written() {
        let message = Message::from_wire(&gripper()).unwrap();
        let Ok(ToClient::Gripper(read)) = message.read() else { panic!("{message:?}") };
        assert_eq!((read.uid, read.boot_id), ([9; 16], 3));
    }

    #[test]
    fn damaged_and_foreign_bytes_are_refused() {
        let good = gripper();
        for at in 0..good.len() {
            let mut bad = good.clone();
            bad[at] ^= 0x10;
            assert!(Message::from_wire(&bad).is_err(), "byte {at}");
        }
        for len in 0..good.len() {
            assert!(Message::from_wire(&good[..len]).is_err(), "{len} bytes");
        }
        let two = [good.as_slice(), good.as_slice()].concat();
        assert_eq!(Message::from_wire(&two), Err(MessageError::Frame { len: two.len() }));
        assert!(Message::from_wire(&vec![1; 100_000]).is_err());
    }
}
