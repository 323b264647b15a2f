//! The vocabulary of the electrode array.

use super::{MAX_APART, MAX_CHANNEL, MAX_SIDE};
use crate::device::shape::ShapeForm;
use crate::device::words::words;
use crate::device::{
    Assay, BoardLimits, Count, DefaultFigure, Frames, MAX_EXPANSIONS, Need, Noun, Outcome, OutcomeUnit, Planner, Sort,
    Together, Verb, Vocabulary, VocabularyField, VocabularyPhrase, WordChoice, defaulted, not_negative, optional,
    outcome, planner, positive, required, verb,
};
use crate::quantity::Dimension;

words! {
    /// Objective.
    pub enum ElectrodeArrayObjective {
        Makespan = "makespan": "the steps until the last part has arrived",
        SumOfCosts = "sum_of_costs": "sum of the steps until each part's last arrival",
    }
}

words! {
    /// An outcome of a plan.
    pub enum ElectrodeArrayOutcome {
        Steps = "steps": "steps of the board until the last arrival",
        SumOfCosts = "sum_of_costs": "sum over all parts of the steps until a part's last arrival",
        Moves = "moves": "moves of parts from cell to cell",
        Time = "time": "from the beginning of the task to the end of its last step",
    }
}

words! {
    /// Search method.
    pub enum ElectrodeArrayMethod {
        Portfolio = "portfolio": "Tweeze's own: prioritised space-time search and repair for a first plan, large neighbourhood search for better ones, conflict-based search for the proof",
        CooperativeAstar = "cooperative_astar": "the paper's algorithm 1 with its heuristic of equation 12: greedy, so it may miss a plan",
        PlainCooperativeAstar = "plain_cooperative_astar": "the same with the plain heuristic of equation 13",
    }
}

words! {
    /// Sort of zone: what is under or over some electrodes of a board.
    pub enum ZoneSort {
        Heater = "heater": "electrodes that a heater keeps at one temperature; `at` or a shape of `cells` gives them",
        Detector = "detector": "electrodes under a reader, which reads one part at a time; `at` or a shape of `cells` gives them",
        Magnet = "magnet": "electrodes in the field of a magnet; `at` or a shape of `cells` gives them",
    }
}

impl ZoneSort {
    /// The operation that takes place in a zone of this sort.
    pub const fn verb(self) -> ElectrodeArrayVerb {
        match self {
            ZoneSort::Heater => ElectrodeArrayVerb::Heat,
            ZoneSort::Detector => ElectrodeArrayVerb::Detect,
            ZoneSort::Magnet => ElectrodeArrayVerb::Hold,
        }
    }

    const fn noun(self) -> Noun {
        Noun { name: self.name(), doc: self.choice().doc, shapes: &[ShapeForm::Cells] }
    }
}

impl ElectrodeArrayObjective {
    /// The outcome that it minimises.
    pub fn outcome(self) -> ElectrodeArrayOutcome {
        match self {
            ElectrodeArrayObjective::Makespan => ElectrodeArrayOutcome::Steps,
            ElectrodeArrayObjective::SumOfCosts => ElectrodeArrayOutcome::SumOfCosts,
        }
    }
}

impl ElectrodeArrayOutcome {
    /// The objective that minimises the outcome, if there is one. Moves have none: a plan with the least sum of costs
    /// may have more moves than another, as a step in which a part rests counts as much as one in which it moves.
    pub fn objective(self) -> Option<ElectrodeArrayObjective> {
        match self {
            ElectrodeArrayOutcome::Steps | ElectrodeArrayOutcome::Time => Some(ElectrodeArrayObjective::Makespan),
            ElectrodeArrayOutcome::SumOfCosts => Some(ElectrodeArrayObjective::SumOfCosts),
            ElectrodeArrayOutcome::Moves => None,
        }
    }
}

const SEPARATION: [WordChoice; 1] =
    [WordChoice { name: "as_published", doc: "Table 3 of the paper as printed; not safe everywhere" }];

const FORCES: [VocabularyField; 7] = [
    required("radius", positive(Dimension::LENGTH), "the electrode radius that the row is for"),
    required(
        "potential",
        positive(Dimension::VOLTAGE),
        "the potential of the row, which is the least that moves a part",
    ),
    required("permittivity", positive(Dimension::NUMBER), "the relative permittivity of the row's dielectric"),
    required("distance", positive(Dimension::LENGTH), "distance between centres for the row's forces"),
    required("vertical_force", not_negative(Dimension::FORCE), "the electrodes' pull towards the board"),
    required("weight", not_negative(Dimension::FORCE), "the weight of a part"),
    required("lateral_force", positive(Dimension::FORCE), "the electrodes' pull along the board"),
];

