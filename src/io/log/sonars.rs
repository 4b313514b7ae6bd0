//! The sonars: their names, mounts and beams, and their readings in order.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::error::{LogError, MissingMount};
use super::stamps::Clock;
use super::traits::{Contradicted, MountTraits};
use super::transforms::{Mount, NoMount, TransformTree};
use crate::core::config::{BeamAxis, Config, MountsLie, SonarOverride};
use crate::core::event::{RangeReading, Readings, Sonar, SonarId};
use crate::core::geometry::{Pose2, direction};
use crate::core::pattern::is_chosen;
use crate::core::wording::{counted, few, plural};

/// What tells one sonar from another.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct SourceKey {
    /// The topic its readings come on.
    pub topic: String,
    /// Its frame.
    pub frame: String,
    /// Its place in a message that holds several.
    pub element: Option<usize>,
    /// Which of the forms that its topic's messages have.
    pub form: usize,
}

/// A sonar of which only the messages are known.
#[derive(Debug, Clone)]
pub struct Source {
    /// What tells it from the others.
    pub key: SourceKey,
    /// The beam in its first message: its axis is x.
    pub frame_from_beam: Isometry3<f64>,
    /// Whether a later message has the beam elsewhere.
    pub turned: bool,
    /// Beam width in its first message that has one, radians.
    beam_width: Option<f64>,
    /// What that is where neither messages nor configuration say it, radians.
    likely_beam_width: Option<f64>,
    /// When its messages were stamped and recorded.
    pub clock: Clock,
    pub readings: u64,
    /// Whether its messages say that it measures with light.
    pub infrared: bool,
    /// Whether the angles of its scans were in degrees.
    pub in_degrees: bool,
}

impl Source {
    /// A sonar before its first reading.
    pub fn new(key: &SourceKey, frame_from_beam: Isometry3<f64>) -> Self {
        Self {
            key: key.clone(),
            frame_from_beam,
            turned: false,
            beam_width: None,
            likely_beam_width: None,
            clock: Clock::default(),
            readings: 0,
            infrared: false,
            in_degrees: false,
        }
    }

    /// Takes the same sonar in messages of another form.
    pub fn join(&mut self, other: &Self) {
        self.turned |= other.turned || self.frame_from_beam != other.frame_from_beam;
        self.beam_width = self.beam_width.or(other.beam_width);
        self.likely_beam_width = self.likely_beam_width.or(other.likely_beam_width);
        self.readings += other.readings;
    }

    /// Takes what a message says of the beam's width, radians; 0 or NaN for nothing.
    pub fn learn(&mut self, beam_width: f64, likely_beam_width: f64) {
        self.beam_width = self.beam_width.or(usable(beam_width));
        self.likely_beam_width = self.likely_beam_width.or(usable(likely_beam_width));
    }
}

/// A sonar's beam is narrower than this, radians.
pub const WIDEST_BEAM: f64 = std::f64::consts::FRAC_PI_2;

/// Whether a beam is wider than any sonar's, as one that a driver gives in degrees.
fn is_senseless(width: f64) -> bool {
    width >= WIDEST_BEAM
}

/// A beam width that is one, radians.
fn usable(width: f64) -> Option<f64> {
    (width > 0.0 && width.is_finite()).then_some(width)
}

/// Whether the limits of a reading stand in each other's place.
fn are_swapped(reading: &RangeReading) -> bool {
    0.0 < reading.max_range
        && reading.max_range < reading.min_range
        && reading.min_range.is_finite()
}

/// What sonars are placed by.
#[derive(Debug, Clone, Copy)]
pub struct Placing<'a> {
    /// Topic of the odometry.
    pub odometry_topic: &'a str,
    /// Frame that the odometry is in.
    pub world_frame: &'a str,
    /// Frame that the odometry moves; empty where it does not say it.
    pub robot_frame: &'a str,
    pub transforms: &'a TransformTree,
    /// All frames of the transforms.
    pub frames: &'a Arc<[String]>,
    /// What the user knows of sonars.
    pub config: &'a Config,
}

