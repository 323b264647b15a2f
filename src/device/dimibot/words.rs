//! The vocabulary of the DiMiBot.

use super::MAX_MODULES;
use crate::device::shape::ShapeForm;
use crate::device::words::words;
use crate::device::{
    Assay, Count, Frames, Need, Noun, OutcomeUnit, Planner, Range, Sort, Together, Verb, Vocabulary, VocabularyField,
    VocabularyPhrase, expansions, outcome, planner, verb,
};
use crate::quantity::Dimension;

words! {
    /// Objective.
    pub enum DimibotObjective {
        Distance = "distance": "the path length of the end-effector",
        Switches = "switches": "the number of module switchings",
        Time = "time": "the duration of the task",
        Energy = "energy": "the energy of the pulses",
    }
}

words! {
    /// An outcome of a plan.
    pub enum DimibotOutcome {
        Distance = "distance": "the path length of the end-effector",
        Switches = "switches": "the number of module switchings",
        Time = "time": "from the beginning of the task to the end of its last rest",
        Energy = "energy": "voltage times current times time, over all pulses",
    }
}

words! {
    /// Search method.
    pub enum DimibotMethod {
        StagedAstar = "staged_astar": "Tweeze's own: a greedy walk; where it is blocked, A* with the exact distance of the free lattice, then A* guided by distances between blocks of cells",
        Dijkstra = "dijkstra": "the paper's section 4.2",
        BidirectionalDijkstra = "bidirectional_dijkstra": "the paper's section 4.2, from both ends",
        Astar = "astar": "the paper's section 4.3: A* with the distance in the frame R1",
        HypercubeAstar = "hypercube_astar": "the paper's section 5: A* with the estimate of its algorithm 3",
    }
}

words! {
    /// Whether several modules may be switched in one pulse.
    pub enum Simultaneous {
        Never = "never": "one module at a time",
        Safe = "safe": "several in one pulse where no order and no partial stroke touches an obstacle",
    }
}

impl DimibotObjective {
    /// The outcome that it minimises.
    pub fn outcome(self) -> DimibotOutcome {
        match self {
            DimibotObjective::Distance => DimibotOutcome::Distance,
            DimibotObjective::Switches => DimibotOutcome::Switches,
            DimibotObjective::Time => DimibotOutcome::Time,
            DimibotObjective::Energy => DimibotOutcome::Energy,
        }
    }

    /// Unit of its cost in schedules and reports; empty for a count.
    pub fn unit(self) -> &'static str {
        match self {
            DimibotObjective::Distance => "um",
            DimibotObjective::Switches => "",
            DimibotObjective::Time => "ms",
            DimibotObjective::Energy => "mJ",
        }
    }

    /// Number of these units in one SI unit.
    pub fn units_per_si(self) -> f64 {
        match self {
            DimibotObjective::Distance => 1e6,
            DimibotObjective::Switches => 1.0,
            DimibotObjective::Time | DimibotObjective::Energy => 1e3,
        }
    }
}

impl DimibotOutcome {
    /// The objective that minimises the outcome.
    pub fn objective(self) -> DimibotObjective {
        match self {
            DimibotOutcome::Distance => DimibotObjective::Distance,
            DimibotOutcome::Switches => DimibotObjective::Switches,
            DimibotOutcome::Time => DimibotObjective::Time,
            DimibotOutcome::Energy => DimibotObjective::Energy,
        }
    }
}

const fn quantity(name: &'static str, dimension: Dimension, range: Range, doc: &'static str) -> VocabularyField {
    VocabularyField { name, sort: Sort::Quantity { dimension, range }, need: Need::Required, doc }
}

const fn count(name: &'static str, doc: &'static str) -> VocabularyField {
    VocabularyField { name, sort: Sort::Count { least: 1, most: MAX_MODULES }, need: Need::Required, doc }
}

