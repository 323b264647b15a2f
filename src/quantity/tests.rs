use super::*;

fn quantity(digits: &str, unit: &str) -> Quantity {
    Unit::parse(unit).expect("a unit").of(digits).expect("a finite quantity")
}

#[test]
fn a_prefix_is_applied_before_rounding() {
    assert_eq!(quantity("35", "um").si, 35e-6);
    assert_eq!(quantity("0.8", "um").si, 0.8e-6);
    assert_eq!(quantity("1e-3", "mm").si, 1e-6);
    assert_eq!(quantity("15", "ms").in_unit("ns"), 15e6);
    assert_eq!(quantity("35", "um").in_unit("um"), 35.0);
}

#[test]
fn both_micro_signs_are_u() {
    assert_eq!(quantity("3", "um"), quantity("3", "µm"));
    assert_eq!(quantity("3", "um"), quantity("3", "μm"));
}

#[test]
fn compound_units_follow_their_signs() {
    assert_eq!(quantity("35", "um/s").dimension, Dimension::SPEED);
    assert_eq!(quantity("3", "N*m").dimension, Dimension::ENERGY);
    assert_eq!(quantity("2", "s^-1").dimension, Dimension::FREQUENCY);
    assert_eq!(quantity("1", "J/m/m").dimension, Dimension::FORCE.over(Dimension::LENGTH).expect("small"));
    assert_eq!(quantity("2", "mm^2").si, 2e-6);
}

#[test]
fn a_gram_is_a_thousandth_of_the_base_unit() {
    assert_eq!(quantity("1", "g").si, 1e-3);
    assert_eq!(quantity("1", "kg").si, 1.0);
    assert_eq!(quantity("2.5", "ug").to_string(), "2.5 ug");
}

#[test]
fn an_unknown_unit_names_its_neighbour() {
    assert_eq!(Unit::parse("UM"), Err(UnitError::Unknown { part: "UM".to_owned(), nearest: Some("um".to_owned()) }));
    assert_eq!(Unit::parse("parsec"), Err(UnitError::Unknown { part: "parsec".to_owned(), nearest: None }));
    assert_eq!(Unit::parse("m^99"), Err(UnitError::ExponentTooLarge));
    assert!(Unit::parse("").is_err());
}

#[test]
fn overflow_is_no_quantity() {
    assert_eq!(Unit::parse("m").expect("metre").of("1e999"), None);
    assert_eq!(Unit::parse("m").expect("metre").of("1e99999999999"), None);
}

#[test]
fn printing_takes_the_prefix_that_fits() {
    assert_eq!(quantity("0.8", "um").to_string(), "800 nm");
    assert_eq!(quantity("400", "ms").to_string(), "400 ms");
    assert_eq!(quantity("1000", "um").to_string(), "1 mm");
    assert_eq!(quantity("999.9999999", "um").to_string(), "1 mm");
    assert_eq!(quantity("0", "V").to_string(), "0 V");
    assert_eq!(quantity("0", "m").to_string(), "0 um");
    assert_eq!(quantity("1497.3", "s").to_string(), "1497.3 s");
    assert_eq!(quantity("80", "deg").to_string(), "80 deg");
    assert_eq!(Quantity::number(0.138).to_string(), "0.138");
    assert_eq!(quantity("3", "m^2").to_string(), "3 m^2");
}

#[test]
fn dimensions_have_names() {
    assert_eq!(Dimension::LENGTH.with_article(), "a length");
    assert_eq!(Dimension::ENERGY.name(), "energy");
    assert_eq!(Dimension::LENGTH.power(2).expect("small").with_article(), "a quantity in m^2");
}

#[test]
fn compound_quantities_print_in_the_units_that_people_write() {
    let shown = |si: f64, dimension: Dimension| Quantity::new(si, dimension).to_string();
    assert_eq!(shown(1180.0, Dimension::DENSITY), "1180 kg/m^3");
    assert_eq!(shown(0.005, Dimension::VISCOSITY), "5 mPa*s");
    assert_eq!(shown(2e-6, Dimension::DAMPING), "2 uN*s/m");
    assert_eq!(quantity("3.7", "deg/mm").to_string(), "3.7 deg/mm");
    assert!(["kg/m^3", "Pa*s", "uN*s/m"].into_iter().all(|unit| Unit::parse(unit).is_ok()));
}

#[test]
fn degrees_celsius_count_from_a_zero_of_their_own() {
    let of = |digits: &str, unit: &str| Unit::parse(unit).unwrap().of(digits).unwrap();
    assert_eq!(of("60", "degC"), Quantity::new(333.15, Dimension::TEMPERATURE));
    assert_eq!(of("-5", "degC"), Quantity::new(268.15, Dimension::TEMPERATURE));
    assert_eq!(of("95", "degC").to_string(), "95 degC");
    assert_eq!(of("300", "K").to_string(), "26.85 degC");
    assert_eq!(of("37", "degC").in_unit("degC"), 37.0);
    // In products a temperature is a difference, for which the zero does not matter.
    let unknown =
        |text: &str| matches!(Unit::parse(text), Err(UnitError::Unknown { nearest: Some(near), .. }) if near == "K");
    assert!(unknown("degC/s") && unknown("W/degC") && unknown("degC^2"));
}

#[test]
fn figures_are_rounded_to_the_side_on_which_they_stay_true() {
    for (value, digits, less, nearest, more) in [
        (0.0123449, 4, 0.01234, 0.01234, 0.01235),
        (98.76, 2, 98.0, 99.0, 99.0),
        (99.96, 3, 99.9, 100.0, 100.0),
        (1234.5, 2, 1200.0, 1200.0, 1300.0),
        // Rounding errors of arithmetic do not count as further digits.
        (0.1 + 0.2, 2, 0.3, 0.3, 0.3),
        (50.000_000_000_1, 3, 50.0, 50.0, 50.0),
        (49.999_999_999_9, 3, 50.0, 50.0, 50.0),
        (0.0, 3, 0.0, 0.0, 0.0),
    ] {
        let rounded = (round_down(value, digits), significant(value, digits), round_up(value, digits));
        assert_eq!(rounded, (less, nearest, more), "{value}");
    }
    assert_eq!((to_decimals(12.345_678, 2), to_decimals(-0.000_05, 4), to_decimals(3.0, 0)), (12.35, -0.000_1, 3.0));
}
