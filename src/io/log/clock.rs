//! When the messages of each channel were stamped and when they were recorded.

use std::collections::BTreeMap;

use super::channels::ChannelReport;
use super::container::Channel;

/// The clock of one channel.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ChannelClock {
    /// Its messages, read or not.
    pub messages: u64,
    /// When its earliest message was recorded, nanoseconds.
    pub first_logged_ns: i64,
    /// When its latest message was recorded, nanoseconds.
    pub last_logged_ns: i64,
    /// Messages that lie in the file behind one of this channel that was recorded later.
    pub out_of_order: u64,
    /// Messages whose header has a stamp other than 0.
    pub stamped: u64,
    /// Messages whose header has the stamp 0.
    pub unstamped: u64,
    /// Messages stamped earlier than the one before them.
    pub backward: u64,
    /// Messages with the stamp of the one before them.
    pub repeated: u64,
    /// Time from stamp to recording in the middle of all, nanoseconds.
    pub median_delay_ns: Option<i64>,
    /// The time from stamp to recording that is farthest from 0, nanoseconds.
    pub extreme_delay_ns: Option<i64>,
}

/// The clocks of a log while it is read.
#[derive(Debug, Default)]
pub struct Clocks {
    of_channel: BTreeMap<u16, Running>,
}

#[derive(Debug, Default)]
struct Running {
    topic: String,
    type_name: String,
    encoding: String,
    clock: ChannelClock,
    last_stamp: Option<i64>,
    delays: Vec<i64>,
}

impl Clocks {
    /// Takes a message: when it was recorded and, where it was read, the stamp of its header.
    pub fn take(&mut self, channel: &Channel, log_time: u64, stamp_ns: Option<i64>) {
        let running = self
            .of_channel
            .entry(channel.id)
            .or_insert_with(|| Running {
                topic: channel.topic.clone(),
                type_name: channel.schema.name.clone(),
                encoding: channel.encoding.clone(),
                ..Running::default()
            });
        running.take(i64::try_from(log_time).unwrap_or(i64::MAX), stamp_ns);
    }

    /// The clock that belongs to each channel; those of several publishers on one topic together.
    pub fn finish(self, channels: &[ChannelReport]) -> Vec<ChannelClock> {
        let mut known: BTreeMap<[String; 3], ChannelClock> = BTreeMap::new();
        for running in self.of_channel.into_values() {
            let clock = running.finish();
            let names = [running.topic, running.type_name, running.encoding];
            let together = match known.remove(&names) {
                Some(other) => other.together(clock),
                None => clock,
            };
            known.insert(names, together);
        }
        channels
            .iter()
            .map(|channel| {
                let names = [&channel.topic, &channel.type_name, &channel.encoding];
                known
                    .get(&names.map(Clone::clone))
                    .cloned()
                    .unwrap_or_default()
            })
            .collect()
    }
}

impl Running {
    fn take(&mut self, logged_ns: i64, stamp_ns: Option<i64>) {
        let clock = &mut self.clock;
        if clock.messages == 0 {
            (clock.first_logged_ns, clock.last_logged_ns) = (logged_ns, logged_ns);
        }
        clock.messages += 1;
        clock.out_of_order += u64::from(logged_ns < clock.last_logged_ns);
        clock.first_logged_ns = clock.first_logged_ns.min(logged_ns);
        clock.last_logged_ns = clock.last_logged_ns.max(logged_ns);
        match stamp_ns {
            None => {}
            Some(0) => clock.unstamped += 1,
            Some(stamp) => {
                clock.stamped += 1;
                clock.backward += u64::from(self.last_stamp.is_some_and(|last| stamp < last));
                clock.repeated += u64::from(self.last_stamp == Some(stamp));
                self.last_stamp = Some(stamp);
                self.delays.push(logged_ns.saturating_sub(stamp));
            }
        }
    }

    fn finish(&self) -> ChannelClock {
        let mut delays = self.delays.clone();
        delays.sort_unstable();
        ChannelClock {
            median_delay_ns: delays.get(delays.len() / 2).copied(),
            extreme_delay_ns: delays
                .first()
                .into_iter()
                .chain(delays.last())
                .copied()
                .max_by_key(|delay| delay.unsigned_abs()),
            ..self.clock.clone()
        }
    }
}

impl ChannelClock {
    /// Two channels seen as one; the median is that of the busier one.
    fn together(self, other: Self) -> Self {
        let busier = if other.stamped > self.stamped {
            &other
        } else {
            &self
        };
        let extremes = self
            .extreme_delay_ns
            .into_iter()
            .chain(other.extreme_delay_ns);
        Self {
            messages: self.messages + other.messages,
            first_logged_ns: self.first_logged_ns.min(other.first_logged_ns),
            last_logged_ns: self.last_logged_ns.max(other.last_logged_ns),
            out_of_order: self.out_of_order + other.out_of_order,
            stamped: self.stamped + other.stamped,
            unstamped: self.unstamped + other.unstamped,
            backward: self.backward + other.backward,
            repeated: self.repeated + other.repeated,
            median_delay_ns: busier.median_delay_ns,
            extreme_delay_ns: extremes.max_by_key(|delay| delay.unsigned_abs()),
        }
    }

    /// Messages per second of recording; `None` where no time passed.
    pub fn rate(&self) -> Option<f64> {
        let seconds = self.last_logged_ns.saturating_sub(self.first_logged_ns) as f64 * 1e-9;
        (seconds > 0.0).then(|| self.messages.saturating_sub(1) as f64 / seconds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock(messages: &[(i64, Option<i64>)]) -> ChannelClock {
        let mut running = Running::default();
        for (logged, stamp) in messages {
            running.take(*logged, *stamp);
        }
        running.finish()
    }

    #[test]
    fn what_is_odd_about_stamps_is_counted() {
        let clock = clock(&[
            (100, Some(90)),
            (200, Some(90)),
            (150, Some(80)),
            (300, Some(0)),
            (400, Some(500)),
            (600, None),
        ]);
        assert_eq!((clock.messages, clock.stamped, clock.unstamped), (6, 4, 1));
        assert_eq!((clock.backward, clock.repeated), (1, 1));
        assert_eq!(clock.out_of_order, 1);
        assert_eq!((clock.first_logged_ns, clock.last_logged_ns), (100, 600));
        assert_eq!(clock.median_delay_ns, Some(70));
        assert_eq!(clock.extreme_delay_ns, Some(110));
        assert!((clock.rate().unwrap() - 1e7).abs() < 1e-3);
    }

    #[test]
    fn a_single_message_has_no_rate() {
        assert_eq!(clock(&[(5, None)]).rate(), None);
        assert_eq!(clock(&[(5, None)]).median_delay_ns, None);
    }

    #[test]
    fn two_publishers_of_a_topic_count_together() {
        let one = clock(&[(0, Some(1)), (10, Some(5))]);
        let two = clock(&[(5, Some(-100))]);
        let both = one.together(two);
        assert_eq!((both.messages, both.last_logged_ns), (3, 10));
        assert_eq!(both.median_delay_ns, Some(5));
        assert_eq!(both.extreme_delay_ns, Some(105));
    }
}
