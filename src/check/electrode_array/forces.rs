//! Driving and holding forces on a part, from the table of forces.
//!
//! Between two radii of the table every figure is interpolated linearly. Electrostatic forces grow with the
//! permittivity and with the square of the potential, which is exact for one dielectric and a first approximation for
//! several layers.

use super::motion::Pull;
use crate::check::value::Accepted;
use crate::check::value::{TableValue, Value};
use crate::real::Real;
use crate::source::Span;

/// Row of the force table for one electrode radius, in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceRow {
    pub radius_m: f64,
    pub potential_v: f64,
    pub permittivity: f64,
    pub distance_m: f64,
    pub vertical_n: f64,
    pub weight_n: f64,
    pub lateral_n: f64,
}

impl ForceRow {
    /// Interpolates between this row and another, `share` of the way.
    fn towards(&self, other: &ForceRow, share: f64) -> ForceRow {
        let mix = |own: f64, other: f64| own + (other - own) * share;
        ForceRow {
            radius_m: mix(self.radius_m, other.radius_m),
            potential_v: mix(self.potential_v, other.potential_v),
            permittivity: mix(self.permittivity, other.permittivity),
            distance_m: mix(self.distance_m, other.distance_m),
            vertical_n: mix(self.vertical_n, other.vertical_n),
            weight_n: mix(self.weight_n, other.weight_n),
            lateral_n: mix(self.lateral_n, other.lateral_n),
        }
    }
}

/// The force table, sorted by radius.
pub struct RadiusTable {
    rows: Vec<ForceRow>,
    pub span: Span,
}

/// Why a table cannot be interpolated: two rows have the same radius.
pub struct Repeated {
    pub radius_m: f64,
    pub first: Span,
    pub second: Span,
}

impl RadiusTable {
    /// Reads the field `forces`, if given.
    pub fn of(fields: &Accepted) -> Option<Result<RadiusTable, Repeated>> {
        let field = fields.get("forces")?;
        let Value::Table(table) = &field.value else { return None };
        let mut rows: Vec<(ForceRow, Span)> =
            table.rows.iter().enumerate().map(|(index, cells)| (row(table, index), cells[0].span)).collect();
        rows.sort_by(|(one, _), (other, _)| one.radius_m.total_cmp(&other.radius_m));
        let repeated = rows.windows(2).find(|pair| pair[0].0.radius_m == pair[1].0.radius_m);
        Some(match repeated {
            Some([one, other]) => {
                let (first, second) = if one.1.start <= other.1.start { (one.1, other.1) } else { (other.1, one.1) };
                Err(Repeated { radius_m: one.0.radius_m, first, second })
            }
            Some(_) | None => {
                Ok(RadiusTable { rows: rows.into_iter().map(|(row, _)| row).collect(), span: field.span })
            }
        })
    }

    /// The least and the greatest radius of the table.
    pub fn radii_m(&self) -> [f64; 2] {
        let radius = |row: Option<&ForceRow>| row.map_or(0.0, |row| row.radius_m);
        [radius(self.rows.first()), radius(self.rows.last())]
    }

    /// The interpolated row of a radius; `None` outside the table.
    pub fn at(&self, radius_m: f64) -> Option<ForceRow> {
        let above = self.rows.iter().position(|row| row.radius_m >= radius_m)?;
        let upper = self.rows[above];
        if upper.radius_m == radius_m {
            return Some(upper);
        }
        let lower = self.rows.get(above.checked_sub(1)?)?;
        Some(lower.towards(&upper, (radius_m - lower.radius_m) / (upper.radius_m - lower.radius_m)))
    }
}

fn row(table: &TableValue, index: usize) -> ForceRow {
    let si = |name: &str| {
        let column = table.columns.iter().position(|(column, _)| column == name);
        match column.and_then(|column| table.rows[index].get(column)).map(|cell| &cell.value) {
            Some(Value::Quantity(quantity)) => quantity.si,
            _ => 0.0,
        }
    };
    ForceRow {
        radius_m: si("radius"),
        potential_v: si("potential"),
        permittivity: si("permittivity"),
        distance_m: si("distance"),
        vertical_n: si("vertical_force"),
        weight_n: si("weight"),
        lateral_n: si("lateral_force"),
    }
}

/// Forces on a part that leaves its cell, one pitch from its goal.
#[derive(Debug, Clone, Copy)]
pub struct Forces {
    row: ForceRow,
    /// The row's force along the board, as a function of distance.
    pull: Pull,
    pitch_m: f64,
    permittivity: f64,
    friction: f64,
}

impl Forces {
    /// Forces of a row on a board of the given pitch, permittivity and friction; `peak_at_m` is the distance at which
    /// an electrode pulls hardest.
    pub fn new(row: ForceRow, pitch_m: f64, peak_at_m: f64, permittivity: Option<f64>, friction: f64) -> Forces {
        let pull = Pull::through(row.distance_m, row.lateral_n, peak_at_m);
        Forces { row, pull, pitch_m, permittivity: permittivity.unwrap_or(row.permittivity), friction }
    }

    /// The potential at which the forces equal those of the row.
    pub fn needed_v(&self) -> f64 {
        self.row.potential_v * (self.row.permittivity / self.permittivity).sqrt()
    }

    fn growth(&self, potential_v: f64) -> f64 {
        self.permittivity / self.row.permittivity * (potential_v / self.row.potential_v).whole_power(2)
    }

    /// Force along the board at a potential.
    pub fn pull(&self, potential_v: f64) -> Pull {
        Pull { peak_n: self.pull.peak_n * self.growth(potential_v), ..self.pull }
    }

    /// Force along the board where the part leaves its cell.
    pub fn lateral_n(&self, potential_v: f64) -> f64 {
        self.pull(potential_v).at(self.pitch_m)
    }

    /// Static friction: the coefficient times the sum of vertical force and weight.
    pub fn friction_n(&self, potential_v: f64) -> f64 {
        self.friction * (self.row.vertical_n * self.growth(potential_v) + self.row.weight_n)
    }

    /// Net force that moves the part; at most 0 where friction holds it.
    pub fn net_n(&self, potential_v: f64) -> f64 {
        self.lateral_n(potential_v) - self.friction_n(potential_v)
    }

    /// The potential at which pull and friction are equal, if there is one: both grow with its square, except for the
    /// weight.
    pub fn balance_v(&self) -> Option<f64> {
        let at_row_v = self.row.potential_v;
        let gain_n = self.lateral_n(at_row_v) - self.friction * self.row.vertical_n * self.growth(at_row_v);
        let balance_v = at_row_v * (self.friction * self.row.weight_n / gain_n).sqrt();
        (gain_n > 0.0 && balance_v.is_finite()).then_some(balance_v)
    }

    /// The coefficient of friction at which pull and friction are equal.
    pub fn balance_friction(&self, potential_v: f64) -> f64 {
        self.lateral_n(potential_v) / (self.row.vertical_n * self.growth(potential_v) + self.row.weight_n)
    }
}
