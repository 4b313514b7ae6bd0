//! Everything that a recording holds frame by frame: where it is and how it looks.

use rerun::{AsComponents, Color, LineStrips2D, Points2D, Radius};

use super::style;
use crate::core::event::SonarId;

/// What rows are written of, in the order in which the last ones are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Entity {
    WrongLabels,
    Errors,
    SpuriousLines,
    SpuriousPoints,
    Arcs,
    Beams,
    ContactPoints,
    IntersectionPoints,
    /// What decides the labels of a sonar, as dots: by how much chi2 of a line is ahead of a point's, and how
    /// well the better of the two fits.
    Lead(SonarId),
    Fit(SonarId),
    /// The same under the paper's rule: theta_c by theta_i, and the smaller of the two.
    Ratio(SonarId),
    Angle(SonarId),
    /// The labels of a sonar, as words.
    Labels(SonarId),
    /// The same as dots: lanes of words melt into grey where a run is long.
    LabelDots(SonarId),
    Evidence,
    ChangedLabels,
    ClosedArcs,
    ClosedLines,
    ClosedPoints,
    /// A page of the map; so are the next four.
    MapLines(u32),
    MapPoints(u32),
    MapCircles(u32),
    MapCovariance(u32),
    MapIds(u32),
    Robot,
    Outline,
    SonarNames,
    Trajectory,
    /// Where every reading would have echoed on the axis of its beam.
    Echoes,
    /// What was corrected of the poses; so are the next five.
    OdometryPath,
    PoseCovariance,
    Moved,
    Turned,
    Closures,
    ClosureLog,
    Log,
    Suspects,
    /// All of them, at all times.
    AllSuspects,
    /// What contradicts those of a frame.
    Contradicting,
    /// Their names, above them.
    ContradictingNames,
    SuspectLog,
    /// The bounds that what decides is held against.
    Decisive,
    Gate,
    Alpha,
    Beta,
    Gamma,
}

/// How strips or dots look.
#[derive(Debug, Clone, Copy)]
pub struct Look {
    form: Form,
    /// On the screen, whatever the zoom.
    radius: f32,
    pub paint: Paint,
    pub names: Names,
    /// What stacks on what: higher is nearer to the eye.
    order: f32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    Strips,
    Dots,
}

/// Where the colour comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Paint {
    /// From the class of each instance: the viewer knows the colours.
    Class,
    /// From each instance.
    Each,
    All(Color),
}

/// What an instance is called.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Names {
    /// Nothing.
    None,
    /// Told where it is pointed at or selected.
    Hidden,
    /// Written beside it.
    Shown,
}

impl Entity {
    /// Where it is in a recording; what is of a sonar is below that, under its name.
    pub fn path(self) -> String {
        let path = match self {
            Self::WrongLabels => "/world/truth/wrong_labels",
            Self::Errors => "/world/truth/errors",
            Self::SpuriousLines => "/world/truth/spurious_lines",
            Self::SpuriousPoints => "/world/truth/spurious_points",
            Self::Arcs | Self::Evidence => "/world/arcs",
            Self::Beams => "/world/beams",
            Self::ContactPoints => "/world/contact_points",
            Self::IntersectionPoints => "/world/intersection_points",
            Self::Lead(_) => "/chi2/lead",
            Self::Fit(_) => "/chi2/fit",
            Self::Ratio(_) => "/angles/ratio",
            Self::Angle(_) => "/angles/smaller",
            Self::Labels(_) => "/labels",
            Self::LabelDots(_) => "/lanes",
            Self::ChangedLabels => "/world/differences/labels",
            Self::ClosedArcs => "/world/features/arcs",
            Self::ClosedLines => "/world/features/lines",
            Self::ClosedPoints => "/world/features/points",
            Self::MapLines(page) => return format!("/world/map/lines/{page}"),
            Self::MapPoints(page) => return format!("/world/map/points/{page}"),
            Self::MapCircles(page) => return format!("/world/map/circles/{page}"),
            Self::MapCovariance(page) => return format!("/world/map/covariance/{page}"),
            Self::MapIds(page) => return format!("/world/map/ids/{page}"),
            Self::Robot => "/world/robot",
            Self::Outline => "/world/robot/outline",
            Self::SonarNames => "/world/robot/sonars",
            Self::Echoes => "/world/echoes",
            Self::Trajectory => "/world/trajectory",
            Self::OdometryPath => "/world/odometry",
            Self::PoseCovariance => "/world/pose_covariance",
            Self::Moved => "/correction/moved",
            Self::Turned => "/correction/turned",
            Self::Closures => "/world/closures",
            Self::ClosureLog => "/log/closures",
            Self::Log => "/log",
            Self::Suspects => "/world/suspects",
            Self::AllSuspects => "/world/suspects/all",
            Self::Contradicting => "/world/suspects/contradicting",
            Self::ContradictingNames => "/world/suspects/contradicting/names",
            Self::SuspectLog => "/log/suspects",
            Self::Decisive => "/chi2/decisive",
            Self::Gate => "/chi2/gate",
            Self::Alpha => "/angles/alpha",
            Self::Beta => "/angles/beta",
            Self::Gamma => "/angles/gamma",
        };
        path.to_owned()
    }