/// Sonars in their places.
#[derive(Debug)]
pub struct Placed {
    /// By name.
    pub sonars: Vec<Sonar>,
    /// What is said of their mounts besides.
    pub traits: Vec<MountTraits>,
    /// By stamp, ties by sonar.
    pub readings: Readings,
    /// What is missing of the sonars that cannot be used, while others can, by name.
    pub left_out: Vec<LogError>,
    /// The same, for a person.
    pub losses: Vec<String>,
}

/// A mount that transforms give, as it lies on the robot.
fn lain(mount: Pose2, lie: MountsLie) -> Pose2 {
    let turned = |angle: f64| Pose2::new(0.0, 0.0, angle).compose(&mount);
    match lie {
        MountsLie::AsSaid => mount,
        MountsLie::Outward if mount.position().norm() < 1e-3 => mount,
        MountsLie::Outward => Pose2::new(mount.x, mount.y, direction(mount.position())),
        MountsLie::Mirrored => Pose2::new(mount.x, -mount.y, -mount.yaw),
        MountsLie::TurnedLeft => turned(FRAC_PI_2),
        MountsLie::TurnedRight => turned(-FRAC_PI_2),
        MountsLie::TurnedRound => turned(PI),
    }
}

/// A source with its name and what the configuration says of it.
struct Named<'a> {
    source: &'a Source,
    name: String,
    /// The sonar's own; a ring's where it has none.
    known: SonarOverride,
    /// The mount of the frame: from the ring's name.
    frame_mount: Option<Pose2>,
    /// What the configuration says of the frame.
    ring: SonarOverride,
    placed: Option<(SonarId, Mount)>,
    /// Its frame, by the name that transforms have for it.
    frame: String,
    /// Readings whose beam width is that of others.
    lacking: u64,
    /// Whether limits of it stood in each other's place.
    swapped: bool,
    /// Whether transforms put it in two places.
    is_contradicted: bool,
}

