//! The command line: one file per subcommand, none with logic of its own.

mod calibrate;
mod check;
#[cfg(feature = "terminal")]
mod completions;
mod config;
mod diff;
pub mod error;
mod evaluate;
mod explain;
mod info;
#[cfg(feature = "terminal")]
mod man;
mod named;
mod parameters;
mod quiet;
mod replay;
mod report;
mod reproduce;
mod simulate;
mod sweep;

use std::io::{self, Write as _};

use clap::{ArgAction, Parser, Subcommand};

use crate::cli::error::Error;
use crate::core::exit::Exit;
use crate::core::legible::{legible, typed_on_one_line};
use crate::core::tool::LONG_VERSION;
use crate::io::output::OutputError;

/// Look into what a sonar map was made of.
///
/// Replays an MCAP log of sonar ranges and odometry through TMAM, the three measurements
/// association model, and records every arc, label and feature for the Rerun viewer.
#[derive(Debug, Parser)]
#[command(name = "tmam", version, long_version = LONG_VERSION.as_str(), max_term_width = 100, disable_help_flag = true)]
pub struct Cli {
    /// Print help
    #[arg(short, long, global = true, display_order = 100, action = ArgAction::HelpShort)]
    help: Option<bool>,
    /// Print help with every parameter and more words
    #[arg(long, global = true, display_order = 101, action = ArgAction::HelpLong)]
    help_all: Option<bool>,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Replay(Box<replay::Args>),
    Info(Box<info::Args>),
    Evaluate(Box<evaluate::Args>),
    #[command(
        mut_arg("sensor", |arg| arg
            .help("The arc is of a sonar with such a name; every sonar is replayed")),
        mut_arg("method", |arg| arg.hide(true))
    )]
    Explain(Box<explain::Args>),
    #[command(mut_arg("method", |arg| arg.hide(true)))]
    Calibrate(Box<calibrate::Args>),
    #[command(
        mut_arg("rule", |arg| arg.hide_short_help(true)),
        mut_arg("sensor", |arg| arg.hide_short_help(true))
    )]
    Check(Box<check::Args>),
    Diff(Box<diff::Args>),
    Report(Box<report::Args>),
    Reproduce(Box<reproduce::Args>),
    Sweep(Box<sweep::Args>),
    Simulate(Box<simulate::Args>),
    Config(Box<config::Args>),
    #[cfg(feature = "terminal")]
    Completions(completions::Args),
    #[cfg(feature = "terminal")]
    Man(man::Args),
}

impl Cli {
    /// Says what the command line asks for or what is wrong with it: help, the version, an error.
    ///
    /// # Errors
    /// When standard output cannot be written.
    pub fn told(said: &clap::Error) -> Result<Exit, Error> {
        let printed = print(said).and_then(|()| io::stdout().flush());
        match printed {
            Err(source) if source.kind() != io::ErrorKind::BrokenPipe && !said.use_stderr() => {
                let path = "standard output".into();
                Err(OutputError { path, source }.into())
            }
            _ if said.use_stderr() => Ok(Exit::Unusable),
            _ => Ok(Exit::Done),
        }
    }

    /// Runs the command; how it ended.
    ///
    /// # Errors
    /// What went wrong; [`Error::exit`] says how that ends.
    pub fn run(self) -> Result<Exit, Error> {
        match self.command {
            Command::Replay(args) => args.run(),
            Command::Info(args) => args.run(),
            Command::Evaluate(args) => args.run(),
            Command::Explain(args) => args.run(),
            Command::Calibrate(args) => args.run(),
            Command::Check(args) => args.run(),
            Command::Diff(args) => args.run(),
            Command::Report(args) => args.run(),
            Command::Reproduce(args) => args.run(),
            Command::Sweep(args) => args.run(),
            Command::Simulate(args) => args.run(),
            Command::Config(args) => args.run(),
            #[cfg(feature = "terminal")]
            Command::Completions(args) => args.run(<Self as clap::CommandFactory>::command()),
            #[cfg(feature = "terminal")]
            Command::Man(args) => args.run(<Self as clap::CommandFactory>::command()),
        }
    }
}

/// Prints what clap says, but without what was typed that would not be shown as it is.
fn print(said: &clap::Error) -> io::Result<()> {
    if !said.use_stderr() {
        return said.print();
    }
    let text = said.to_string();
    let typed = std::env::args_os().map(|argument| argument.to_string_lossy().into_owned());
    let safe = typed_on_one_line(&text, typed);
    let safe = legible(&safe);
    match safe == text {
        true => said.print(),
        false => io::stderr().write_all(safe.as_bytes()),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::*;

    /// Lines of a screen, and columns of a page.
    const SCREEN: (usize, usize) = (40, 100);

    #[test]
    fn help_fits_a_screen_and_all_of_it_is_told_by_help_all() {
        let mut tmam = Cli::command().term_width(SCREEN.1);
        tmam.build();
        let mut long = Vec::new();
        for command in tmam.get_subcommands_mut() {
            let name = command.get_name().to_owned();
            let help = command.render_help().to_string();
            if help.lines().count() > SCREEN.0 {
                long.push(format!("{name}: {} lines\n{help}", help.lines().count()));
            }
            let all = command.render_long_help().to_string();
            let told = |flag: &str| all.contains(&format!("--{flag}"));
            let shown = command.get_arguments().filter(|arg| !arg.is_hide_set());
            for flag in shown.filter_map(clap::Arg::get_long) {
                assert!(told(flag), "{name}: --{flag}");
            }
        }
        assert!(long.is_empty(), "{}", long.join("\n"));
    }
}