const FIELDS: &[VocabularyField] = &[
    required("columns", Sort::Count { least: 1, most: MAX_SIDE }, "electrodes along a row"),
    required("rows", Sort::Count { least: 1, most: MAX_SIDE }, "electrodes along a column"),
    optional(
        "channels",
        Sort::CountRows { most: MAX_CHANNEL },
        "every place has an electrode, without a number",
        "number of each electrode's channel on the driver, as a list for each row, the top row first; `none` where the board has no electrode; several electrodes may share a channel",
    ),
    optional(
        "map",
        Sort::Board(BoardLimits { most_channel: MAX_CHANNEL, most_side: MAX_SIDE }),
        "no file",
        "file with the electrodes of the board, instead of `channels`, `columns` and `rows`: from PurpleDrop or OpenDrop (JSON), or from MicroDrop (SVG)",
    ),
    optional("disabled", Sort::Cells, "all electrodes work", "electrodes that do not work"),
    required("radius", positive(Dimension::LENGTH), "radius of an electrode"),
    required(
        "pitch_ratio",
        positive(Dimension::NUMBER),
        "gap between the rims of neighbouring electrodes divided by their radius, d1",
    ),
    optional("least_pitch_ratio", positive(Dimension::NUMBER), "no limit", "the least `pitch_ratio` without arcing"),
    optional(
        "most_pitch_ratio",
        positive(Dimension::NUMBER),
        "no limit",
        "the greatest `pitch_ratio` at which a part still moves",
    ),
    required("potential", positive(Dimension::VOLTAGE), "potential of an electrode that is on"),
    optional(
        "least_potential",
        positive(Dimension::VOLTAGE),
        "what `forces` require",
        "measured least potential that moves a part",
    ),
    required(
        "step_duration",
        positive(Dimension::TIME),
        "duration of one move to a neighbouring cell, settling included",
    ),
    optional(
        "settling",
        not_negative(Dimension::TIME),
        "from the equation of motion if `forces` are given",
        "measured time from one cell until rest on the next",
    ),
    required("part", Sort::Shape(ShapeForm::Layout), "the layout of every part, seen from below"),
    optional(
        "hold",
        Sort::Flag,
        "false",
        "whether the electrodes that brought a part to its cell stay on while it rests; all are off while no task runs, also while a `program` waits between tasks (W0512)",
    ),
    optional(
        "dispense_duration",
        positive(Dimension::TIME),
        "it has no reservoirs",
        "time in which a reservoir without `dispense_frames` dispenses one droplet onto the electrode at its outlet, which is on meanwhile",
    ),
    optional("outlets", Sort::Cells, "reservoirs may be anywhere", "the electrodes at the outlets of its reservoirs"),
    optional(
        "dispense_frames",
        Sort::CountTables { most: MAX_CHANNEL },
        "reservoirs work without the board",
        "for each outlet the frames that dispense a droplet, each a list of the driver's channels that are on: pads of the reservoir, and the electrode at the outlet",
    ),
    optional(
        "dispense_frame_duration",
        positive(Dimension::TIME),
        "none; required with `dispense_frames`",
        "time from one of these frames to the next, rounded up to whole steps of the board",
    ),
    optional(
        "mixer",
        Sort::Cell,
        "(2, 2)",
        "columns and rows of the loop around which a droplet is moved to mix it, each at least 2",
    ),
    optional(
        "least_volume",
        positive(Dimension::NUMBER),
        "no limit",
        "the smallest droplet that can be moved, in droplets as reservoirs dispense them",
    ),
    optional(
        "most_volume",
        positive(Dimension::NUMBER),
        "no limit",
        "the largest droplet that one electrode can hold, in droplets as reservoirs dispense them",
    ),
    optional("least_temperature", positive(Dimension::TEMPERATURE), "0 degC", "the lowest temperature of its heaters"),
    optional(
        "most_temperature",
        positive(Dimension::TEMPERATURE),
        "no limit",
        "the highest temperature of its heaters",
    ),
    required(
        "separation",
        Sort::CountOrWord { least: 1, most: MAX_APART, words: &SEPARATION },
        "least distance between the centres of two parts, in electrodes along columns or rows",
    ),
    required(
        "clearance",
        Sort::Count { least: 1, most: MAX_APART },
        "least distance from a centre to an electrode under an obstacle, in electrodes",
    ),
    optional("forces", Sort::Table(&FORCES), "forces are not checked", "forces on a part, by electrode radius"),
    optional(
        "permittivity",
        positive(Dimension::NUMBER),
        "that of `forces`",
        "relative permittivity of the dielectric on the board; forces increase with it",
    ),
    defaulted(
        "friction",
        not_negative(Dimension::NUMBER),
        DefaultFigure::new(0.0, ""),
        "coefficient of static friction of a part on the board",
    ),
    defaulted(
        "peak_distance",
        positive(Dimension::NUMBER),
        // Figure 7 of the paper on microparts.
        DefaultFigure::new(1.0, ""),
        "distance between centres, divided by the radius, at which an electrode pulls hardest",
    ),
    defaulted(
        "rest_share",
        positive(Dimension::NUMBER),
        DefaultFigure::new(2.0, "%"),
        "share of the pitch, and of the greatest speed, within which a part counts as at rest",
    ),
    optional("density", positive(Dimension::DENSITY), "from `mass`", "density of a part, a plate half a radius thick"),
    optional("mass", positive(Dimension::MASS), "from `density`", "measured mass of a part"),
    optional("viscosity", positive(Dimension::VISCOSITY), "from `damping`", "viscosity of the liquid under the parts"),
    optional("damping", positive(Dimension::DAMPING), "by `viscosity`", "measured drag divided by speed"),
];

