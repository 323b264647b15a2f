//! The vocabulary of hands.

use super::{DEFAULT_GRASP_EVALUATIONS, MAX_FINGERS, MAX_GRASP_EVALUATIONS, MIN_FINGERS, Plane};
use crate::device::shape::ShapeForm;
use crate::device::words::words;
use crate::device::{
    Assay, Count, DefaultFigure, Frames, Noun, Outcome, OutcomeUnit, Planner, Range, Sort, Together, Verb, Vocabulary,
    VocabularyField, VocabularyPhrase, any, budget, defaulted, expansions, not_negative, optional, outcome, planner,
    positive, required, verb,
};
use crate::quantity::Dimension;

words! {
    /// Objective.
    pub enum FingersObjective {
        Effort = "effort": "degrees rolled, and the gaiting cost of each finger placed or removed",
    }
}

words! {
    /// An outcome of a plan.
    pub enum FingersOutcome {
        Effort = "effort": "the turn of every step times the fingers that roll, and the gaiting cost of each finger placed or removed",
        Reconfigurations = "reconfigurations": "fingers placed or removed, not counting the first grasp and `release`",
        Time = "time": "from the beginning of the task to the end of its last step",
    }
}

words! {
    /// Search method.
    pub enum FingersPlanner {
        JointAstar = "joint_astar": "all turns of a task searched as one problem by A*, with exact numbers of reconfigurations as its estimate",
        PublishedAstar = "published_astar": "the same problem with the paper's estimate, its index arithmetic corrected",
        GreedyDecomposition = "greedy_decomposition": "the paper's method: each turn is planned separately at least cost, from where the previous one ended",
    }
}

const FIELDS: &[VocabularyField] = &[
    required(
        "fingers",
        Sort::Count { least: MIN_FINGERS, most: MAX_FINGERS },
        "number of fingers; two or three of them hold at the same time",
    ),
    required("tip_radius", positive(Dimension::LENGTH), "radius of the spherical tip of each finger"),
    required("adhesion", Sort::Flag, "whether tips adhere to the object and must be pulled off"),
    required(
        "pull_off",
        not_negative(Dimension::FORCE),
        "force that pulls a tip off the object; used with `adhesion: true`",
    ),
    required("max_force", positive(Dimension::FORCE), "greatest normal force of one tip"),
    required("friction", positive(Dimension::NUMBER), "coefficient of friction between a tip and the object"),
    required(
        "step",
        positive(Dimension::ANGLE),
        "rotation step; it must divide 360 deg (within 0.01 %, to allow for rounded digits)",
    ),
    required(
        "removal_safety",
        not_negative(Dimension::NUMBER),
        "the remaining fingers must resist this many times the pull-off force of the finger that is removed",
    ),
    required("gaiting_cost", positive(Dimension::ANGLE), "cost of placing or removing a finger, in degrees of rolling"),
    required(
        "clearance",
        not_negative(Dimension::LENGTH),
        "least distance between tips, and between a free tip and the object",
    ),
    required(
        "retract",
        positive(Dimension::LENGTH),
        "distance by which a tip leaves its contact along the normal, at `approach_speed`",
    ),
    required("speed", positive(Dimension::SPEED), "speed of a free tip"),
    required(
        "approach_speed",
        positive(Dimension::SPEED),
        "speed of a tip near its contact, as it approaches or leaves",
    ),
    required("rolling_speed", positive(Dimension::SPEED), "speed of the fastest tip while the object rolls"),
    required(
        "range",
        Sort::Vector { dimension: Dimension::LENGTH, range: Range::Positive },
        "travel of the stages along x, y and z, to either side of the hand's origin",
    ),
    defaulted(
        "support",
        not_negative(Dimension::FORCE),
        DefaultFigure::new(0.0, "uN"),
        "force with which the support holds the object before the first grasp and after a release",
    ),
    required(
        "tolerance",
        positive(Dimension::LENGTH),
        "greatest deviation of a contact from exact touching and rolling",
    ),
    defaulted(
        "torsion",
        not_negative(Dimension::LENGTH),
        DefaultFigure::new(0.0, "um"),
        "torque about the normal that a contact bears, divided by the force that presses and adheres there",
    ),
    defaulted(
        "rolling_reserve",
        not_negative(Dimension::NUMBER),
        // Rolling on chords turns a force by up to 1/100 of the friction cone; this is twice that.
        DefaultFigure::new(2.0, "%"),
        "share of friction, pull-off and greatest force that planned grasps leave unused while they roll",
    ),
];

const SETTINGS: &[VocabularyField] = &[
    defaulted(
        "precision",
        positive(Dimension::ANGLE),
        DefaultFigure::new(0.5, "deg"),
        "greatest error at the end of each turn",
    ),
    optional(
        "load",
        Sort::Vector { dimension: Dimension::FORCE, range: Range::Any },
        "none",
        "a force on the object in the hand's frame, besides its weight",
    ),
];

