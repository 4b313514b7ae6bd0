//! Regions of constant depth: Leonard and Durrant-Whyte, *Directed Sonar Sensing for Mobile Robot Navigation*
//! (1992); the matching of regions as Wang et al. tell it.
//!
//! A sonar that turns on the spot measures one range as long as its beam covers the target. Such a region is an
//! arc whose bearing is constrained: every one of its beams held the target, so the wider the region, the
//! narrower the constraint. Two regions of different places match as a line where they have a common tangent within
//! their constraints, as a point where they have a crossing there. Regions that match one are a cluster; it is
//! a line or a point by the share of its pairs that match as such. A line is the orthogonal regression of its
//! contact points, a point the mean of its crossings. What no cluster wants is left out.
//!
//! Assumed: the numbers below; clusters grow around a first region instead of by geometry.
//!
//! It needs a dense scan: a sparse log has no regions, which is said. Neither lines nor points have covariances.

use std::collections::{BTreeMap, BTreeSet};

use super::regression::line_through;
use super::rival::{Found, Rival, Scan};
use super::triangulation::mean;
use crate::core::config::Config;
use crate::core::event::SonarId;
use crate::core::geometry::{Pose2, Vec2, angle_between, wrap_angle};
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{Point, Shape};
use crate::core::tmam::label::Kind;
use crate::core::tmam::pair::{PairPoint, Points};

/// How far a sonar moves while its robot turns on the spot, metres.
const ON_THE_SPOT: f64 = 0.15;
/// Readings that are turned farther against each other are no dense scan, radians.
const DENSE: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// Ranges of a region differ by this at most, metres, or by three standard deviations.
const CONSTANT: f64 = 0.02;
/// A region is at least this wide, radians,
const WIDTH: f64 = 8.0 * std::f64::consts::PI / 180.0;
/// and has so many readings.
const READINGS: usize = 4;
/// Regions whose centres are nearer than this are of one place, metres.
const ANOTHER_PLACE: f64 = 0.25;
/// Regions of a cluster at least.
const CLUSTER: usize = 3;
/// Share of the pairs of a cluster that match.
const AGREEING: f64 = 0.6;
/// How many regions a region is matched with, at most: the nearest ones in time.
const MOST: usize = 2000;
/// Pairs of a cluster that are looked at are of its first so many regions.
const MOST_OF_CLUSTER: usize = 60;

/// A region of constant depth.
#[derive(Debug, Clone)]
struct Region {
    /// As an arc as wide as its constraint, from the middle of its sensors.
    arc: Arc,
    /// The readings.
    readings: Vec<Arc>,
}

/// The open region of each sonar, and all that are closed.
#[derive(Debug)]
pub struct Rcd {
    open: BTreeMap<SonarId, Vec<Arc>>,
    regions: Vec<Region>,
    /// Neighbouring readings of a sonar on the spot, and how far the sonar turned between them at least.
    on_the_spot: u64,
    turned: f64,
    longest_gap: f64,
}

impl Rcd {
    pub fn new(config: &Config) -> Self {
        Self {
            open: BTreeMap::new(),
            regions: Vec::new(),
            on_the_spot: 0,
            turned: 0.0,
            longest_gap: config.map.max_wall_gap,
        }
    }

    fn close(&mut self, readings: Vec<Arc>) {
        self.regions.extend(Region::of(readings));
    }
}

impl Region {
    /// Of neighbouring readings of one range; `None` where they are too few.
    fn of(readings: Vec<Arc>) -> Option<Self> {
        let (first, last) = (readings.first()?, readings.last()?);
        let yaw = first.world_from_sensor.yaw;
        // A sonar may turn by more than half a circle before a round wall.
        let turned = readings.windows(2).fold(0.0, |sum, pair| match pair {
            [a, b] => sum + wrap_angle(b.world_from_sensor.yaw - a.world_from_sensor.yaw),
            _ => sum,
        });
        let width = f64::abs(turned);
        if readings.len() < READINGS || width < WIDTH {
            return None;
        }
        let step = width / (readings.len() - 1) as f64;
        let center = mean(readings.iter().map(Arc::center));
        let sum = readings.iter().fold(0.0, |sum, arc| sum + arc.range);
        let constraint = f64::max(first.beam_width - width, 0.0) + 2.0 * step;
        let arc = Arc {
            world_from_sensor: Pose2::new(center.x, center.y, yaw + turned / 2.0),
            range: sum / readings.len() as f64,
            beam_width: constraint,
            ..*last
        };
        Some(Self { arc, readings })
    }

