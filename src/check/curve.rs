//! Curves: an expression of the angle `t`, evaluated over a full turn.

use super::errors::{self, WantedName};
use crate::check::scope::{ANGLE_NAME, DeclarationSort, Scope};
use crate::check::value::Value;
use crate::check::{Checker, sorts};
use crate::device::{Range, Sort};
use crate::quantity::{Dimension, Quantity};
use crate::source::Spanned;
use crate::syntax::tree::{Expr, Ident};
use std::f64::consts::TAU;
use std::rc::Rc;

/// Number of angles at which a curve is evaluated.
pub const SAMPLES: usize = 1024;

impl Checker<'_> {
    /// The sampled lengths of a curve, in micrometres; `None` after an error.
    pub fn accept_curve(&mut self, expr: &Expr, scope: &Scope, wanted: &WantedName) -> Option<Value> {
        // Names of other sorts cannot occur in an expression.
        let own = self.modules[scope.module].names.get(ANGLE_NAME);
        let value =
            own.filter(|declaration| declaration.sort == DeclarationSort::Let).map(|declaration| declaration.span);
        if let Some(earlier) = scope.local(ANGLE_NAME).map(|local| local.span).or(value) {
            self.sink.push(errors::angle_name_taken(expr.span, earlier));
            return None;
        }
        if !self.charge_iterations(SAMPLES, expr.span) {
            return None;
        }
        let name = Ident { text: ANGLE_NAME.to_owned(), span: expr.span };
        let mut scope = scope.clone();
        let mut lengths_um = Vec::with_capacity(SAMPLES);
        for sample in 0..SAMPLES {
            let angle = Quantity::new(TAU * sample as f64 / SAMPLES as f64, Dimension::ANGLE);
            let angle = Spanned::new(Value::Quantity(angle), expr.span);
            let value = scope.with(&name, angle, |scope| self.evaluate(expr, scope));
            let sort = Sort::Quantity { dimension: Dimension::LENGTH, range: Range::Any };
            match sorts::judge(sort, &value, expr.span, wanted) {
                Ok(()) => {}
                Err(_) if value.is_unknown() => return None,
                Err(wrong) => {
                    self.sink.push(*wrong);
                    return None;
                }
            }
            if let Value::Quantity(length) = value {
                lengths_um.push(length.in_unit("um"));
            }
        }
        Some(Value::Curve(Rc::new(lengths_um)))
    }
}
