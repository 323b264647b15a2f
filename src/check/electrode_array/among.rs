//! Places among which the plan chooses: `mix a among [(2, 2), (7, 2)] for 3 s`.

use super::errors;
use super::goals::{BoardStepJudge, phrases};
use crate::check::lets::Argument;
use crate::check::value::Value;
use crate::check::verbs::Call;
use crate::claims::electrode_array::{AssayOperation, ElectrodeArrayStop, OperationPlace, ZoneSort};
use crate::device::electrode_array::{ElectrodeCell, MAX_PLACES};
use crate::source::Span;
use std::collections::BTreeMap;

impl BoardStepJudge<'_> {
    /// The candidate places of an operation: the one after `at`, or those after `among`; empty if it happens where its
    /// part is. `None` after an error.
    pub(super) fn places(&mut self, call: &Call, sort: Option<ZoneSort>) -> Option<Vec<OperationPlace>> {
        let at = phrases(call, "at").next();
        let Some(among) = phrases(call, "among").next() else {
            return at.map_or(Some(Vec::new()), |at| Some(vec![self.place(at, sort)?]));
        };
        self.sink.push_if_some(at.map(|at| errors::at_and_among(call.verb, at.span, among.span)))?;
        let Value::List(list) = &among.value else { return None };
        let argument = |value: &Value, span| Argument { value: value.clone(), span, origin: None };
        let places: Vec<Option<OperationPlace>> =
            list.iter().map(|element| self.place(&argument(&element.value, element.span), sort)).collect();
        let places: Vec<OperationPlace> = places.into_iter().collect::<Option<_>>()?;
        let mut seen: BTreeMap<(u32, u32), Span> = BTreeMap::new();
        let again = places.iter().find_map(|OperationPlace { stop, .. }| {
            let ElectrodeCell { column, row } = stop.cell;
            Some((stop, seen.insert((column, row), stop.span)?))
        });
        let wrong = match again {
            _ if places.is_empty() => Some(errors::among_nothing(among.span)),
            _ if places.len() > MAX_PLACES => Some(errors::among_too_many(among.span, places.len())),
            Some((stop, first)) => Some(errors::among_one_twice(stop, first)),
            None => None,
        };
        among.unless(wrong, self.sink)?;
        Some(places)
    }

    fn place(&mut self, target: &Argument, sort: Option<ZoneSort>) -> Option<OperationPlace> {
        let Some(sort) = sort else { return Some(OperationPlace { stop: self.stop(target)?, zone: None }) };
        let (zone, stop) = self.zone_stop(target, sort)?;
        Some(OperationPlace { stop, zone: Some(zone) })
    }

    /// An operation at one of several places that the plan chooses, or at the only one.
    pub(super) fn at_one_of(operation: AssayOperation, places: Vec<OperationPlace>) -> AssayOperation {
        let stops: Vec<ElectrodeArrayStop> = places.first().map(|place| place.stop.clone()).into_iter().collect();
        let among = if places.len() > 1 { places } else { Vec::new() };
        AssayOperation { stops, among, ..operation }
    }
}