    /// The contact point or the crossing with another region.
    fn matches(&self, other: &Self, kind: Kind) -> Option<PairPoint> {
        if (self.arc.center() - other.arc.center()).norm() < ANOTHER_PLACE {
            return None;
        }
        let points = Points::of(&self.arc, &other.arc);
        let points = match kind {
            Kind::Line => points.contact,
            Kind::Point => points.intersection,
            Kind::Circle => return None,
        };
        points.into_iter().flatten().next()
    }
}

/// Regions that match as a line or as a point.
struct Cluster {
    kind: Kind,
    members: Vec<usize>,
    agreement: f64,
}

impl Cluster {
    /// Of the regions that match the first one.
    fn around(seed: usize, left: &BTreeSet<usize>, regions: &[Region], kind: Kind) -> Option<Self> {
        let first = regions.get(seed)?;
        let others = left.range(seed + 1..).take(MOST);
        let matching = others.copied().filter(|other| {
            let other = regions.get(*other);
            other.is_some_and(|other| first.matches(other, kind).is_some())
        });
        let members: Vec<usize> = std::iter::once(seed).chain(matching).collect();
        if members.len() < CLUSTER {
            return None;
        }
        let looked_at: Vec<&Region> = (members.iter().take(MOST_OF_CLUSTER))
            .filter_map(|member| regions.get(*member))
            .collect();
        let (mut pairs, mut agreeing) = (0_u32, 0_u32);
        for (place, one) in looked_at.iter().enumerate() {
            for other in looked_at.iter().skip(place + 1) {
                let apart = (one.arc.center() - other.arc.center()).norm() >= ANOTHER_PLACE;
                pairs += u32::from(apart);
                agreeing += u32::from(one.matches(other, kind).is_some());
            }
        }
        Some(Self {
            kind,
            members,
            agreement: f64::from(agreeing) / f64::from(pairs.max(1)),
        })
    }

    /// Its feature, of the regions that match most of the others.
    fn feature(&self, regions: &[Region], longest_gap: f64) -> Option<(Found, Vec<usize>)> {
        let members = || self.members.iter().take(MOST_OF_CLUSTER);
        let mut places = Vec::new();
        let mut kept = Vec::new();
        for member in &self.members {
            let region = regions.get(*member)?;
            let others = members().filter(|other| *other != member);
            let others = others.filter_map(|other| regions.get(*other));
            let (mut apart, mut points) = (0, Vec::new());
            for other in others {
                apart +=
                    usize::from((region.arc.center() - other.arc.center()).norm() >= ANOTHER_PLACE);
                points.extend(region.matches(other, self.kind).map(|point| point.on_a));
            }
            if 2 * points.len() > apart {
                places.push(mean(points.into_iter()));
                kept.push(*member);
            }
        }
        if kept.len() < CLUSTER {
            return None;
        }
        let (shape, on) = match self.kind {
            Kind::Point => {
                let position = mean(places.into_iter());
                (Shape::Point(Point::without_covariance(position)), kept)
            }
            Kind::Line => {
                let on = together(&places, &kept, longest_gap);
                let places: Vec<Vec2> = on.iter().map(|(place, _)| *place).collect();
                let line = line_through(&places)?;
                let on: Vec<usize> = on.into_iter().map(|(_, member)| member).collect();
                (Shape::Line(line), on)
            }
            Kind::Circle => return None,
        };
        if on.len() < CLUSTER {
            return None;
        }
        let regions = on.iter().filter_map(|member| regions.get(*member));
        let arcs = regions.flat_map(|region| region.readings.iter().copied());
        let arcs = arcs.collect();
        Some((Found { shape, arcs }, on))
    }
}

