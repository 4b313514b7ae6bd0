//! Every loss of a file, while it is read.

use super::loss::{Loss, Why, wider};

/// More losses than this are only counted.
const MOST: usize = 200;

/// Every loss of a file.
#[derive(Debug, Default)]
pub struct Losses {
    list: Vec<Loss>,
    more: u64,
    /// From here on, what lies behind a loss is not yet known.
    open: usize,
    /// From here on, nor is what lies before it.
    new: usize,
}

impl Losses {
    /// Whether there is any.
    pub fn any(&self) -> bool {
        !self.list.is_empty()
    }

    /// Messages that are known to be lost.
    pub fn messages(&self) -> u64 {
        let known = self.list.iter().filter_map(|loss| loss.messages);
        known.fold(0, u64::saturating_add)
    }

    /// Adds one.
    pub fn add(&mut self, loss: Loss) {
        if self.list.len() < MOST {
            self.list.push(loss);
        } else {
            self.more += 1;
        }
    }

    /// Dates the losses by the messages used in one step: those from before it by the `first`, its
    /// own by the `last` of all so far.
    pub fn date(&mut self, first: Option<u64>, last: Option<u64>) {
        if let Some(first) = first {
            for loss in self.list.get_mut(self.open..self.new).unwrap_or_default() {
                loss.until = Some(first);
            }
            self.open = self.new;
        }
        for loss in self.list.get_mut(self.new..).unwrap_or_default() {
            loss.since = last;
        }
        self.new = self.list.len();
    }

    /// Adds a message outside of chunks: one loss for all that follow each other for one reason.
    pub fn add_message(&mut self, offset: u64, end: u64, log_time: Option<u64>, why: Why) {
        const WHAT: &str = "messages";
        let span = log_time.map(|time| (time, time));
        match self.list.last_mut() {
            Some(last) if last.why == why && last.what == WHAT => {
                last.bytes = end.saturating_sub(last.offset);
                last.messages = last.messages.map(|count| count + 1);
                last.span = wider(last.span, span);
            }
            _ => self.add(Loss {
                span,
                messages: Some(1),
                ..Loss::new(offset, end.saturating_sub(offset), WHAT, why)
            }),
        }
    }

    /// Whether the last loss reaches to some place.
    pub fn reach(&self, end: u64) -> bool {
        let last = self.list.last();
        last.is_some_and(|loss| loss.offset.saturating_add(loss.bytes) == end)
    }

    /// All of them, by offset, with times told from the first message on.
    pub fn finish(mut self, log_start: Option<u64>) -> Vec<Loss> {
        self.list.sort_by_key(|loss| loss.offset);
        if self.more > 0 {
            let why = Why::More(self.more);
            self.list.push(Loss::new(0, 0, "the list ends here", why));
        }
        for loss in &mut self.list {
            loss.log_start = log_start;
        }
        self.list
    }
}