const SETTINGS: &[VocabularyField] = &[VocabularyField {
    name: "may_yield",
    sort: Sort::Flag,
    need: Need::Optional("false"),
    doc: "whether parts without a goal may step aside and return",
}];

/// The word before a name that stands for all parts of that name with an index.
pub const ANY: &str = "any";

/// Begins once another part has done all that is written above for it.
const AFTER: VocabularyPhrase =
    VocabularyPhrase { preposition: "after", sort: Sort::Object("part"), count: Count::AnyNumber };

/// Longest time between the end of what the operation comes after and its own begin.
const WITHIN: VocabularyPhrase =
    VocabularyPhrase { preposition: "within", sort: positive(Dimension::TIME), count: Count::AtMostOnce };

/// At a cell; excluded by `among`.
const AT: VocabularyPhrase =
    VocabularyPhrase { preposition: "at", sort: Sort::Cell, count: Count::OnceUnless("among") };

/// At one of several cells; the plan chooses which.
const AMONG: VocabularyPhrase = VocabularyPhrase { preposition: "among", sort: Sort::Cells, count: Count::AtMostOnce };

/// In a zone of a sort; excluded by `among`.
const fn at_site(sort: ZoneSort) -> VocabularyPhrase {
    VocabularyPhrase { preposition: "at", sort: Sort::Site(sort.name()), count: Count::OnceUnless("among") }
}

/// In one of several zones; the plan chooses which.
const fn among_sites(sort: ZoneSort) -> VocabularyPhrase {
    VocabularyPhrase { preposition: "among", sort: Sort::Sites(sort.name()), count: Count::AtMostOnce }
}

/// Where the part is, or at a cell, for at least a time.
const FOR_A_TIME: [VocabularyPhrase; 5] = [
    VocabularyPhrase { preposition: "at", sort: Sort::Cell, count: Count::AtMostOnce },
    AMONG,
    VocabularyPhrase { preposition: "for", sort: positive(Dimension::TIME), count: Count::Once },
    AFTER,
    WITHIN,
];

/// In a zone for at least a time.
const IN_DETECTOR: [VocabularyPhrase; 5] = [
    at_site(ZoneSort::Detector),
    among_sites(ZoneSort::Detector),
    VocabularyPhrase { preposition: "for", sort: positive(Dimension::TIME), count: Count::Once },
    AFTER,
    WITHIN,
];
const IN_MAGNET: [VocabularyPhrase; 5] = [
    at_site(ZoneSort::Magnet),
    among_sites(ZoneSort::Magnet),
    VocabularyPhrase { preposition: "for", sort: positive(Dimension::TIME), count: Count::Once },
    AFTER,
    WITHIN,
];

words! {
    /// A step of a board.
    pub enum ElectrodeArrayVerb {
        Move = "move": "moves a part to a cell, via others in the order written",
        Dispense = "dispense": "dispenses a droplet onto the electrode at a reservoir's outlet, with the device's `dispense_frames` or in its `dispense_duration`",
        Merge = "merge": "merges two droplets at a cell; from then on, the first name stands for both",
        Split = "split": "pulls a droplet apart into two halves at a cell: the new droplet is at the neighbouring cell after `to`, or without `to` in the next column, and the other half goes to the opposite side",
        Mix = "mix": "moves a droplet around the device's mixing loop (`mixer`), anticlockwise, in whole rounds, for at least this time; where it is, or the cell after `at`, is the loop's corner with the least column and row, where the droplet also ends",
        Incubate = "incubate": "keeps a part where it is, or at a cell, for at least this time: to react, to be heated, to be read",
        Heat = "heat": "keeps a part at a heater, at its middle or at one of its cells, for at least this time; the heater has that temperature throughout the program",
        Detect = "detect": "keeps a part at a detector, at its middle or at one of its cells, for at least this time, with no other part there meanwhile",
        Hold = "hold": "keeps a part at a magnet, at its middle or at one of its cells, for at least this time, until the magnet holds the beads in it",
        Discard = "discard": "removes a part from the board at a cell, such as a port or an open rim; its name is invalid from then on",
    }
}

