use super::*;

/// The published robot with its published figures; tip and rest are idealised.
pub fn femto_st(left: u32, right: u32) -> DimibotFacts {
    DimibotFacts {
        left,
        right,
        stroke_um: 35.0,
        gain: 0.138,
        pulse_voltage_v: 20.0,
        pulse_current_a: 0.1,
        pulse_duration_ns: 15_000_000,
        rest_ns: 0,
        repeatability_um: 0.09,
        tip_radius_um: 0.0,
        home: LatticeCell::default(),
        simultaneous: Simultaneous::Never,
    }
}

#[test]
fn resolutions_follow_equation_2() {
    for (modules, expected_um) in [(2, 3.415), (3, 1.7076), (6, 0.213_45), (13, 0.001_667_6)] {
        let pitch_um = femto_st(modules, modules).pitch_um(Side::Left);
        assert!((pitch_um / expected_um - 1.0).abs() < 1e-3, "{modules} modules: {pitch_um} um");
    }
}

#[test]
fn the_matrix_turned_by_45_degrees_is_the_lattice() {
    for (left, right) in [(1, 1), (2, 2), (3, 5), (6, 4), (20, 20)] {
        let facts = femto_st(left, right);
        let (last_x, last_y) = (facts.cells(Side::Left) - 1, facts.cells(Side::Right) - 1);
        for cell in [(0, 0), (1, 0), (0, 1), (last_x, last_y), (last_x / 3, last_y / 2)] {
            let cell = LatticeCell { x: cell.0, y: cell.1 };
            let turned = DimibotFacts::workspace_frame() * facts.displacement_um(cell);
            let [x_um, y_um] = facts.place_um(cell);
            assert!((turned.x - x_um).abs() < 1e-9 && (turned.y - y_um).abs() < 1e-9, "{cell}: {turned} {x_um} {y_um}");
        }
    }
}

#[test]
fn a_word_and_its_cell_are_one() {
    let facts = femto_st(5, 5);
    assert_eq!(facts.cell(0b10001_00010), LatticeCell { x: 17, y: 2 });
    assert_eq!(facts.word(LatticeCell { x: 17, y: 2 }), 546);
    assert_eq!(facts.word_text(LatticeCell { x: 17, y: 2 }), "0b10001_00010");
    let uneven = femto_st(2, 3);
    assert_eq!(uneven.word_text(uneven.cell(0b01_101)), "0b01_101");
}

#[test]
fn the_inverse_is_checked_against_the_range() {
    let facts = femto_st(2, 2);
    let pitch_um = facts.pitch_um(Side::Left);
    assert_eq!(facts.nearest_cell([3.49 * pitch_um, 0.0]), Some(LatticeCell { x: 3, y: 0 }));
    assert_eq!(facts.nearest_cell([3.51 * pitch_um, 0.0]), None);
    assert_eq!(facts.nearest_cell([-0.51 * pitch_um, 0.0]), None);
    assert_eq!(facts.clamped_cell([99.0, -99.0]), LatticeCell { x: 3, y: 0 });
}

#[test]
fn a_switch_costs_30_millijoules() {
    assert!((femto_st(2, 2).switch_energy_j() - 0.030).abs() < 1e-12);
}
