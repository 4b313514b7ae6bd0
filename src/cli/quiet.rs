//! How much is said beside a result.

/// `-q`: the result stands alone.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct Quiet {
    /// Say nothing else but what went wrong: no progress, no notes
    #[arg(short, long)]
    quiet: bool,
}

impl Quiet {
    /// Whether it is asked for.
    pub fn is_set(self) -> bool {
        self.quiet
    }

    /// What a person must know of a log, less the notes where it is to be quiet.
    pub fn less(self, problems: String) -> String {
        match self.quiet {
            true => (problems.split_inclusive('\n'))
                .filter(|line| !line.starts_with("note: "))
                .collect(),
            false => problems,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_are_left_out_and_warnings_stay() {
        let problems = "note: a\nwarning: b. Lost:\n  - c\nnote: d\n".to_owned();
        let less = Quiet { quiet: true }.less(problems.clone());
        assert_eq!(less, "warning: b. Lost:\n  - c\n");
        assert_eq!(Quiet { quiet: false }.less(problems.clone()), problems);
    }
}
