//! The one place where an outcome becomes an exit code.

use std::io::Write as _;
use std::process::ExitCode;

use clap::Parser as _;
use tmam_replay::cli::Cli;
use tmam_replay::legible::legible;

fn main() -> ExitCode {
    match Cli::parse().run() {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            let text = format!("error: {error}");
            let _ = writeln!(std::io::stderr(), "{}", legible(&text));
            ExitCode::from(error.exit_code())
        }
    }
}
