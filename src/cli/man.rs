//! `tmam man`

use std::io::{self, Write as _};
use std::path::PathBuf;

use clap::Command;
use clap_mangen::Man;

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
    pub fn run(self, mut tmam: Command) -> Result<Exit, Error> {
        // Subcommands are called `tmam-replay` and have the help flags only once the whole is built.
        tmam.build();
        let commands = tmam.get_subcommands().filter(|c| c.get_name() != "help");
        for command in std::iter::once(&tmam).chain(commands) {
            let name = command.get_display_name().unwrap_or("tmam").to_owned();
            let page = self.output.join(format!("{name}.1"));
            make_room(&page)?;
            let mut command = command.clone();
            let usage = command.render_usage().to_string();
            let has_version = command.get_version().is_some();
            Output::whole(&page, |out| {
                let man = Man::new(command);
                page_of(&man, &usage, out)?;
                match has_version {
                    true => man.render_version_section(out),
                    false => Ok(()),
                }
            })?;
        }
        Ok(Exit::Done)
    }
}

/// A page with a synopsis of its own, which names what flags take: the crate's names flags alone.
fn page_of(man: &Man, usage: &str, mut out: &mut Output) -> io::Result<()> {
    man.render_title(&mut out)?;
    man.render_name_section(&mut out)?;
    let usage = usage.trim_start_matches("Usage: ").replace('-', r"\-");
    let lines = usage.lines().map(str::trim).collect::<Vec<_>>();
    writeln!(out, ".SH SYNOPSIS\n{}", lines.join("\n.br\n"))?;
    man.render_description_section(&mut out)?;
    man.render_options_section(&mut out)?;
    man.render_subcommands_section(&mut out)?;
    man.render_extra_section(&mut out)
}
