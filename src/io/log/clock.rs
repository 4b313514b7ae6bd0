//! When the messages of each channel were stamped and when they were recorded.

use std::collections::BTreeMap;

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

/// The clocks of a log while it is read, by the numbers of their channels.
#[derive(Debug, Default)]
pub struct Clocks(BTreeMap<u16, Running>);

#[derive(Debug, Default)]
struct Running {
    clock: ChannelClock,
    last_stamp: Option<i64>,
    delays: Vec<i64>,
}

impl Clocks {
    /// Takes a message: when it was recorded and, where it was read, the stamp of its header.
    pub fn take(&mut self, channel: u16, log_time: u64, stamp_ns: Option<i64>) {
        let running = self.0.entry(channel).or_default();
        running.take(i64::try_from(log_time).unwrap_or(i64::MAX), stamp_ns);
    }

    /// The clock of a channel.
    pub fn finish(&mut self, channel: u16) -> ChannelClock {
        self.0.remove(&channel).unwrap_or_default().finish()
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

    fn finish(mut self) -> ChannelClock {
        let delays = &mut self.delays;
        delays.sort_unstable();
        ChannelClock {
            median_delay_ns: delays.get(delays.len() / 2).copied(),
            extreme_delay_ns: delays
                .first()
                .into_iter()
                .chain(delays.last())
                .copied()
                .max_by_key(|delay| delay.unsigned_abs()),
            ..self.clock
        }
    }
}

impl ChannelClock {
    /// Two channels seen as one; the median is that of the busier one.
    pub fn together(self, other: Self) -> Self {
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
