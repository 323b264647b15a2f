//! Curves: an expression of the angle `t`, worked out all the way round. Files of triangles, by their name.

use crate::check::errors::{self, Wanted};
use crate::check::scope::Scope;
use crate::check::value::Value;
use crate::check::{Checker, MAX_REPETITIONS};
use crate::device::{Range, Sort};
use crate::quantity::{Dimension, Quantity};
use crate::source::Spanned;
use crate::syntax::tree::{Expr, Ident};
use std::f64::consts::TAU;
use std::rc::Rc;

/// At how many angles a curve is worked out.
pub const SAMPLES: usize = 1024;

/// The name of the angle.
const ANGLE_NAME: &str = "t";

impl Checker<'_> {
    /// The lengths of a curve; `None` after an error.
    pub fn accept_curve(&mut self, expr: &Expr, scope: &Scope, wanted: &Wanted) -> Option<Value> {
        if let Some(earlier) = self.taken(ANGLE_NAME, scope) {
            self.sink.push(errors::angle_name_taken(expr.span, earlier));
            return None;
        }
        // Each angle counts as one turn of a loop, so that loops of curves have their end.
        self.repetitions += SAMPLES;
        if self.repetitions > MAX_REPETITIONS {
            self.sink.push(errors::too_many_repetitions(expr.span, MAX_REPETITIONS));
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
            match super::super::fields::judge(sort, &value, expr.span, wanted) {
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

    /// The triangles of a file that was read with the program; `None` after an error.
    pub fn accept_mesh(&mut self, expr: &Expr, _scope: &Scope, _wanted: &Wanted) -> Option<Value> {
        self.sink.push(errors::mesh_file_not_plain(expr.span));
        None
    }
}
