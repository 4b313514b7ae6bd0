//! The same messages to an open viewer, while they are made.
//!
//! Everything here ends in bounded time: a viewer that is not there, does not read, or goes away is
//! an error, never a wait without end.

use std::io;
use std::net::{TcpStream, ToSocketAddrs as _};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use rerun::external::re_grpc_client::write::{Client, ClientConnectionState, Options};
use rerun::external::re_log_types::LogMsg;
use rerun::external::re_uri::ProxyUri;

use crate::observe::viewer::Error;

/// How long a viewer that should be there may take to answer.
const ANSWER: Duration = Duration::from_secs(5);

/// How long one that was just started may take.
const START: Duration = Duration::from_secs(30);

/// How long a viewer may take over what it was sent.
const PATIENCE: Duration = Duration::from_secs(20);

/// Messages after which the viewer must have taken all: fewer than the client holds before it blocks.
const UNCONFIRMED: usize = 32;

/// A connection to an open viewer.
pub struct Live {
    // Taken at the end.
    client: Option<Client>,
    url: String,
    unconfirmed: usize,
}

impl Live {
    /// Connects to the viewer at `url`; starts one there first, if nobody listens and `spawn` says so.
    ///
    /// # Errors
    /// When no viewer answers within some seconds.
    pub fn connect(url: &str, spawn: bool) -> Result<Self, Error> {
        let uri: ProxyUri = url.parse().map_err(|problem| Error::Url {
            url: url.to_owned(),
            problem: format!("{problem}"),
        })?;
        let mut viewer = if spawn && !listens(&uri) {
            Some(start(&uri)?)
        } else {
            None
        };
        let options = Options {
            connect_timeout_on_flush: Duration::ZERO,
            ..Options::default()
        };
        let patience = if viewer.is_some() { START } else { ANSWER };
        let live = Self {
            client: Some(Client::new(uri, options)),
            url: url.to_owned(),
            unconfirmed: 0,
        };
        let begun = Instant::now();
        while !live.is_connected() {
            if let Some(status) = viewer.as_mut().and_then(|child| child.try_wait().ok()?) {
                return Err(Error::Ended {
                    status: status.to_string(),
                });
            }
            if begun.elapsed() > patience {
                return Err(Error::NotThere {
                    url: url.to_owned(),
                });
            }
            thread::sleep(Duration::from_millis(20));
        }
        Ok(live)
    }

    fn is_connected(&self) -> bool {
        let status = self.client.as_ref().map(Client::status);
        matches!(status, Some(ClientConnectionState::Connected))
    }

    /// Sends a message.
    ///
    /// # Errors
    /// When the viewer has gone away or does not take what it is sent.
    pub fn send(&mut self, message: LogMsg) -> Result<(), Error> {
        let Some(client) = &self.client else {
            return Ok(());
        };
        if !self.is_connected() {
            return Err(self.gone("the connection is closed"));
        }
        // Never blocks: fewer messages wait than the client has room for.
        client.send_blocking(message);
        self.unconfirmed += 1;
        if self.unconfirmed >= UNCONFIRMED {
            self.confirm()?;
        }
        Ok(())
    }

    /// Sends what still waits and closes the connection.
    ///
    /// # Errors
    /// When the viewer has not taken everything.
    pub fn close(mut self) -> Result<(), Error> {
        self.confirm()?;
        let Some(client) = self.client.take() else {
            return Ok(());
        };
        // The client waits for the viewer without end; this does not.
        let (done, ended) = mpsc::channel();
        thread::spawn(move || {
            drop(client);
            let _ = done.send(());
        });
        let in_time = ended.recv_timeout(PATIENCE);
        in_time.map_err(|_| self.gone("it does not take what it is sent"))
    }

    fn confirm(&mut self) -> Result<(), Error> {
        self.unconfirmed = 0;
        let Some(client) = &self.client else {
            return Ok(());
        };
        let flushed = client.flush_blocking(PATIENCE);
        flushed.map_err(|problem| self.gone(&problem.to_string()))
    }

    fn gone(&self, problem: &str) -> Error {
        Error::Gone {
            url: self.url.clone(),
            problem: problem.to_owned(),
        }
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        // The client's own end waits for the viewer, and this one no longer matters.
        if let Some(client) = self.client.take() {
            thread::spawn(move || drop(client));
        }
    }
}

/// Whether anybody listens at the address.
fn listens(uri: &ProxyUri) -> bool {
    let place = (uri.origin.host.to_string(), uri.origin.port);
    let mut addresses = place.to_socket_addrs().into_iter().flatten();
    addresses.any(|address| TcpStream::connect_timeout(&address, Duration::from_secs(1)).is_ok())
}

/// Starts the viewer that is installed, to outlive this program; it keeps quiet, since what is
/// written to standard output may be a file.
fn start(uri: &ProxyUri) -> Result<Child, Error> {
    let mut command = Command::new("rerun");
    command
        .arg("--port")
        .arg(uri.origin.port.to_string())
        .args(["--expect-data-soon", "--hide-welcome-screen"])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    // What interrupts this program need not end the viewer.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command.spawn().map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => Error::NotInstalled,
        _ => Error::Spawn(error),
    })
}
