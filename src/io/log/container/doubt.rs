//! What nothing vouches for: told from the rest by the data section's checksum and the summary's counts.

use std::io::{Read, Seek};

use super::loss::{Loss, Why, wider};
use super::trust::data_section;
use super::walker::Walker;
use super::{OpenError, Unchecked};

impl<R: Read + Seek> Walker<'_, R> {
    /// Whether the data section's checksum does not speak against what only it covers.
    pub(super) fn section_agrees(&mut self) -> Result<bool, OpenError> {
        if let Some(agrees) = self.section {
            return Ok(agrees);
        }
        let agrees = match self.tail.data_end {
            Some(data_end) => data_section(&mut self.source, data_end)?.unwrap_or(true),
            None => true,
        };
        self.section = Some(agrees);
        Ok(agrees)
    }

    /// Reports what the data section's checksum speaks against; whether it is to be left out.
    pub(super) fn distrust(
        &mut self,
        at: u64,
        end: u64,
        span: Option<(u64, u64)>,
        messages: Option<u64>,
    ) -> bool {
        let what = "all that has no checksum of its own";
        let (why, left_out) = match self.unchecked {
            Unchecked::LeftOut => (Why::DataSection, true),
            Unchecked::Used => (Why::Unchecked, false),
        };
        let loss = self
            .distrusted
            .get_or_insert_with(|| Loss::new(at, 0, what, why));
        loss.bytes = end.saturating_sub(loss.offset);
        loss.span = wider(loss.span, span);
        if let Some(more) = messages.filter(|_| left_out) {
            loss.messages = Some(loss.messages.unwrap_or_default().saturating_add(more));
        }
        left_out
    }

    /// Reports a loss that nothing else has shown, by the number of messages or else by the checksum
    /// over everything.
    pub(super) fn compare(&mut self) -> Result<(), OpenError> {
        let summary = self.tail.summary.as_ref();
        let counted = summary.and_then(|summary| summary.messages);
        let read = self.used.messages;
        if self.losses.any() {
            // What the losses do not say of how much is missing.
            let missing = counted.and_then(|counted| counted.checked_sub(read));
            if let Some((counted, missing)) = counted.zip(missing)
                && missing > self.losses.messages()
            {
                self.losses.add(Loss {
                    messages: Some(missing),
                    ..Loss::new(0, 0, "the file as a whole", Why::Count { counted, read })
                });
            }
            return Ok(());
        }
        match counted {
            Some(counted) if counted == read => {}
            Some(counted) => self.losses.add(Loss {
                messages: counted.checked_sub(read),
                ..Loss::new(
                    0,
                    0,
                    "the number of messages is wrong",
                    Why::Count { counted, read },
                )
            }),
            None if self.section_agrees()? => {}
            None => {
                let end = self.limit(0);
                let what = "the data section";
                self.losses.add(Loss::new(0, end, what, Why::BetweenChunks));
            }
        }
        Ok(())
    }
}
