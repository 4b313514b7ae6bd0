//! Ctrl-C, and being told to stop: what is half written does not stay.

use std::io;
use std::sync::Arc;
use std::thread;

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::flag;
use signal_hook::iterator::Signals;
use signal_hook::low_level::emulate_default_handler;

use crate::io::output::remove_unfinished;

/// From now on the process removes its unfinished outputs before it ends by one of these signals.
///
/// # Errors
/// When the system refuses the handler.
pub fn clean_up() -> io::Result<()> {
    // A file that grows beyond the limit of the process is then an error like any other.
    flag::register(SIGXFSZ, Arc::default())?;
    let mut signals = Signals::new([SIGHUP, SIGINT, SIGTERM])?;
    thread::Builder::new()
        .name("signals".to_owned())
        .spawn(move || {
            for signal in signals.forever() {
                remove_unfinished();
                let _ = emulate_default_handler(signal);
            }
        })?;
    Ok(())
}
