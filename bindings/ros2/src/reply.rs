//! Answers to service calls that reach Fast DDS whatever their size.
//!
//! An answer names the call that it answers in the inline QoS of its first packet. RustDDS 0.15.1 spoils that in answers that it cuts into
//! fragments (`messages/submessages/data_frag.rs` writes the tag byte of an `Option` before it), and they are never matched to a call. So the
//! first fragment of such an answer is sent by us, with the name; RustDDS then sends all fragments without it and repairs what gets lost.
//! Answers of a size that may or may not be cut are padded until they are. When RustDDS writes it right, this file becomes one call of
//! `write_with_options`.

use crate::node::NodeError;
use ros2_client::RmwRequestId;
use ros2_client::dds::rustdds::bytes::Bytes;
use ros2_client::dds::rustdds::no_key::{DataWriter, SerializerAdapter};
use ros2_client::dds::rustdds::{
    CDRSerializerAdapter, DomainParticipant, GUID, QosPolicies, RTPSEntity, RepresentationIdentifier, SampleIdentity, Timestamp, Topic,
    WriteOptionsBuilder,
};
use serde::Serialize;
use std::convert::Infallible;
use std::net::{SocketAddr, UdpSocket};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Size up to which an answer is whole on any network, and size from which it is cut on any that has no larger packets than jumbo frames.
const ETHERNET: [usize; 2] = [1_000, 9_000];
/// The same where all clients are reached by loopback only.
const LOOPBACK: [usize; 2] = [60_000, 66_000];
/// Size of the fragments of RustDDS \[bytes\].
const FRAGMENT: usize = 256;

/// An answer that is serialised already.
struct Serialized(Bytes);
struct AsItIs;

impl SerializerAdapter<Serialized> for AsItIs {
    type Error = Infallible;
    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }
    fn to_bytes(value: &Serialized) -> Result<Bytes, Infallible> {
        Ok(value.0.clone())
    }
}

/// Sends the answers of a service.
pub struct Replies {
    writer: DataWriter<Serialized, AsItIs>,
    participant: DomainParticipant,
    topic: String,
    socket: UdpSocket,
    /// Number of the last answer.
    last: Mutex<i64>,
}

impl Replies {
    /// Answers on `topic`.
    ///
    /// # Errors
    /// DDS refuses; no socket.
    pub fn new(participant: DomainParticipant, topic: &Topic, name: String, quality: &QosPolicies) -> Result<Self, NodeError> {
        let publisher = participant.create_publisher(quality).map_err(NodeError::dds(&name))?;
        let writer = publisher.create_datawriter_no_key(topic, None).map_err(NodeError::dds(&name))?;
        let socket = UdpSocket::bind("0.0.0.0:0")?;
        Ok(Self { writer, participant, topic: name, socket, last: Mutex::new(0) })
    }

    /// Answers `request`. Nobody may be left to hear it.
    pub fn send<Resp: Serialize>(&self, request: RmwRequestId, response: &Resp) {
        let Ok(bytes) = <CDRSerializerAdapter<Resp> as SerializerAdapter<Resp>>::to_bytes(response) else { return };
        let mut readers = self.participant.discovered_readers();
        readers.retain(|reader| *reader.subscription_topic_data.topic_name() == self.topic);
        let addresses = |reader: usize| -> Vec<SocketAddr> {
            let list = &readers[reader].reader_proxy.unicast_locator_list;
            list.iter().filter(|locator| locator.is_udp()).map(|locator| SocketAddr::from(*locator)).collect()
        };
        let local = (0..readers.len()).flat_map(addresses).all(|address| address.ip().is_loopback());
        let [whole, cut] = if local { LOOPBACK } else { ETHERNET };

        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let options = WriteOptionsBuilder::new().source_timestamp(Timestamp::now());
        let (options, bytes) = if bytes.len() <= whole {
            (options.related_sample_identity(SampleIdentity::from(request)), bytes)
        } else {
            // Readers stop at the end of what they expect.
            let mut padded = bytes.to_vec();
            padded.resize(padded.len().max(cut), 0);
            for (i, reader) in readers.iter().enumerate() {
                let to = reader.reader_proxy.remote_reader_guid;
                if to.prefix == GUID::from(request.writer_gid).prefix {
                    let packet = packet(self.writer.guid(), to, request, *last + 1, &padded);
                    addresses(i).into_iter().for_each(|address| drop(self.socket.send_to(&packet, address)));
                }
            }
            (options, padded.into())
        };
        if let Ok(identity) = self.writer.write_with_options(Serialized(bytes), options.build()) {
            *last = identity.sequence_number.into();
        }
    }
}