words! {
    /// A rotation axis, fixed to the object.
    pub enum TurnAxis {
        X = "x": "by turns about z and y, because the object has no section across x",
        Y = "y": "in the object's plane xz",
        Z = "z": "in the object's plane xy",
    }
}

impl TurnAxis {
    /// The plane of the section that turns about this axis, if there is one.
    pub fn plane(self) -> Option<Plane> {
        match self {
            TurnAxis::X => None,
            TurnAxis::Y => Some(Plane::Xz),
            TurnAxis::Z => Some(Plane::Xy),
        }
    }
}

words! {
    /// A step of a hand.
    pub enum FingersVerb {
        Grasp = "grasp": "grasps an object, or changes fingers, until each finger holds the contact with its number, and may roll the object there and back; 0 is a free finger; without `at` the planner chooses",
        Rotate = "rotate": "turns an object about one of its own axes, right-handed; `by 220 deg` is the long way",
        Orient = "orient": "turns an object to an orientation in the hand's frame, the cheapest way",
        Translate = "translate": "moves an object along x, y and z of the hand's frame, with all fingers together",
        Release = "release": "removes all fingers; the support must hold the object against the last one",
    }
}

const VERBS: &[Verb] = &[
    Verb {
        object: Some(Sort::Object("part")),
        phrases: &[VocabularyPhrase { preposition: "at", sort: Sort::Contacts, count: Count::AtMostOnce }],
        example: "grasp bead at (1, 38)",
        ..verb(FingersVerb::Grasp.choice())
    },
    Verb {
        object: Some(Sort::Object("part")),
        phrases: &[
            VocabularyPhrase { preposition: "by", sort: any(Dimension::ANGLE), count: Count::Once },
            VocabularyPhrase { preposition: "about", sort: Sort::Word(TurnAxis::CHOICES), count: Count::Once },
        ],
        example: "rotate bead by 80 deg about z",
        ..verb(FingersVerb::Rotate.choice())
    },
    Verb {
        object: Some(Sort::Object("part")),
        phrases: &[VocabularyPhrase { preposition: "to", sort: Sort::Orientation, count: Count::Once }],
        example: "orient bead to euler(80 deg, 220 deg, 100 deg)",
        ..verb(FingersVerb::Orient.choice())
    },
    Verb {
        object: Some(Sort::Object("part")),
        phrases: &[VocabularyPhrase {
            preposition: "by",
            sort: Sort::Vector { dimension: Dimension::LENGTH, range: Range::Any },
            count: Count::Once,
        }],
        example: "translate bead by (5 um, 0 um, 2 um)",
        ..verb(FingersVerb::Translate.choice())
    },
    Verb { example: "release", ..verb(FingersVerb::Release.choice()) },
];

const BUDGET: [VocabularyField; 2] = [
    expansions(200_000_000, "number of grasps the search may expand before it gives up"),
    budget(
        "looks",
        MAX_GRASP_EVALUATIONS,
        DEFAULT_GRASP_EVALUATIONS,
        "number of grasp evaluations, some tens of nanoseconds each, before the search gives up",
    ),
];

const PLANNERS: &[Planner] = &[
    planner(FingersPlanner::JointAstar.choice(), &BUDGET),
    planner(FingersPlanner::PublishedAstar.choice(), &BUDGET),
    planner(FingersPlanner::GreedyDecomposition.choice(), &BUDGET),
];

const OUTCOMES: &[Outcome] = &[
    outcome(FingersOutcome::Effort.choice(), OutcomeUnit::Degree),
    outcome(FingersOutcome::Reconfigurations.choice(), OutcomeUnit::Count),
    outcome(FingersOutcome::Time.choice(), OutcomeUnit::Nanosecond),
];

words! {
    /// A noun of a hand's scene.
    pub enum HandNoun {
        Part = "part": "the object that the fingers turn",
    }
}

/// The vocabulary of the kind.
pub const VOCABULARY: Vocabulary = Vocabulary {
    name: "fingers",
    summary: "fingers on translation stages that roll an object between their tips and regrasp it",
    library: ("std.fingers", "fingers.three_fingers"),
    fields: FIELDS,
    nouns: &[Noun::of(
        HandNoun::Part.choice(),
        &[
            ShapeForm::Ellipsoid,
            ShapeForm::Superellipsoid,
            ShapeForm::RoundedBox,
            ShapeForm::Profile,
            ShapeForm::Sections,
            ShapeForm::Mesh,
        ],
    )],
    settings: SETTINGS,
    state: None,
    together: Together::No("a hand turns one part at a time"),
    assay: Assay::No,
    frames: Frames::No,
    verbs: VERBS,
    conditions: &[],
    objectives: FingersObjective::CHOICES,
    planners: PLANNERS,
    outcomes: OUTCOMES,
    channels: "<device>.f1.x, f1.y, f1.z and so on: position of the centre of each finger's tip, in micrometres",
};
