//! `tmam config`

use super::parameters::Parameters;
use crate::cli::error::Error;
use crate::core::exit::Exit;
use crate::io::config::render::render;
use crate::io::output::Output;
use std::io::Write as _;
use std::path::Path;

/// Print the effective configuration as TOML
///
/// Every key with its value and unit: the defaults, then the file given with --config, then flags.
/// Redirect it into a file to start one of your own.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct Args {
    #[command(flatten)]
    parameters: Parameters,
}

impl Args {
    pub fn run(self) -> Result<Exit, Error> {
        let text = render(&self.parameters.configuration()?);
        Output::whole(Path::new("-"), |out| out.write_all(text.as_bytes()))?;
        Ok(Exit::Done)
    }
}