/// Of contact points those of one wall: from the first region's on as far as there is no gap.
fn together(places: &[Vec2], members: &[usize], longest_gap: f64) -> Vec<(Vec2, usize)> {
    let Some((along, seed)) = line_through(places)
        .map(|line| line.along())
        .zip(places.first())
    else {
        return Vec::new();
    };
    let mut all: Vec<(f64, (Vec2, usize))> = (places.iter().zip(members))
        .map(|(place, member)| (place.dot(&along), (*place, *member)))
        .collect();
    all.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let seed = seed.dot(&along);
    let mut on: Vec<(f64, (Vec2, usize))> = Vec::new();
    for one in all {
        if on.last().is_some_and(|last| one.0 - last.0 > longest_gap) {
            if on.last().is_some_and(|last| last.0 >= seed) {
                break;
            }
            on.clear();
        }
        on.push(one);
    }
    on.into_iter().map(|(_, one)| one).collect()
}

impl Rival for Rcd {
    fn take(&mut self, scan: &Scan) -> Vec<Found> {
        for sonar in &scan.silent {
            if let Some(readings) = self.open.remove(sonar) {
                self.close(readings);
            }
        }
        for arc in &scan.arcs {
            let open = self.open.entry(arc.id.sonar).or_default();
            let joins = match (open.first(), open.last()) {
                (Some(first), Some(last)) => {
                    let turn = angle_between(last.world_from_sensor.yaw, arc.world_from_sensor.yaw);
                    let on_the_spot = (arc.center() - first.center()).norm() < ON_THE_SPOT;
                    if on_the_spot && turn > 0.0 {
                        self.on_the_spot += 1;
                        self.turned += turn;
                    }
                    let constant = f64::max(CONSTANT, 3.0 * (2.0 * arc.variance).sqrt());
                    on_the_spot
                        && turn > 0.0
                        && turn < DENSE
                        && (arc.range - first.range).abs() < constant
                        && (arc.range - last.range).abs() < constant
                }
                _ => true,
            };
            if joins {
                open.push(*arc);
            } else {
                let readings = std::mem::replace(open, vec![*arc]);
                self.close(readings);
            }
        }
        Vec::new()
    }

    fn finish(&mut self) -> Vec<Found> {
        for readings in std::mem::take(&mut self.open).into_values() {
            self.close(readings);
        }
        let regions = &self.regions;
        let mut left: BTreeSet<usize> = (0..regions.len()).collect();
        let mut found = Vec::new();
        while let Some(seed) = left.pop_first() {
            let clusters = [Kind::Line, Kind::Point]
                .into_iter()
                .filter_map(|kind| Cluster::around(seed, &left, regions, kind))
                .filter(|cluster| cluster.agreement >= AGREEING);
            // Of two that agree alike the one with more regions.
            let weight = |cluster: &Cluster| cluster.agreement * cluster.members.len() as f64;
            let best = clusters.reduce(|a, b| if weight(&b) > weight(&a) { b } else { a });
            let feature = best.and_then(|cluster| cluster.feature(regions, self.longest_gap));
            if let Some((one, members)) = feature {
                for member in members {
                    left.remove(&member);
                }
                found.push(one);
            }
        }
        found
    }

    fn lacking(&self) -> Option<String> {
        if !self.regions.is_empty() {
            return None;
        }
        let turned = if self.on_the_spot > 0 {
            format!(
                "sonars on the spot turned by {:.1} deg from reading to reading in the mean",
                self.turned.to_degrees() / self.on_the_spot as f64
            )
        } else {
            "no sonar turned on the spot".to_owned()
        };
        Some(format!(
            "no region of constant depth: {turned}, and it takes {:.0} deg at most, over {:.0} deg of one range. Record a \
             robot that turns on the spot, and replay it with a smaller --step-angle",
            DENSE.to_degrees(),
            WIDTH.to_degrees()
        ))
    }
}
