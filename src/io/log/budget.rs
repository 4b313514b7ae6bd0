//! How much of a log is held in memory.

use super::error::LogError;
use super::message::Content;
use crate::core::config::{Config, Input};

/// So many messages a file of any size may hold.
const MESSAGES: u64 = 300_000;
/// Beyond these, so many bytes of the file stand behind each: two times and a range that differ from
/// those before take more however well they are packed.
const BYTES_PER_MESSAGE: u64 = 4;

/// What is left of the memory, and of the time, that a log may take.
#[derive(Debug)]
pub struct Budget {
    file_bytes: u64,
    messages: u64,
    most_messages: u64,
    readings: u64,
    most_readings: u64,
}

impl Budget {
    /// For a file of so many bytes. More readings than usual, when they are asked for, may be
    /// packed in any way.
    pub fn new(config: &Config, file_bytes: u64) -> Self {
        let asked_for = config.input.max_readings;
        Self {
            file_bytes,
            messages: 0,
            most_messages: if asked_for > Input::default().max_readings {
                u64::MAX
            } else {
                MESSAGES.saturating_add(file_bytes / BYTES_PER_MESSAGE)
            },
            readings: 0,
            most_readings: asked_for,
        }
    }

    /// Whether another message of a channel that is used may be read.
    pub fn admits_message(&mut self) -> bool {
        self.messages = self.messages.saturating_add(1);
        self.messages <= self.most_messages && self.readings <= self.most_readings
    }

    /// Whether there is room for what a message says.
    pub fn admits(&mut self, content: &Content) -> bool {
        // What is not held takes time all the same.
        if let Content::Transforms(transforms) = content {
            self.messages = self.messages.saturating_add(transforms.len() as u64);
        }
        let held = match content {
            Content::Odometry(_) => 1,
            Content::Transforms(_) | Content::Description(_) => 0,
            Content::Ranges(_) | Content::Hits(_) | Content::Crowd(_) => content.sonars() as u64,
        };
        self.readings = self.readings.saturating_add(held);
        self.readings <= self.most_readings
    }

    /// # Errors
    /// When something was not admitted.
    pub fn check(&self, file: &str) -> Result<(), LogError> {
        let file = file.to_owned();
        if self.readings > self.most_readings {
            return Err(LogError::TooManyReadings {
                file,
                most: self.most_readings,
            });
        }
        if self.messages > self.most_messages {
            return Err(LogError::TooDense {
                file,
                bytes: self.file_bytes,
                most: self.most_messages,
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::log::message::RangeMessage;

    fn budget(max_readings: u64) -> Budget {
        let mut config = Config::default();
        config.input.max_readings = max_readings;
        Budget::new(&config, 1200)
    }

    #[test]
    fn every_reading_of_a_message_counts() {
        let three = Content::Ranges(vec![RangeMessage::plain(0, "f", 1.0); 3]);
        let mut budget = budget(6);
        assert!(budget.admits(&three) && budget.admits(&three) && budget.check("f").is_ok());
        assert!(!budget.admits(&three) && !budget.admits_message());
        let said = budget.check("f").unwrap_err().to_string();
        assert!(
            said.contains("more than 6 ") && said.contains("input.max_readings"),
            "{said}"
        );
    }

    #[test]
    fn messages_that_take_no_room_in_the_file_run_out() {
        let mut few = budget(2_000_000);
        let most = MESSAGES + 1200 / BYTES_PER_MESSAGE;
        assert!((0..most).all(|_| few.admits_message()));
        assert!(!few.admits_message());
        let said = few.check("f").unwrap_err().to_string();
        assert!(
            said.contains("1200 bytes") && said.contains("input.max_readings"),
            "{said}"
        );
        let mut asked_for = budget(2_000_001);
        assert!((0..=most).all(|_| asked_for.admits_message()));
    }
}