impl Drop for Replies {
    fn drop(&mut self) {
        // An answer that is not yet acknowledged may have to be sent again. Without one this returns at once.
        let _ = self.writer.wait_for_acknowledgments(Duration::from_millis(300));
    }
}

/// An RTPS message with one `DATA_FRAG` (RTPS 2.5, 9.4.5.4) that has the identity of the request in its inline QoS.
fn packet(from: GUID, to: GUID, request: RmwRequestId, number: i64, bytes: &[u8]) -> Vec<u8> {
    let (from, to, client) = (from.to_bytes(), to.to_bytes(), GUID::from(request.writer_gid).to_bytes());
    let sequence = |n: i64| -> [u8; 8] {
        let ([a, b, c, d], [e, f, g, h]) = (((n >> 32) as i32).to_le_bytes(), (n as u32).to_le_bytes());
        [a, b, c, d, e, f, g, h]
    };
    let sample = 4 + bytes.len();

    let mut body = vec![0, 0, 28, 0];
    body.extend_from_slice(&to[12..]);
    body.extend_from_slice(&from[12..]);
    body.extend_from_slice(&sequence(number));
    body.extend_from_slice(&1u32.to_le_bytes());
    body.extend_from_slice(&1u16.to_le_bytes());
    body.extend_from_slice(&(FRAGMENT as u16).to_le_bytes());
    body.extend_from_slice(&(sample as u32).to_le_bytes());
    // The standard parameter, and the one that Fast DDS had before there was a standard.
    for parameter in [0x0083u16, 0x800f] {
        body.extend_from_slice(&parameter.to_le_bytes());
        body.extend_from_slice(&24u16.to_le_bytes());
        body.extend_from_slice(&client);
        body.extend_from_slice(&sequence(request.sequence_number));
    }
    body.extend_from_slice(&[1, 0, 0, 0]);
    body.extend_from_slice(&[0, 1, 0, 0]);
    body.extend_from_slice(&bytes[..FRAGMENT - 4]);

    let mut packet = b"RTPS\x02\x04\x01\x12".to_vec();
    packet.extend_from_slice(&from[..12]);
    packet.extend_from_slice(&[0x0e, 1, 12, 0]);
    packet.extend_from_slice(&to[..12]);
    packet.extend_from_slice(&[0x16, 3]);
    packet.extend_from_slice(&(body.len() as u16).to_le_bytes());
    packet.extend_from_slice(&body);
    packet
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_fragment_names_the_call() {
        let guid = |n: u8| GUID::from_bytes([n; 16]);
        let request = RmwRequestId { writer_gid: guid(7).into(), sequence_number: (5 << 32) + 6 };
        let packet = packet(guid(1), guid(2), request, 9, &[3; 1000]);
        assert_eq!(&packet[..8], b"RTPS\x02\x04\x01\x12");
        let frag = &packet[36..];
        assert_eq!(frag[..2], [0x16, 3]);
        assert_eq!(usize::from(u16::from_le_bytes([frag[2], frag[3]])), frag.len() - 4);
        assert_eq!(frag[8..16], [2, 2, 2, 2, 1, 1, 1, 1], "reader, writer");
        assert_eq!(frag[16..36], [0, 0, 0, 0, 9, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 236, 3, 0, 0]);
        assert_eq!(frag[36..64], [[0x83, 0, 24, 0].as_slice(), &[7; 16], &[5, 0, 0, 0, 6, 0, 0, 0]].concat());
        assert_eq!(frag[92..96], [1, 0, 0, 0]);
        assert_eq!(frag[96..].len(), FRAGMENT);
    }
}