const FIELDS: &[VocabularyField] = &[
    count("left", "modules on the left (bl), each moving the end-effector along x"),
    count("right", "modules on the right (br), each moving the end-effector along y"),
    quantity("stroke", Dimension::LENGTH, Range::Positive, "displacement of a module between its two states"),
    quantity(
        "gain",
        Dimension::NUMBER,
        Range::Positive,
        "end-effector displacement per stroke, a constant of the flexure structure",
    ),
    quantity("pulse_voltage", Dimension::VOLTAGE, Range::Positive, "voltage of a switching pulse"),
    quantity("pulse_current", Dimension::CURRENT, Range::Positive, "current of a switching pulse"),
    quantity(
        "pulse_duration",
        Dimension::TIME,
        Range::Positive,
        "length of a switching pulse; the module snaps at some instant within it",
    ),
    quantity("rest", Dimension::TIME, Range::NotNegative, "time after each pulse in which no module is switched"),
    quantity(
        "repeatability",
        Dimension::LENGTH,
        Range::NotNegative,
        "greatest distance of the end-effector from its nominal place",
    ),
    quantity("tip_radius", Dimension::LENGTH, Range::NotNegative, "radius of the tip in the working plane"),
    VocabularyField {
        name: "home",
        sort: Sort::State,
        need: Need::Optional("all modules at 0"),
        doc: "position of the robot before the first task",
    },
    VocabularyField {
        name: "simultaneous",
        sort: Sort::Word(Simultaneous::CHOICES),
        need: Need::Optional("never"),
        doc: "whether several modules may be switched in one pulse",
    },
];

const SETTINGS: &[VocabularyField] = &[
    VocabularyField {
        name: "precision",
        sort: Sort::Quantity { dimension: Dimension::LENGTH, range: Range::Positive },
        need: Need::Optional("any place in the workspace is assigned to its nearest cell"),
        doc: "greatest distance between a place and the cell assigned to it",
    },
    VocabularyField {
        name: "simultaneous",
        sort: Sort::Word(Simultaneous::CHOICES),
        need: Need::Optional("that of the device"),
        doc: "whether several modules may be switched in one pulse",
    },
];

words! {
    /// A step of a DiMiBot.
    pub enum DimibotVerb {
        Move = "move": "moves the end-effector to a cell or a place, via others in the order written",
        Visit = "visit": "visits these cells and places in the best order; the plan chooses where it ends",
    }
}

const VERBS: &[Verb] = &[
    Verb {
        phrases: &[
            VocabularyPhrase { preposition: "to", sort: Sort::Target, count: Count::Once },
            VocabularyPhrase { preposition: "via", sort: Sort::Target, count: Count::AnyNumber },
        ],
        example: "move to (3.2 um, 5.9 um) via (3, 9)",
        ..verb(DimibotVerb::Move.choice())
    },
    Verb {
        object: Some(Sort::Targets),
        example: "visit [(3, 9), (12, 4), (3.2 um, 5.9 um)]",
        ..verb(DimibotVerb::Visit.choice())
    },
];

const BUDGET: [VocabularyField; 1] =
    [expansions(20_000_000, "number of states the search may expand before it gives up")];

/// The planners, by the names that `using` takes and reports show.
pub const PLANNERS: &[Planner] = &[
    planner(DimibotMethod::StagedAstar.choice(), &BUDGET),
    planner(DimibotMethod::Dijkstra.choice(), &BUDGET),
    planner(DimibotMethod::BidirectionalDijkstra.choice(), &BUDGET),
    planner(DimibotMethod::Astar.choice(), &BUDGET),
    planner(DimibotMethod::HypercubeAstar.choice(), &BUDGET),
];

/// The vocabulary of the kind.
pub const VOCABULARY: Vocabulary = Vocabulary {
    name: "dimibot",
    summary: "a planar microrobot of bistable modules that switch one by one",
    library: ("std.dimibot", "dimibot.femto_st"),
    fields: FIELDS,
    nouns: &[Noun {
        name: "obstacle",
        doc: "an obstacle that the tip must not touch; a point if it has no shape",
        shapes: ShapeForm::SOLID,
    }],
    settings: SETTINGS,
    state: Some(Sort::State),
    together: Together::No("a dimibot has one end-effector, so there is nothing to move together"),
    assay: Assay::No,
    frames: Frames::Yes,
    verbs: VERBS,
    conditions: &[],
    objectives: DimibotObjective::CHOICES,
    planners: PLANNERS,
    outcomes: &[
        outcome(DimibotOutcome::Distance.choice(), OutcomeUnit::Micrometre),
        outcome(DimibotOutcome::Switches.choice(), OutcomeUnit::Count),
        outcome(DimibotOutcome::Time.choice(), OutcomeUnit::Nanosecond),
        outcome(DimibotOutcome::Energy.choice(), OutcomeUnit::Joule),
    ],
    channels: "<device>.bl<i>.set, <device>.bl<i>.reset, and likewise for br: the voltage on the actuator that brings the module to 1 or to 0",
};