    /// The sonar that it is of.
    pub fn of_sonar(self) -> Option<SonarId> {
        match self {
            Self::Lead(sonar)
            | Self::Fit(sonar)
            | Self::Ratio(sonar)
            | Self::Angle(sonar)
            | Self::Labels(sonar)
            | Self::LabelDots(sonar) => Some(sonar),
            _ => None,
        }
    }

    /// How it looks, where it is drawn in the map.
    pub fn look(self) -> Option<Look> {
        use Paint::{All, Class, Each};
        let look = match self {
            Self::SpuriousLines => Look::strips(2.5, All(style::WRONG), 5.5).named(),
            Self::SpuriousPoints => Look::dots(4.5, All(style::WRONG), 5.5).named(),
            Self::Errors => Look::strips(1.0, All(style::ERROR), 5.5).named(),
            // Wide bands below the arcs, so that their own colours stay to be seen.
            Self::Suspects => Look::strips(5.0, All(style::SUSPECT), 6.5).shown(true),
            Self::AllSuspects => Look::strips(2.0, All(style::FAINT_SUSPECT), 1.6).named(),
            Self::Contradicting => Look::strips(1.5, All(style::CONTRADICTING), 8.5),
            Self::ContradictingNames => Look::dots(0.5, All(style::CONTRADICTING), 9.9).shown(true),
            Self::Echoes => Look::dots(1.25, Class, 1.2),
            Self::SonarNames => Look::dots(1.0, Each, 10.0).shown(true),
            Self::MapIds(_) => Look::dots(0.5, All(style::IDS), 9.8).shown(true),
            Self::WrongLabels => Look::strips(5.0, All(style::WRONG), 6.6).named(),
            Self::ChangedLabels => Look::strips(5.0, All(style::NOW), 8.6).shown(true),
            Self::Beams => Look::strips(0.5, All(style::BEAM), 1.0),
            Self::Trajectory => Look::strips(1.0, All(style::TRAJECTORY), 2.0),
            Self::OdometryPath => Look::strips(0.75, All(style::ODOMETRY), 1.8),
            Self::Closures => Look::strips(0.5, All(style::LINK), 0.9).named(),
            Self::PoseCovariance => Look::strips(0.75, All(style::COVARIANCE), 9.5),
            Self::MapCovariance(_) => Look::strips(0.5, All(style::COVARIANCE), 3.0),
            Self::MapLines(_) => Look::strips(2.5, Each, 4.0).named(),
            Self::MapPoints(_) => Look::dots(4.5, Each, 5.0).named(),
            Self::MapCircles(_) => Look::strips(2.5, Each, 4.5).named(),
            Self::ClosedArcs => Look::strips(0.75, Each, 6.0).named(),
            Self::Arcs => Look::strips(2.0, Class, 7.0).named(),
            Self::ClosedLines => Look::strips(4.5, Each, 8.0).named(),
            Self::ClosedPoints => Look::dots(7.5, Each, 8.0).named(),
            Self::ContactPoints => Look::dots(3.0, All(style::CONTACT), 9.0),
            Self::IntersectionPoints => Look::dots(3.0, All(style::INTERSECTION), 9.0),
            Self::Outline => Look::strips(2.0, All(style::ROBOT), 10.0),
            _ => return None,
        };
        Some(look)
    }

    /// Whether its look is written with its first row: pages come as the map grows.
    pub fn is_page(self) -> bool {
        matches!(
            self,
            Self::MapLines(_)
                | Self::MapPoints(_)
                | Self::MapCircles(_)
                | Self::MapCovariance(_)
                | Self::MapIds(_)
        )
    }
}

impl Look {
    pub const fn strips(radius: f32, paint: Paint, order: f32) -> Self {
        Self {
            form: Form::Strips,
            radius,
            paint,
            names: Names::None,
            order,
        }
    }

    pub const fn dots(radius: f32, paint: Paint, order: f32) -> Self {
        Self {
            form: Form::Dots,
            ..Self::strips(radius, paint, order)
        }
    }

    const fn named(self) -> Self {
        self.shown(false)
    }

    /// The same, with names that are written, or only told.
    pub const fn shown(self, shown: bool) -> Self {
        let names = if shown { Names::Shown } else { Names::Hidden };
        Self { names, ..self }
    }

    /// As the viewer takes it.
    pub fn archetype(self) -> Box<dyn AsComponents> {
        match self.form {
            Form::Strips => Box::new(self.of_strips(LineStrips2D::update_fields())),
            Form::Dots => Box::new(self.of_dots(Points2D::update_fields())),
        }
    }

    /// Strips that look so.
    pub fn of_strips(self, strips: LineStrips2D) -> LineStrips2D {
        let mut strips = strips
            .with_radii([ui(self.radius)])
            .with_draw_order(self.order);
        if let Paint::All(color) = self.paint {
            strips = strips.with_colors([color]);
        }
        match self.names {
            Names::None => strips,
            names => strips.with_show_labels(names == Names::Shown),
        }
    }

    /// Dots that look so.
    pub fn of_dots(self, dots: Points2D) -> Points2D {
        let mut dots = dots
            .with_radii([ui(self.radius)])
            .with_draw_order(self.order);
        if let Paint::All(color) = self.paint {
            dots = dots.with_colors([color]);
        }
        // A class has a name, too.
        dots.with_show_labels(self.names == Names::Shown)
    }
}

/// A size on the screen, whatever the zoom.
pub fn ui(points: f32) -> Radius {
    Radius::new_ui_points(points)
}