impl Placing<'_> {
    /// Whether any sonar has a mount.
    pub fn places_any(&self, sources: &[Source]) -> bool {
        let mut untold = Vec::new();
        let named = self.name(sources, &mut untold);
        let robot_frame = self.robot_frame(&named, &mut untold);
        robot_frame.is_ok_and(|frame| named.iter().any(|sonar| self.mount(sonar, &frame).is_ok()))
    }

    /// The sonars by name, and their readings by stamp; these come with the places of their sources
    /// for ids. A sonar that cannot be placed, or has no beam width, is left out.
    ///
    /// # Errors
    /// When none is left.
    pub fn place(
        &self,
        sources: &[Source],
        mut readings: Readings,
        notes: &mut Vec<String>,
    ) -> Result<Placed, LogError> {
        let mut named = self.name(sources, notes);
        let robot_frame = self.robot_frame(&named, notes);
        let mut order: Vec<usize> = (0..named.len()).collect();
        order.sort_by_cached_key(|place| named.get(*place).map(|sonar| sonar.name.clone()));
        let (mut sonars, mut left_out, mut losses) = (Vec::new(), Vec::new(), Vec::new());
        let mut traits = Vec::new();
        let rivals = self.transforms.with_rivals();
        for place in &order {
            let Some(sonar) = named.get_mut(*place) else {
                continue;
            };
            match self.mount_with(sonar, &robot_frame) {
                Ok(mount) => {
                    let id = u16::try_from(sonars.len()).unwrap_or(u16::MAX); // there are few
                    sonar.placed = Some((SonarId(id), mount));
                    sonars.push(Sonar {
                        name: sonar.name.clone(),
                        topic: sonar.source.key.topic.clone(),
                        robot_from_sensor: mount.robot_from_sensor,
                    });
                    let of = self.traits(sonar, &robot_frame, &mount, rivals.as_ref());
                    sonar.is_contradicted = of.contradicted.is_some();
                    traits.push(of);
                }
                Err(why) => {
                    losses.push(format!(
                        "sonar `{}`, {}: left out, since {}",
                        sonar.name,
                        counted(sonar.source.readings, "reading"),
                        why.in_short()
                    ));
                    left_out.push(why);
                }
            }
        }
        readings.retain_mut(|reading| {
            let Some(sonar) = named.get_mut(reading.sonar.index()) else {
                return false;
            };
            let Some((id, _)) = sonar.placed else {
                return false;
            };
            reading.sonar = id;
            sonar.swapped |= are_swapped(reading);
            sonar.lacking += u64::from(self.complete(sonar, reading));
            true
        });
        let by_name: Vec<&Named<'_>> = order.iter().filter_map(|i| named.get(*i)).collect();
        notes.extend(on_meant_frames(&by_name));
        notes.extend(on_mounts(&by_name));
        if sonars.is_empty() && !left_out.is_empty() {
            return Err(left_out.swap_remove(0));
        }
        let swapped = by_name.iter().copied().filter(|sonar| sonar.swapped);
        let swapped: Vec<&Named<'_>> = swapped.collect();
        if !swapped.is_empty() {
            notes.push(format!(
                "min_range and max_range of {} are swapped in the messages: each is taken for the other",
                which(&swapped)
            ));
        }
        notes.extend(on_missing_widths(&by_name));
        notes.extend(on_senseless_widths(&by_name, self));
        readings.sort_by_place();
        Ok(Placed {
            sonars,
            traits,
            readings,
            left_out,
            losses,
        })
    }

    /// What the transforms say of a mount besides.
    fn traits(
        &self,
        sonar: &Named<'_>,
        robot_frame: &Result<String, Vec<String>>,
        mount: &Mount,
        rivals: Option<&TransformTree>,
    ) -> MountTraits {
        let frame = sonar.frame.as_str();
        let robot_frame = robot_frame.as_deref().unwrap_or_default();
        let is_given = mount_of(&sonar.known).is_some() || sonar.frame_mount.is_some();
        let place = self.transforms.between(robot_frame, frame);
        let place = place.filter(|_| !is_given && self.config.sonars.beam_axis == BeamAxis::X);
        let down = place.map(|(place, _)| (place.rotation * Vector3::y()).z);
        let carrier = self.transforms.carrier(frame, self.world_frame);
        let contradicted = self.transforms.contradicted(frame, robot_frame);
        let contradicted = contradicted.filter(|_| !is_given).zip(rivals);
        let contradicted = contradicted.and_then(|((frame, turns), rivals)| {
            let other = Placing {
                transforms: rivals,
                ..*self
            }
            .mount(sonar, robot_frame);
            Some(Contradicted {
                frame: frame.to_owned(),
                turns,
                robot_from_sensor: other.ok()?.robot_from_sensor,
            })
        });
        MountTraits {
            contradicted,
            frame: frame.to_owned(),
            infrared: sonar.source.infrared,
            in_degrees: sonar.source.in_degrees,
            moved: mount.moved,
            is_optical: down.is_some_and(|z| z < -0.9),
            carrier: carrier.filter(|top| *top != robot_frame).map(str::to_owned),
        }
    }

    /// Where a sonar sits, if it has a beam width as well.
    fn mount_with(
        &self,
        sonar: &Named<'_>,
        robot_frame: &Result<String, Vec<String>>,
    ) -> Result<Mount, LogError> {
        let is_given = mount_of(&sonar.known).is_some() || sonar.frame_mount.is_some();
        let mount = match robot_frame {
            Ok(robot_frame) => self.mount(sonar, robot_frame)?,
            Err(_) if is_given => self.mount(sonar, "")?,
            Err(carriers) => {
                return Err(LogError::NoRobotFrame {
                    topic: self.odometry_topic.to_owned(),
                    carriers: carriers.clone(),
                });
            }
        };
        match self.beam_width(sonar) {
            Some(_) => Ok(mount),
            None => Err(LogError::NoBeamWidth {
                sonar: sonar.name.clone(),
                topic: sonar.source.key.topic.clone(),
            }),
        }
    }

    /// The beam width of readings whose message does not say it, radians.
    fn beam_width(&self, sonar: &Named<'_>) -> Option<f64> {
        (sonar.known.beam_width)
            .or(sonar
                .source
                .beam_width
                .filter(|width| !is_senseless(*width)))
            .or(self.config.sonars.beam_width)
            .or(sonar.source.beam_width)
            .or(sonar.source.likely_beam_width)
    }

    /// The beam width that stands before a message's own, radians.
    fn overruling(&self, sonar: &Named<'_>, own: f64) -> Option<f64> {
        let for_all = self.config.sonars.beam_width;
        (sonar.known.beam_width).or(for_all.filter(|_| is_senseless(own)))
    }

    /// Puts into a reading what its message does not say; whether its beam width was that of others.
    fn complete(&self, sonar: &Named<'_>, reading: &mut RangeReading) -> bool {
        let known = &sonar.known;
        let own = usable(reading.beam_width);
        let overruling = own.and_then(|own| self.overruling(sonar, own));
        let width = overruling.or(own).or_else(|| self.beam_width(sonar));
        reading.beam_width = width.unwrap_or(reading.beam_width);
        let for_all = &self.config.sonars;
        let said = [reading.min_range, reading.max_range];
        // No range lies between limits that were swapped (mit-aera/FlightGoggles#57).
        let [min_range, max_range] = match are_swapped(reading) {
            true => [said[1], said[0]],
            false => said,
        };
        reading.min_range = known.min_range.or(for_all.min_range).unwrap_or(min_range);
        reading.max_range = known.max_range.or(for_all.max_range).unwrap_or(max_range);
        // To the millimetre: no driver's raster is finer than its stand-in is told.
        let is_none = |value: f64| (reading.range - value).abs() < 1e-3;
        if for_all.no_echo.is_some_and(is_none) {
            reading.range = f64::INFINITY;
        }
        own.is_none() && known.beam_width.is_none() && sonar.source.beam_width.is_some()
    }

    fn mount(&self, sonar: &Named<'_>, robot_frame: &str) -> Result<Mount, LogError> {
        let source = sonar.source;
        let frame_from_beam = match self.config.sonars.beam_axis {
            BeamAxis::X => source.frame_from_beam,
            BeamAxis::Z => optical() * source.frame_from_beam,
        };
        let found = match (mount_of(&sonar.known), sonar.frame_mount) {
            (Some(robot_from_sensor), _) => Ok(Mount {
                robot_from_sensor,
                tilt: None,
                moved: false,
            }),
            (None, Some(robot_from_frame)) => {
                Mount::projected(&(in_space(robot_from_frame) * source.frame_from_beam))
            }
            (None, None) if sonar.ring.has_mount() => self
                .transforms
                .mount(robot_frame, &sonar.frame, &Isometry3::identity())
                .and_then(|frame| {
                    let robot_from_frame = frame.overridden(&sonar.ring).robot_from_sensor;
                    Mount::projected(&(in_space(robot_from_frame) * source.frame_from_beam))
                }),
            (None, None) => self
                .transforms
                .mount(robot_frame, &sonar.frame, &frame_from_beam)
                .map(|mount| Mount {
                    robot_from_sensor: lain(mount.robot_from_sensor, self.config.sonars.mounts),
                    ..mount
                }),
        };
        let found = found.map(|mount| mount.overridden(&sonar.known));
        found.map_err(|why| {
            let carrier = self.transforms.carrier(&sonar.frame, self.world_frame);
            let carrier = carrier.filter(|carrier| *carrier != robot_frame);
            LogError::NoMount(Box::new(MissingMount {
                sonar: sonar.name.clone(),
                topic: source.key.topic.clone(),
                frame: source.key.frame.clone(),
                robot_frame: robot_frame.to_owned(),
                is_part: why == NoMount::Unconnected && !source.key.frame.is_empty(),
                why: self.explain(why, &source.key.frame, robot_frame),
                carrier: carrier.map(str::to_owned),
                frames: Arc::clone(self.frames),
            }))
        })
    }

    fn explain(&self, why: NoMount, frame: &str, robot_frame: &str) -> String {
        match why {
            NoMount::Unconnected if frame.is_empty() => "its messages name no frame".to_owned(),
            NoMount::Unconnected if self.transforms.is_unusable(frame) => {
                format!(
                    "the transform of `{frame}` holds no pose (NaN, farther off than 100,000 km, or a quaternion of zero)"
                )
            }
            NoMount::Unconnected => format!("no transform joins it to `{robot_frame}`"),
            NoMount::Vertical => {
                "its beam points straight up or down (along x of its frame; if it looks along z, \
                                  as in frames of cameras, set sonars.beam_axis = \"z\")"
                    .to_owned()
            }
            NoMount::Far => "it lies farther off than 100,000 km".to_owned(),
        }
    }

    /// A sonar's name: its frame, or its topic where two topics share the frame; and its place in
    /// the message, where that holds several. What few of a topic's readings name takes no name from another.
    fn name<'s>(&self, sources: &'s [Source], notes: &mut Vec<String>) -> Vec<Named<'s>> {
        let origin = |source: &'s Source| (&*source.key.topic, &*source.key.frame);
        let (mut readings, mut most) = (BTreeMap::new(), BTreeMap::new());
        for source in sources {
            let of_topic: &mut u64 = most.entry(origin(source).0).or_default();
            *of_topic = (*of_topic).max(source.readings);
            let of_origin: &mut u64 = readings.entry(origin(source)).or_default();
            *of_origin = (*of_origin).max(source.readings);
        }
        let is_usual = |origin: &(&str, &str)| {
            let count = readings.get(origin).copied().unwrap_or(0);
            most.get(origin.0).is_some_and(|most| *most <= 10 * count)
        };
        // By how many origins each is named, and by how many of the usual ones.
        let (mut on_topic, mut in_frame) = (BTreeMap::new(), BTreeMap::new());
        for (topic, frame) in readings.keys() {
            let is_usual = is_usual(&(topic, frame));
            for (all, usual) in [
                on_topic.entry(*topic).or_default(),
                in_frame.entry(*frame).or_default(),
            ] {
                *all += 1_u64;
                *usual += u64::from(is_usual);
            }
        }
        let mut of_last: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for known in self.frames.iter() {
            of_last.entry(last_part(known)).or_default().push(known);
        }
        let mut unused: BTreeSet<&str> = self.config.sonar.keys().map(String::as_str).collect();
        let mut taken = BTreeSet::new();
        let named = sources.iter().map(|source| {
            let (topic, frame) = origin(source);
            let is_usual = is_usual(&(topic, frame));
            let only = |of: Option<&(u64, u64)>| {
                of.is_some_and(|(all, usual)| 1 == if is_usual { *usual } else { *all })
            };
            let (only_of_topic, only_of_frame) =
                (only(on_topic.get(topic)), only(in_frame.get(frame)));
            let whole = match (frame.is_empty(), only_of_frame, only_of_topic) {
                (false, true, _) => frame.to_owned(),
                (_, _, true) => topic.to_owned(),
                _ => format!("{topic}:{frame}"),
            };
            let name = match source.key.element {
                Some(element) => format!("{whole}[{element}]"),
                None => whole.clone(),
            };
            let mut name = if taken.contains(&name) {
                format!("{topic}:{name}")
            } else {
                name
            };
            while !taken.insert(name.clone()) {
                name.push('\'');
            }
            unused.remove(whole.as_str());
            unused.remove(name.as_str());
            let of = |name: &str| self.config.sonar.get(name).cloned().unwrap_or_default();
            let ring = source.key.element.map(|_| of(&whole)).unwrap_or_default();
            let own = of(&name);
            Named {
                source,
                name,
                frame_mount: mount_of(&ring),
                known: SonarOverride {
                    beam_width: own.beam_width.or(ring.beam_width),
                    min_range: own.min_range.or(ring.min_range),
                    max_range: own.max_range.or(ring.max_range),
                    ..own
                },
                ring,
                placed: None,
                frame: meant(&of_last, frame, topic).unwrap_or(frame).to_owned(),
                lacking: 0,
                swapped: false,
                is_contradicted: false,
            }
        });
        let named: Vec<Named<'s>> = named.collect();
        let is_idle = |sonar: &&Named<'_>| {
            let is_described = self.config.sonar.contains_key(&sonar.name);
            is_described && !is_chosen(&self.config.input.sonars, &sonar.name)
        };
        let idle: Vec<&Named<'_>> = named.iter().filter(is_idle).collect();
        if !idle.is_empty() {
            notes.push(format!(
                "{UNUSED} {}, which --sensor (input.sonars) leaves out: it changes no arc",
                which(&idle)
            ));
        }
        let unused: Vec<String> = unused.iter().map(|name| format!("`{name}`")).collect();
        if !unused.is_empty() {
            notes.push(format!(
                "{UNUSED} {} {}, which the log does not have",
                plural(unused.len() as u64, "sonar"),
                few(&unused)
            ));
        }
        named
    }

    /// The frame that the odometry moves where it names that and the one it is in in each other's place: every frame that
    /// is to be mounted hangs on the latter, and none on the former.
    fn exchanged<'f>(&self, to_mount: impl Iterator<Item = &'f str>) -> Option<&str> {
        let mut frames = to_mount.peekable();
        frames.peek()?;
        let is_asked = self.config.input.robot_frame.is_some();
        let hangs = |frame: &str, on: &str| self.transforms.between(on, frame).is_some();
        let all =
            frames.all(|frame| hangs(frame, self.world_frame) && !hangs(frame, self.robot_frame));
        (all && !is_asked && !self.robot_frame.is_empty()).then_some(self.world_frame)
    }

    /// The frame that the odometry moves: as it says, or else the one that carries every sonar
    /// whose mount is not in the configuration.
    ///
    /// # Errors
    /// The frames that may be it.
    fn robot_frame(
        &self,
        named: &[Named<'_>],
        notes: &mut Vec<String>,
    ) -> Result<String, Vec<String>> {
        let mut to_mount = named
            .iter()
            .filter(|sonar| mount_of(&sonar.known).is_none() && sonar.frame_mount.is_none())
            .map(|sonar| sonar.frame.as_str())
            .peekable();
        if let Some(robot_frame) = self.exchanged(to_mount.clone()) {
            notes.push(format!(
                "{} names `{}` as what moves in `{robot_frame}`, which carries the sonars: the two are taken for each other \
                 (input.robot_frame sets another)",
                self.odometry_topic, self.robot_frame
            ));
            return Ok(robot_frame.to_owned());
        }
        if !self.robot_frame.is_empty() || to_mount.peek().is_none() {
            return Ok(self.robot_frame.to_owned());
        }
        let frames: BTreeSet<&str> = to_mount.collect();
        let mut carriers: BTreeSet<&str> = frames
            .iter()
            .filter_map(|frame| self.transforms.carrier(frame, self.world_frame))
            .collect();
        // Messages that give their beams in the robot's own frame need no transform.
        if carriers.is_empty() && frames.len() == 1 {
            carriers = frames;
            carriers.retain(|frame| frame.starts_with("base"));
        }
        let mut found = carriers.iter();
        if let (Some(carrier), None) = (found.next(), found.next()) {
            notes.push(format!(
                "{} does not name the frame that it moves; `{carrier}` is taken, which carries the sonars \
                 (input.robot_frame sets another)",
                self.odometry_topic
            ));
            return Ok((*carrier).to_owned());
        }
        Err(carriers.into_iter().map(Into::into).collect())
    }
}

