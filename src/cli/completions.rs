//! `tmam completions`

use clap::CommandFactory as _;
use clap_complete::Shell;

use crate::cli::Cli;
use crate::cli::error::Error;
use crate::core::exit::Exit;
use crate::io::output::print;

/// Print what a shell needs to complete commands and flags
///
/// bash: `tmam completions bash > ~/.local/share/bash-completion/completions/tmam`
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The shell
    shell: Shell,
}

impl Args {
    pub fn run(self) -> Result<Exit, Error> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::command(), "tmam", &mut script);
        print(&String::from_utf8_lossy(&script))?;
        Ok(Exit::Done)
    }
}