impl ElectrodeArrayVerb {
    /// Whether it does anything to a droplet besides moving it: steps of such verbs are planned as an assay.
    pub fn is_operation(self) -> bool {
        match self {
            ElectrodeArrayVerb::Move | ElectrodeArrayVerb::Merge => false,
            ElectrodeArrayVerb::Dispense
            | ElectrodeArrayVerb::Split
            | ElectrodeArrayVerb::Mix
            | ElectrodeArrayVerb::Incubate
            | ElectrodeArrayVerb::Heat
            | ElectrodeArrayVerb::Detect
            | ElectrodeArrayVerb::Hold
            | ElectrodeArrayVerb::Discard => true,
        }
    }

    /// The sort of zone in which the operation takes place.
    pub fn zone(self) -> Option<ZoneSort> {
        ZoneSort::ALL.iter().copied().find(|sort| sort.verb() == self)
    }
}

const VERBS: &[Verb] = &[
    Verb {
        object: Some(Sort::Object("part")),
        phrases: &[
            VocabularyPhrase { preposition: "to", sort: Sort::Cell, count: Count::Once },
            VocabularyPhrase { preposition: "via", sort: Sort::Cell, count: Count::AnyNumber },
            AFTER,
            WITHIN,
        ],
        example: "move m1 to (26, 31) via (5, 20)",
        ..verb(ElectrodeArrayVerb::Move.choice())
    },
    Verb {
        noun: Some(ANY),
        object: Some(Sort::Object("part")),
        phrases: &[VocabularyPhrase { preposition: "to", sort: Sort::Cells, count: Count::Once }],
        doc: "moves all parts of an indexed name, such as `m[0]` and `m[1]`, to as many cells; the plan chooses which part goes to which cell",
        example: "move any m to [(5, 20), (9, 20), (13, 20)]",
        ..verb(ElectrodeArrayVerb::Move.choice())
    },
    Verb {
        object: Some(Sort::Object("part")),
        phrases: &[
            VocabularyPhrase { preposition: "from", sort: Sort::Object("reservoir"), count: Count::Once },
            AFTER,
            WITHIN,
        ],
        example: "dispense sample from serum",
        ..verb(ElectrodeArrayVerb::Dispense.choice())
    },
    Verb {
        object: Some(Sort::Object("part")),
        phrases: &[
            VocabularyPhrase { preposition: "with", sort: Sort::Object("part"), count: Count::Once },
            AT,
            AMONG,
            AFTER,
            WITHIN,
        ],
        example: "merge sample with reagent at (7, 4)",
        ..verb(ElectrodeArrayVerb::Merge.choice())
    },
    Verb {
        object: Some(Sort::Object("part")),
        phrases: &[
            VocabularyPhrase { preposition: "from", sort: Sort::Object("part"), count: Count::Once },
            VocabularyPhrase { preposition: "at", sort: Sort::Cell, count: Count::Once },
            VocabularyPhrase { preposition: "to", sort: Sort::Cell, count: Count::AtMostOnce },
            AFTER,
            WITHIN,
        ],
        example: "split half from sample at (7, 4) to (7, 5)",
        ..verb(ElectrodeArrayVerb::Split.choice())
    },
    Verb {
        object: Some(Sort::Object("part")),
        phrases: &FOR_A_TIME,
        example: "mix sample at (8, 5) for 3 s",
        ..verb(ElectrodeArrayVerb::Mix.choice())
    },
    Verb {
        object: Some(Sort::Object("part")),
        phrases: &FOR_A_TIME,
        example: "incubate sample at (8, 5) for 30 s",
        ..verb(ElectrodeArrayVerb::Incubate.choice())
    },
    Verb {
        object: Some(Sort::Object("part")),
        phrases: &[
            at_site(ZoneSort::Heater),
            among_sites(ZoneSort::Heater),
            VocabularyPhrase { preposition: "to", sort: positive(Dimension::TEMPERATURE), count: Count::Once },
            VocabularyPhrase { preposition: "for", sort: positive(Dimension::TIME), count: Count::Once },
            AFTER,
            WITHIN,
        ],
        example: "heat sample at oven to 95 degC for 30 s",
        ..verb(ElectrodeArrayVerb::Heat.choice())
    },
    Verb {
        object: Some(Sort::Object("part")),
        phrases: &IN_DETECTOR,
        example: "detect sample at reader for 5 s",
        ..verb(ElectrodeArrayVerb::Detect.choice())
    },
    Verb {
        object: Some(Sort::Object("part")),
        phrases: &IN_MAGNET,
        example: "hold beads at pull for 3 s",
        ..verb(ElectrodeArrayVerb::Hold.choice())
    },
    Verb {
        object: Some(Sort::Object("part")),
        phrases: &[AT, AMONG, AFTER, WITHIN],
        example: "discard sample at (16, 1)",
        ..verb(ElectrodeArrayVerb::Discard.choice())
    },
];

