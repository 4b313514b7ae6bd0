//! `tmam reproduce`

use std::io::Write as _;
use std::path::PathBuf;

use crate::cli::error::Error;
use crate::core::exit::Exit;
use crate::io::output::{Output, make_room, print};
use crate::io::outputs::Settled;
use crate::observe::report::written;
use crate::tools::reproduce::{OF_THE_DOCS, Reproduction, page};

/// Make the paper's experiment again: its room, its Table I and its figures 5 and 6
///
/// Simulates the room, replays it under both rules, and prints the table with the paper's estimates, ours and the
/// actual values, the counts beside the paper's, and at which noise and parameters the paper's rule comes
/// nearest to these.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "\
Examples:
  tmam reproduce                                  the page
  tmam reproduce -o docs                          docs/table1.md, docs/figure5.svg, docs/figure6.svg
  tmam reproduce --noise 0.01 --seed 7"
)]
pub struct Args {
    /// Write table1.md, figure5.svg and figure6.svg into this folder [default: print the page]
    #[arg(short, long = "output", value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Standard deviation of a range, metres
    #[arg(long, value_name = "M", default_value_t = OF_THE_DOCS.0)]
    noise: f64,
    /// Chooses the noise
    #[arg(long, value_name = "N", default_value_t = OF_THE_DOCS.1)]
    seed: u64,
}

impl Args {
    pub fn run(self) -> Result<Exit, Error> {
        let reproduction = Reproduction::new(self.noise, self.seed)?;
        let Some(folder) = self.output else {
            print(&page(&reproduction))?;
            return Ok(Exit::Done);
        };
        let [five, six] = reproduction.figures();
        let files = [
            ("table1.md", page(&reproduction)),
            ("figure5.svg", five),
            ("figure6.svg", six),
        ];
        let mut outputs = Vec::new();
        for (name, text) in files {
            let file = folder.join(name);
            make_room(&file)?;
            let mut out = Output::create(&file)?;
            out.write_all(text.as_bytes())
                .map_err(|source| out.failed(source))?;
            outputs.push(out);
        }
        let outputs = Settled::new(outputs)?;
        print(&written(&outputs.files()))?;
        outputs.commit()?;
        Ok(Exit::Done)
    }
}
