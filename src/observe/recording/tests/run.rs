//! A run through the room, recorded and read back.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use rerun::StoreKind;
use rerun::external::re_log_encoding::DecoderApp;
use rerun::log::{Chunk, LogMsg};

use crate::core::config::Config;
use crate::core::event::{Events, Sonar, SonarId};
use crate::core::frames::{Echo, Entry, Frame};
use crate::core::geometry::{Pose2, Vec2, angle_between, direction, unit};
use crate::core::observer::{Observer as _, Setting, Source};
use crate::core::tmam::Tmam;
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::step::Closure;
use crate::observe::drawing::Overlay;
use crate::observe::recording::Recording;

/// The room of the paper's Table I.
const ROOM: [[f64; 2]; 6] = [
    [0.0, 0.0],
    [4.0, 0.0],
    [4.0, 2.0],
    [8.0, 2.0],
    [8.0, 5.0],
    [0.0, 5.0],
];
const BEAM: f64 = 22.5 / 360.0 * TAU;

/// Nearest echo inside the beam: the foot of a perpendicular on a wall, or a vertex.
fn echo(sensor: &Pose2) -> Option<f64> {
    let from = sensor.position();
    let corners = ROOM.map(|[x, y]| Vec2::new(x, y));
    let feet = corners
        .iter()
        .zip(corners.iter().cycle().skip(1))
        .filter_map(|(a, b)| {
            let along = b - a;
            let t = (from - a).dot(&along) / along.norm_squared();
            (0.0..=1.0).contains(&t).then(|| a + along * t)
        });
    feet.chain(corners.iter().copied())
        .map(|at| at - from)
        .filter(|to| angle_between(direction(*to), sensor.yaw) <= BEAM / 2.0)
        .map(|to| to.norm())
        .min_by(f64::total_cmp)
}

pub fn ring(count: u16) -> Vec<Sonar> {
    (0..count)
        .map(|i| {
            let yaw = TAU * f64::from(i) / f64::from(count);
            let at = unit(yaw) * 0.2;
            Sonar {
                name: format!("sonar_{i:02}"),
                topic: format!("/sonar/{i}"),
                robot_from_sensor: Pose2::new(at.x, at.y, yaw),
            }
        })
        .collect()
}

/// Steps of 10 cm up and down the room, with a little noise that is the same every time.
pub fn drive(sonars: &[Sonar], count: u32, silent_after: Option<(u16, u32)>) -> Vec<Frame> {
    let mut noise = 1_u64;
    (0..count)
        .map(|index| {
            let s = f64::from(index) * 0.1 % 12.0;
            let (x, yaw) = if s < 6.0 {
                (1.0 + s, 0.0)
            } else {
                (13.0 - s, TAU / 2.0)
            };
            let pose = Pose2::new(x, 3.2, yaw);
            let stamp_ns = 1_700_000_000_000_000_000 + i64::from(index) * 300_000_000;
            let entries = sonars
                .iter()
                .zip(0..)
                .filter(|(_, id)| silent_after.is_none_or(|(s, n)| *id != s || index < n))
                .map(|(sonar, id)| {
                    noise = noise
                        .wrapping_mul(6_364_136_223_846_793_005)
                        .wrapping_add(1);
                    let error = ((noise >> 40) as f64 / f64::from(1 << 24) - 0.5) * 0.002;
                    let world_from_sensor = pose.compose(&sonar.robot_from_sensor);
                    Entry {
                        sonar: SonarId(id),
                        stamp_ns,
                        world_from_sensor,
                        pose_variance: 0.0,
                        beam_width: BEAM,
                        echo: echo(&world_from_sensor).map(|range| Echo {
                            range: range + error,
                            variance: 0.0,
                        }),
                    }
                })
                .collect();
            Frame {
                index,
                stamp_ns,
                world_from_robot: pose,
                correction: None,
                entries,
            }
        })
        .collect()
}

pub fn record(sonars: &[Sonar], frames: &[Frame]) -> (Vec<u8>, Vec<ArcReport>) {
    record_under(Overlay::default(), sonars, frames)
}

pub fn record_under(
    overlay: Overlay,
    sonars: &[Sonar],
    frames: &[Frame],
) -> (Vec<u8>, Vec<ArcReport>) {
    record_all(overlay, &[], sonars, frames)
}

/// The same of a run at whose end these loop closures are known.
pub fn record_closing(
    closures: &[Closure],
    sonars: &[Sonar],
    frames: &[Frame],
) -> (Vec<u8>, Vec<ArcReport>) {
    record_all(Overlay::default(), closures, sonars, frames)
}

fn record_all(
    overlay: Overlay,
    closures: &[Closure],
    sonars: &[Sonar],
    frames: &[Frame],
) -> (Vec<u8>, Vec<ArcReport>) {
    let config = Config::default();
    let identified = (&config, "e3b0c442");
    record_identified(identified, overlay, closures, sonars, frames)
}

/// The same under a configuration, of a log whose events have such a digest.
pub fn record_as(
    config: &Config,
    events_sha256: &str,
    sonars: &[Sonar],
    frames: &[Frame],
) -> Vec<u8> {
    let identified = (config, events_sha256);
    record_identified(identified, Overlay::default(), &[], sonars, frames).0
}

fn record_identified(
    (config, events_sha256): (&Config, &str),
    overlay: Overlay,
    closures: &[Closure],
    sonars: &[Sonar],
    frames: &[Frame],
) -> (Vec<u8>, Vec<ArcReport>) {
    let source = Source {
        file: "room.mcap".to_owned(),
        messages: 12,
        start_ns: frames.first().map_or(0, |frame| frame.stamp_ns),
        end_ns: frames.last().map_or(0, |frame| frame.stamp_ns),
        complete: true,
        lost: Vec::new(),
        notes: Vec::new(),
    };
    let setting = Setting {
        sonars,
        config,
        source: &source,
        events: &Events::default(),
        events_sha256,
        origin_ns: source.start_ns,
        start: Vec2::zeros(),
    };
    let mut tmam = Tmam::new(config);
    let mut bytes = Vec::new();
    let mut recording = Recording::new(Some(&mut bytes), None, setting, overlay).unwrap();
    for frame in frames {
        let step = tmam.step(frame);
        recording.frame(frame, &step).unwrap();
    }
    let mut step = tmam.finish();
    step.closures.extend(closures);
    recording.finish(&step).unwrap();
    recording.close(None).unwrap();
    (bytes, step.reports.to_vec())
}

/// The chunks of a file by entity, in file order, of one kind of store.
pub fn chunks(bytes: &[u8], kind: StoreKind) -> BTreeMap<String, Vec<Chunk>> {
    let mut found = BTreeMap::<String, Vec<Chunk>>::new();
    for message in DecoderApp::decode_lazy(bytes) {
        if let LogMsg::ArrowMsg(store, message) = message.unwrap()
            && store.kind() == kind
        {
            let chunk = Chunk::from_arrow_msg(&message).unwrap();
            let entity = chunk.entity_path().to_string();
            found.entry(entity).or_default().push(chunk);
        }
    }
    found
}