const CONDITIONS: &[Verb] = &[
    Verb {
        name: "avoid",
        noun: None,
        object: Some(Sort::Object("fluid")),
        phrases: &[VocabularyPhrase { preposition: "in", sort: Sort::Object("fluid"), count: Count::Once }],
        block: None,
        doc: "keeps traces of one fluid out of another: a droplet that contains the second but not the first may not enter an electrode where the first has been, unless the electrode was washed in between",
        example: "avoid blood in serum",
    },
    Verb {
        name: "wash",
        noun: None,
        object: None,
        phrases: &[
            VocabularyPhrase { preposition: "with", sort: Sort::Object("fluid"), count: Count::Once },
            VocabularyPhrase { preposition: "to", sort: Sort::Cell, count: Count::AtMostOnce },
        ],
        block: None,
        doc: "declares a wash fluid: droplets of it alone remove traces from the electrodes they visit; with a cell after `to`, wash droplets are added where needed and leave at that cell",
        example: "wash with water to (16, 2)",
    },
];

const BUDGET: [VocabularyField; 1] = [VocabularyField {
    name: "expansions",
    sort: Sort::Count { least: 1, most: MAX_EXPANSIONS },
    need: Need::Optional("16 million, 2 more for each part and cell, at most 64 million"),
    doc: "number of states the search of one step may expand before it gives up",
}];

const PLANNERS: &[Planner] = &[
    planner(ElectrodeArrayMethod::Portfolio.choice(), &BUDGET),
    planner(ElectrodeArrayMethod::CooperativeAstar.choice(), &BUDGET),
    planner(ElectrodeArrayMethod::PlainCooperativeAstar.choice(), &BUDGET),
];

const OUTCOMES: &[Outcome] = &[
    outcome(ElectrodeArrayOutcome::Steps.choice(), OutcomeUnit::Count),
    outcome(ElectrodeArrayOutcome::SumOfCosts.choice(), OutcomeUnit::Count),
    outcome(ElectrodeArrayOutcome::Moves.choice(), OutcomeUnit::Count),
    outcome(ElectrodeArrayOutcome::Time.choice(), OutcomeUnit::Nanosecond),
];

words! {
    /// A noun of a board's scene that is not a zone.
    pub enum BoardNoun {
        Obstacle = "obstacle": "electrodes that no part may come near: a block, one cell, or a part that is stuck",
        Part = "part": "a part that the electrodes carry; without `at` a droplet that a reservoir dispenses",
        Reservoir = "reservoir": "a store of liquid; `at` gives the electrode at its outlet",
    }
}

/// The vocabulary of the kind.
pub const VOCABULARY: Vocabulary = Vocabulary {
    name: "electrode_array",
    summary: "a board of electrodes that carries many parts or droplets at once",
    library: ("std.electrode_array", "electrode_array.smart_platform"),
    fields: FIELDS,
    nouns: &[
        Noun::of(BoardNoun::Obstacle.choice(), &[ShapeForm::Cells, ShapeForm::Layout]),
        Noun::of(BoardNoun::Part.choice(), &[ShapeForm::Layout]),
        Noun::of(BoardNoun::Reservoir.choice(), &[]),
        ZoneSort::Heater.noun(),
        ZoneSort::Detector.noun(),
        ZoneSort::Magnet.noun(),
    ],
    settings: SETTINGS,
    state: None,
    together: Together::Yes,
    assay: Assay::Yes,
    frames: Frames::No,
    verbs: VERBS,
    conditions: CONDITIONS,
    objectives: ElectrodeArrayObjective::CHOICES,
    planners: PLANNERS,
    outcomes: OUTCOMES,
    channels: "<device>.e<column>_<row>: the voltage on an electrode, or on all that share its channel",
};
