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

    /// How a run over several ends: 2 stands before 1, 1 before 3, 3 before 0. What could not be read may hide
    /// anything, a difference is sure, and where there was nothing to look at nothing may be called good.
    pub fn gravest(exits: impl IntoIterator<Item = Self>) -> Self {
        let gravest = exits.into_iter().max_by_key(|exit| exit.gravity());
        gravest.unwrap_or(Self::Incomplete)
    }

    /// How grave it is beside others.
    pub fn gravity(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::Incomplete => 1,
            Self::Differs => 2,
            Self::Unusable => 3,
        }
    }

    /// The number that scripts see.
    pub fn code(self) -> u8 {
        self as u8
    }
}
