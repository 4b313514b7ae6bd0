//! What the end-to-end tests share: running the binary, and logs made from the sample logs.

use std::collections::BTreeSet;
use std::fs;
use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

use serde_json::Value;
use tempfile::TempDir;

/// The binary.
pub const TMAM: &str = env!("CARGO_BIN_EXE_tmam");

/// A sample log of the repository.
pub fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("sample_logs")
        .join(name)
}

/// A log that is not part of the repository; says so and gives `None` where it is absent.
pub fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../shared/logs")
        .join(name);
    if path.exists() {
        return Some(path);
    }
    // Written past the test harness, which hides what passing tests print.
    let _ = writeln!(
        std::io::stderr(),
        "SKIPPED: {name} is not here; this test needs the shared logs"
    );
    None
}

/// A finished run of the binary.
pub struct Run {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

/// A directory to run the binary in.
pub struct Bench(TempDir);

impl Bench {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Puts a file there.
    pub fn put(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        fs::write(self.path(name), bytes).unwrap();
        self.path(name)
    }

    /// Runs `tmam` there; arguments are separated by blanks, `{}` stands for `log`.
    pub fn tmam(&self, log: &Path, arguments: &str) -> Run {
        let arguments = arguments.split_whitespace().map(|word| match word {
            "{}" => log.as_os_str().to_owned(),
            word => word.into(),
        });
        self.run(Command::new(TMAM).args(arguments))
    }

    /// Runs a line of a shell there, with `tmam` on the path.
    pub fn sh(&self, line: &str) -> Run {
        let folder = Path::new(TMAM).parent().unwrap();
        let before = std::env::var_os("PATH").unwrap();
        let folders = [folder.to_owned()]
            .into_iter()
            .chain(std::env::split_paths(&before));
        let path = std::env::join_paths(folders).unwrap();
        self.run(Command::new("sh").args(["-c", line]).env("PATH", path))
    }

