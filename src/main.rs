//! The one place where an outcome becomes an exit code.

#[cfg(all(unix, feature = "terminal"))]
use std::io::Write as _;
use std::process::ExitCode;

use clap::Parser as _;
use tmam_replay::cli::Cli;
use tmam_replay::core::legible::typed_on_one_line;
use tmam_replay::io::output::show;

fn main() -> ExitCode {
    #[cfg(all(unix, feature = "terminal"))]
    if let Err(error) = tmam_replay::io::interruption::clean_up() {
        let _ = writeln!(
            std::io::stderr(),
            "warning: Ctrl-C will leave hidden files: {error}"
        );
    }
    let ended = match Cli::try_parse() {
        Ok(cli) => cli.run(),
        Err(told) => Cli::told(&told),
    };
    match ended {
        Ok(exit) => ExitCode::from(exit.code()),
        Err(error) => {
            let typed = std::env::args_os();
            let typed = typed.map(|argument| argument.to_string_lossy().into_owned());
            let text = typed_on_one_line(&format!("error: {error}\n"), typed);
            // Who does not read standard error misses the reason, not that it failed.
            let _ = show(&text, true);
            ExitCode::from(error.exit().code())
        }
    }
}
