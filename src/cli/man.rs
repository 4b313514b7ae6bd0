//! `tmam man`

use std::path::PathBuf;

use clap::CommandFactory as _;
use clap_mangen::Man;

use crate::cli::Cli;
use crate::cli::error::Error;
use crate::core::exit::Exit;
use crate::io::output::{Output, make_room};

/// Write the man pages, one for each command
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  tmam man -o ~/.local/share/man/man1 && man tmam-replay")]
pub struct Args {
    /// The folder in which they go
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
}

impl Args {
    pub fn run(self) -> Result<Exit, Error> {
        let mut tmam = Cli::command();
        // Subcommands are called `tmam-replay` and have the help flags only once the whole is built.
        tmam.build();
        let commands = tmam.get_subcommands().filter(|c| c.get_name() != "help");
        for command in std::iter::once(&tmam).chain(commands) {
            let name = command.get_display_name().unwrap_or("tmam").to_owned();
            let page = self.output.join(format!("{name}.1"));
            make_room(&page)?;
            Output::whole(&page, |out| Man::new(command.clone()).render(out))?;
        }
        Ok(Exit::Done)
    }
}
