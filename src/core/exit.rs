//! How a command ends, for the scripts that run it.

/// How a command ends. Reports name it by its [`code`](Exit::code), which `main` hands to the system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    /// It finished; a check matches.
    Done = 0,
    /// It finished, and the answer is no: a check differs.
    Differs = 1,
    /// Usage, configuration, or input that cannot be read.
    Unusable = 2,
    /// It finished on an incomplete or damaged log, or had nothing to look at.
    Incomplete = 3,
}

impl Exit {
    /// [`Exit::Done`] for a log that could be looked at as a whole, else [`Exit::Incomplete`].
    pub fn of_whole(whole: bool) -> Self {
        if whole { Self::Done } else { Self::Incomplete }
    }

    /// The number that scripts see.
    pub fn code(self) -> u8 {
        self as u8
    }
}