/// The name without its prefixes.
fn last_part(name: &str) -> &str {
    name.rsplit('/').next().unwrap_or(name)
}

/// The frame of the transforms, by their last names, that messages mean which name one that is none of them: the only one of
/// the same last name, where one of the two is without a prefix (`robot1/front`, as `tf_prefix` makes it), or the topic's
/// where they name no frame.
fn meant<'f>(of_last: &BTreeMap<&str, Vec<&'f str>>, frame: &str, topic: &str) -> Option<&'f str> {
    let last = last_part(if frame.is_empty() { topic } else { frame });
    match of_last.get(last)?.as_slice() {
        [known] if frame.is_empty() || known.contains('/') != frame.contains('/') => Some(known),
        _ => None,
    }
}

fn mount_of(known: &SonarOverride) -> Option<Pose2> {
    Some(Pose2::new(known.x?, known.y?, known.yaw?))
}

/// A beam along z of an optical frame, whose y axis points down: x, y and z of the beam are forward, left and up.
fn optical() -> Isometry3<f64> {
    let turn = UnitQuaternion::from_euler_angles(0.0, -FRAC_PI_2, FRAC_PI_2);
    Isometry3::from_parts(Translation3::identity(), turn)
}

fn in_space(pose: Pose2) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), pose.yaw);
    Isometry3::from_parts([pose.x, pose.y, 0.0].into(), turn)
}

