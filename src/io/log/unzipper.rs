//! Messages whose payloads are compressed one by one, as `ros2 bag record --compression-mode message` writes
//! them (ros2/rosbag2#1533).

use std::io::Read;

/// What a zstd frame begins with; CDR begins with a zero.
const MAGIC: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// No reading or pose is longer, bytes.
const LONGEST: u64 = 4 << 20;

/// How much all payloads of a log may unpack to: bytes, and a multiple of what they take packed.
const BUDGET: (u64, u64) = (512 << 20, 100);

/// Unpacks payloads, one after the other.
#[derive(Debug, Default)]
pub struct Unzipper {
    buffer: Vec<u8>,
    packed: u64,
    unpacked: u64,
}

impl Unzipper {
    /// The payload, unpacked where it is packed. One that cannot be unpacked stays what it is, which is no CDR.
    pub fn unzipped<'m>(&'m mut self, payload: &'m [u8]) -> &'m [u8] {
        if !payload.starts_with(&MAGIC) {
            return payload;
        }
        self.packed = self.packed.saturating_add(payload.len() as u64);
        let budget = self
            .packed
            .saturating_mul(BUDGET.1)
            .saturating_add(BUDGET.0);
        self.buffer.clear();
        let decoder = zstd::Decoder::with_buffer(payload);
        let unpacked = decoder.and_then(|decoder| {
            decoder
                .take(LONGEST.min(budget.saturating_sub(self.unpacked)))
                .read_to_end(&mut self.buffer)
        });
        self.unpacked = self.unpacked.saturating_add(self.buffer.len() as u64);
        match unpacked {
            Ok(_) => &self.buffer,
            Err(_) => payload,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_packed_is_unpacked_and_all_else_left() {
        let mut unzipper = Unzipper::default();
        let message = [0, 1, 0, 0, 7, 7, 7, 7];
        let packed = zstd::encode_all(&message[..], 0).unwrap();
        assert_eq!(unzipper.unzipped(&packed), message);
        assert_eq!(unzipper.unzipped(&message), message);
        let broken = &packed[..packed.len() - 1];
        assert_eq!(unzipper.unzipped(broken), broken);
    }

    #[test]
    fn no_payload_unpacks_to_more_than_a_message() {
        let mut unzipper = Unzipper::default();
        let bomb = zstd::encode_all(&vec![0; 64 << 20][..], 0).unwrap();
        assert_eq!(unzipper.unzipped(&bomb).len() as u64, LONGEST);
    }
}
