//! The one place where an outcome becomes an exit code.

use std::io::Write as _;
use std::process::ExitCode;

use clap::Parser as _;
use tmam_replay::cli::Cli;
use tmam_replay::core::legible::{legible, typed_on_one_line};

fn main() -> ExitCode {
    #[cfg(all(unix, feature = "terminal"))]
    if let Err(error) = tmam_replay::io::interruption::clean_up() {
        let _ = writeln!(
            std::io::stderr(),
            "warning: Ctrl-C will leave hidden files: {error}"
        );
    }
    match Cli::parse().run() {
        Ok(exit) => ExitCode::from(exit.code()),
        Err(error) => {
            let typed = std::env::args_os();
            let typed = typed.map(|argument| argument.to_string_lossy().into_owned());
            let text = typed_on_one_line(&format!("error: {error}"), typed);
            let _ = writeln!(std::io::stderr(), "{}", legible(&text));
            ExitCode::from(error.exit().code())
        }
    }
}