/// How a note on sonars begins that the configuration has and the log has not.
pub const UNUSED: &str = "the configuration describes";

/// What a note on beams that no sonar has says of them.
pub const TOO_WIDE: &str = "wider than any sonar's";

/// Frames that go by another name in the transforms.
fn on_meant_frames(named: &[&Named<'_>]) -> Option<String> {
    let is_meant =
        |sonar: &&Named<'_>| sonar.placed.is_some() && sonar.frame != sonar.source.key.frame;
    let sonars: Vec<&Named<'_>> = named.iter().copied().filter(is_meant).collect();
    let first = sonars.first()?;
    let said = match first.source.key.frame.as_str() {
        "" => "no frame".to_owned(),
        frame => format!("`{frame}`, of which no transform is"),
    };
    Some(format!(
        "messages of {} name {said}: `{}` is taken, which the transforms have, and likewise of the others; [sonar.\"NAME\"] \
         gives other mounts",
        which(&sonars),
        first.frame
    ))
}

/// Mounts that are not what they are taken for.
fn on_mounts(named: &[&Named<'_>]) -> Vec<String> {
    let placed = || {
        named
            .iter()
            .filter_map(|sonar| Some((*sonar, sonar.placed?.1)))
    };
    let told = |test: &dyn Fn(&Named<'_>, &Mount) -> bool, one: &str, many: &str| {
        let some = placed().filter(|(sonar, mount)| test(sonar, mount));
        let sonars: Vec<&Named<'_>> = some.map(|(sonar, _)| sonar).collect();
        let text = if sonars.len() == 1 { one } else { many };
        (!sonars.is_empty()).then(|| text.replace("{}", &which(&sonars)))
    };
    let tilts = placed().filter_map(|(_, mount)| mount.tilt);
    let most = tilts.max_by(|a, b| a.abs().total_cmp(&b.abs()));
    let most = most.unwrap_or(0.0).to_degrees();
    let notes = [
        told(
            &|_, mount| mount.tilt.is_some(),
            &format!(
                "{{}} is tilted {most:.1} deg out of the plane; its mount is projected and its ranges are taken as \
                 they are"
            ),
            &format!(
                "{{}} are tilted up to {most:.1} deg out of the plane; their mounts are projected and their ranges \
                 are taken as they are"
            ),
        ),
        told(
            &|sonar, mount| mount.moved && !sonar.is_contradicted,
            "the mount of {} moves on /tf; its first pose is taken for the whole log",
            "the mounts of {} move on /tf; their first poses are taken for the whole log",
        ),
        told(
            &|sonar, _| sonar.source.turned,
            "the beam of {} turns in its messages; its first bearing is taken for the whole log",
            "the beams of {} turn in their messages; their first bearings are taken for the whole log",
        ),
    ];
    notes.into_iter().flatten().collect()
}

/// Readings without beam width, of sonars whose other readings have one.
fn on_missing_widths(named: &[&Named<'_>]) -> Option<String> {
    let some = named.iter().copied().filter(|sonar| sonar.lacking > 0);
    let sonars: Vec<&Named<'_>> = some.collect();
    let readings = sonars.iter().map(|sonar| sonar.lacking).sum();
    let mut widths = sonars.iter().filter_map(|sonar| sonar.source.beam_width);
    let first = widths.next()?.to_degrees();
    let whose = if sonars.len() == 1 { "its" } else { "their" };
    let taken = if widths.all(|width| width.to_degrees() == first) {
        format!("the {first:.1} deg that {whose} others give are taken")
    } else {
        format!("what {whose} others give is taken")
    };
    let verb = if readings == 1 { "gives" } else { "give" };
    Some(format!(
        "{} of {} {verb} no beam width; {taken}",
        counted(readings, "reading"),
        which(&sonars)
    ))
}

/// Beams as wide as no sonar's is, which the configuration does not overrule.
fn on_senseless_widths(named: &[&Named<'_>], placing: &Placing<'_>) -> Option<String> {
    let read = |sonar: &Named<'_>| {
        let width = sonar
            .source
            .beam_width
            .filter(|width| is_senseless(*width))?;
        placing.overruling(sonar, width).is_none().then_some(width)
    };
    let some = named.iter().copied().filter(|sonar| sonar.placed.is_some());
    let sonars: Vec<&Named<'_>> = some.filter(|sonar| read(sonar).is_some()).collect();
    let width = sonars.iter().find_map(|sonar| read(sonar))?;
    // What is beyond half a turn can only be meant in degrees.
    let likely = match width > std::f64::consts::PI {
        true => width as f32, // as the driver wrote it
        false => 22.5,
    };
    let (verb, whose) = match sonars.len() {
        1 => ("is", "its"),
        _ => ("are", "their"),
    };
    Some(format!(
        "the {} of {} {verb} {:.0} deg wide by {whose} messages ({width:.3} rad), {TOO_WIDE}: if the driver \
         writes degrees, sonars.beam_width = {likely} (deg) in the configuration overrules it",
        plural(sonars.len() as u64, "beam"),
        which(&sonars),
        width.to_degrees(),
    ))
}

/// ``sonar `a` ``; ``16 sonars (`a`, `b`, `c` and 13 more)``.
fn which(sonars: &[&Named<'_>]) -> String {
    let names: Vec<String> = sonars.iter().map(|s| format!("`{}`", s.name)).collect();
    match names.as_slice() {
        [one] => format!("sonar {one}"),
        _ => format!("{} ({})", counted(names.len() as u64, "sonar"), few(&names)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_of_another_prefix_are_meant_and_those_of_another_robot_are_not() {
        let of_last = BTreeMap::from([
            ("front", vec!["front"]),
            ("left", vec!["robot1/left"]),
            ("back", vec!["a/back", "b/back"]),
        ]);
        let meant = |frame, topic| meant(&of_last, frame, topic);
        assert_eq!(meant("robot1/front", "/us"), Some("front"));
        assert_eq!(meant("left", "/us"), Some("robot1/left"));
        assert_eq!(meant("", "/us/front"), Some("front"));
        assert_eq!(meant("robot2/left", "/us"), None);
        assert_eq!(meant("back", "/us"), None);
        assert_eq!(meant("front", "/us"), None);
    }

    #[test]
    fn mounts_are_laid_as_is_said() {
        let mount = Pose2::new(0.1, 0.2, 0.5);
        let near = |lie, [x, y, yaw]: [f64; 3]| {
            let found = lain(mount, lie);
            let off = [found.x - x, found.y - y, found.yaw - yaw];
            assert!(off.iter().all(|off| off.abs() < 1e-12), "{lie:?} {found:?}");
        };
        near(MountsLie::AsSaid, [0.1, 0.2, 0.5]);
        near(MountsLie::Outward, [0.1, 0.2, libm::atan2(0.2, 0.1)]);
        near(MountsLie::Mirrored, [0.1, -0.2, -0.5]);
        near(MountsLie::TurnedLeft, [-0.2, 0.1, 0.5 + FRAC_PI_2]);
        near(MountsLie::TurnedRight, [0.2, -0.1, 0.5 - FRAC_PI_2]);
        near(MountsLie::TurnedRound, [-0.1, -0.2, 0.5 - PI]);
    }
}
