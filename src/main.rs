//! The command line: turns an outcome into an exit code.

use std::process::ExitCode;

use clap::Parser;
use tmam_replay::cli::simulate;

#[derive(Parser)]
#[command(version, about)]
enum Command {
    Simulate(simulate::Args),
}

fn main() -> ExitCode {
    let outcome = match Command::parse() {
        Command::Simulate(args) => simulate::run(args),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("tmam: {error}");
            ExitCode::from(2)
        }
    }
}
