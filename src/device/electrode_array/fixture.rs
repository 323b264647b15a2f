//! Boards for tests.

use super::{DEFAULT_MIXER, ElectrodeArrayFacts, Electrodes, Hold, Layout, Separation};

/// A board for parts of four electrodes.
pub fn microparts(columns: u32, rows: u32) -> ElectrodeArrayFacts {
    ElectrodeArrayFacts {
        columns,
        rows,
        radius_um: 35.0,
        pitch_ratio: 0.7,
        potential_v: 100.0,
        step_ns: 5_000_000,
        layout: Layout { electrodes: Electrodes::Quad, half_width_pitches: 1.5 },
        hold: Hold::Off,
        dispense_ns: None,
        mixer: DEFAULT_MIXER,
        least_volume: None,
        most_volume: None,
        least_temperature_k: None,
        most_temperature_k: None,
        separation: Separation::Apart(4),
        clearance: 3,
        map: None,
        reservoirs: None,
    }
}

/// A board for droplets, with held electrodes.
pub fn droplets(columns: u32, rows: u32) -> ElectrodeArrayFacts {
    ElectrodeArrayFacts {
        layout: Layout { electrodes: Electrodes::Single, half_width_pitches: 0.5 },
        hold: Hold::On,
        separation: Separation::Apart(2),
        clearance: 1,
        ..microparts(columns, rows)
    }
}