    /// As on the machine of a person, whatever the machine that runs the tests is.
    fn run(&self, command: &mut Command) -> Run {
        command
            .env_remove("CI")
            .env_remove("GITHUB_ACTIONS")
            .env_remove("GITHUB_STEP_SUMMARY");
        let output = command.current_dir(self.0.path()).output().unwrap();
        Run {
            code: output.status.code().expect("ended by itself"),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    /// Names of the files there.
    pub fn files(&self) -> BTreeSet<String> {
        fs::read_dir(self.0.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect()
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap()
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.bytes(name)).unwrap()
    }

    pub fn json_lines(&self, name: &str) -> Vec<Value> {
        String::from_utf8(self.bytes(name))
            .unwrap()
            .lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .collect()
    }
}

/// One message of a log that is rewritten.
pub struct Message {
    pub topic: String,
    pub log_time: u64,
    pub data: Vec<u8>,
    /// Messages of a higher rank come later in the file.
    pub rank: u8,
}

impl Message {
    /// Moves the stamp at the front of a CDR message with a header.
    pub fn shift_stamp(&mut self, seconds: i32) {
        let old = i32::from_le_bytes(self.data[4..8].try_into().unwrap());
        self.data[4..8].copy_from_slice(&(old + seconds).to_le_bytes());
    }
}

/// Rewrites a log, message by message: each gives any number of messages, which are then put in the
/// order of their ranks.
pub fn rewrite(
    log: &Path,
    options: mcap::WriteOptions,
    change: impl Fn(Message) -> Vec<Message>,
) -> Vec<u8> {
    rewrite_with(log, options, true, change)
}

/// The log without a word of what type its messages are.
pub fn untyped(log: &Path) -> Vec<u8> {
    rewrite_with(log, mcap::WriteOptions::new(), false, |message| {
        vec![message]
    })
}

fn rewrite_with(
    log: &Path,
    options: mcap::WriteOptions,
    has_schemas: bool,
    change: impl Fn(Message) -> Vec<Message>,
) -> Vec<u8> {
    let bytes = fs::read(log).unwrap();
    let mut messages = Vec::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let changed = change(Message {
            topic: message.channel.topic.clone(),
            log_time: message.log_time,
            data: message.data.to_vec(),
            rank: 0,
        });
        messages.extend(
            changed
                .into_iter()
                .map(|one| (Arc::clone(&message.channel), one)),
        );
    }
    messages.sort_by_key(|(_, message)| message.rank);

    let mut writer = options.create(Cursor::new(Vec::new())).unwrap();
    for (original, message) in messages {
        let schema = original.schema.as_ref().filter(|_| has_schemas);
        let schema = schema.map_or(0, |schema| {
            writer
                .add_schema(&schema.name, &schema.encoding, &schema.data)
                .unwrap()
        });
        let channel_id = writer
            .add_channel(
                schema,
                &message.topic,
                &original.message_encoding,
                &original.metadata,
            )
            .unwrap();
        let header = mcap::records::MessageHeader {
            channel_id,
            sequence: 0,
            log_time: message.log_time,
            publish_time: message.log_time,
        };
        writer
            .write_to_known_channel(&header, &message.data)
            .unwrap();
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

/// The log without some topics.
pub fn without(log: &Path, topics: &[&str]) -> Vec<u8> {
    rewrite(log, mcap::WriteOptions::new(), |message| {
        if topics.iter().any(|topic| message.topic.starts_with(topic)) {
            Vec::new()
        } else {
            vec![message]
        }
    })
}

/// The log as ROS 1 would have recorded it: without alignment, without the variance of ranges, and
/// with headers that count.
pub fn ros1(log: &Path) -> Vec<u8> {
    let bytes = fs::read(log).unwrap();
    let mut writer = mcap::Writer::new(Cursor::new(Vec::new())).unwrap();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let topic = &message.channel.topic;
        // One letter a field: header, text, count, byte, float, double.
        let (name, fields) = match topic.split('/').nth(1).unwrap() {
            "sonar" => ("sensor_msgs/Range", format!("hb{}", "f".repeat(4))),
            "odom" => (
                "nav_msgs/Odometry",
                format!("hs{}", "d".repeat(7 + 36 + 6 + 36)),
            ),
            "tf" | "tf_static" => ("tf2_msgs/TFMessage", format!("n{}", "hsddddddd".repeat(64))),
            _ => continue,
        };
        let definition = &message.channel.schema.as_ref().unwrap().data;
        let definition = String::from_utf8_lossy(definition)
            .replace("builtin_interfaces/Time stamp", "uint32 seq\ntime stamp")
            .replace("float32 variance", "");
        let schema = writer
            .add_schema(name, "ros1msg", definition.as_bytes())
            .unwrap();
        let channel_id = writer
            .add_channel(schema, topic, "ros1", &Default::default())
            .unwrap();
        let header = mcap::records::MessageHeader {
            channel_id,
            sequence: 0,
            log_time: message.log_time,
            publish_time: message.publish_time,
        };
        writer
            .write_to_known_channel(&header, &packed(&message.data, &fields))
            .unwrap();
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

/// The fields of a CDR message, until it ends, as ROS 1 writes them.
fn packed(message: &[u8], fields: &str) -> Vec<u8> {
    let (mut at, mut packed) = (4, Vec::new());
    for field in fields.chars() {
        if at + 4 > message.len() && field != 'b' {
            break;
        }
        if field == 'h' {
            packed.extend([0; 4]);
        }
        // Sizes of what stands there, with a text's own length.
        let sizes = match field {
            'h' => vec![4, 4, 0],
            's' => vec![0],
            'b' => vec![1],
            'd' => vec![8],
            _ => vec![4],
        };
        for size in sizes {
            if size > 0 {
                at = 4 + (at - 4_usize).next_multiple_of(size);
                packed.extend(&message[at..at + size]);
                at += size;
            } else {
                at = at.next_multiple_of(4);
                let length = u32::from_le_bytes(message[at..at + 4].try_into().unwrap());
                // Without the zero at its end.
                packed.extend((length - 1).to_le_bytes());
                packed.extend(&message[at + 4..at + 3 + length as usize]);
                at += 4 + length as usize;
            }
        }
    }
    packed
}
