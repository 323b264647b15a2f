//! Parts that are heated, read or held: in which zone, and at which cell.

use super::cover::nearest_cell;
use super::errors;
use super::goals::{BoardStepJudge, phrases};

use crate::check::lets::Argument;
use crate::check::value::Value;
use crate::check::verbs::Call;
use crate::claims::electrode_array::{AssayOperation, ElectrodeArrayStop, ZoneSort, ZoneStay};
use crate::quantity::Quantity;

/// Lowest temperature, in kelvin, of heaters whose device states none: water freezes below it, and heaters only heat.
const LEAST_HEATED_K: f64 = 273.15;

impl BoardStepJudge<'_> {
    /// The stay of a part in a zone of a sort.
    pub(super) fn in_zone(&mut self, call: &Call, part: Option<usize>, sort: ZoneSort) -> Option<AssayOperation> {
        let places = self.places(call, Some(sort))?;
        let temperature = match phrases(call, "to").next() {
            Some(asked) => Some(self.temperature_k(asked)?),
            None => None,
        };
        let stay_ns = self.stay_ns(phrases(call, "for").next()?, sort.verb().name())?;
        let zone = places.first().and_then(|place| place.zone);
        let zone = zone.map(|zone| ZoneStay { zone, temperature_k: temperature });
        let passing = AssayOperation::passing(part?, Vec::new(), call.span);
        Some(AssayOperation { stay_ns, zone, ..Self::at_one_of(passing, places) })
    }

    /// The zone that an argument names, with its middle; or the zone of the sort at a cell.
    pub(super) fn zone_stop(&mut self, target: &Argument, sort: ZoneSort) -> Option<(usize, ElectrodeArrayStop)> {
        if let Value::Object(_) = &target.value {
            let found = self.board_scene.sites.index(target, self.scene, self.board_scene.is_whole, self.sink)?;
            let zone = self.board_scene.zones.get(found)?;
            let others =
                || self.board_scene.zones.iter().filter(|zone| zone.sort == sort).map(|zone| zone.name.as_str());
            let wrong = (zone.sort != sort).then(|| errors::zone_of_other_sort(target.span, zone, sort, others()));
            target.unless(wrong, self.sink)?;
            let pair = zone.middle().pair().map(|number| Quantity::number(f64::from(number)));
            let middle = Argument { value: Value::Point(pair.to_vec()), ..target.clone() };
            return Some((found, self.stop(&middle)?));
        }
        let stop = self.stop(target)?;
        let of_sort = || self.board_scene.zones.iter().enumerate().filter(|(_, zone)| zone.sort == sort);
        if let Some((found, _)) = of_sort().find(|(_, zone)| zone.contains(stop.cell)) {
            return Some((found, stop));
        }
        let cover = &self.board_scene.cover;
        let is_one = |cell| of_sort().any(|(_, zone)| zone.contains(cell)) && cover.covering(cell).is_none();
        // The intended zone may be one that is faulty itself.
        if !self.board_scene.sites.has_faulty() {
            let near = nearest_cell(stop.cell, self.facts, is_one);
            target.unless(Some(errors::no_zone_here(target.span, stop.cell, sort, near)), self.sink)?;
        }
        None
    }

    /// A temperature that the heaters of the device reach; `None` after an error.
    fn temperature_k(&mut self, asked: &Argument) -> Option<f64> {
        let Value::Quantity(temperature) = asked.value else { return None };
        let beyond = |field: &'static str, limit_k: Option<f64>, is_beyond: fn(f64, f64) -> bool| {
            limit_k.filter(|limit_k| is_beyond(temperature.si, *limit_k)).map(|limit_k| (field, limit_k))
        };
        let low = beyond("least_temperature", self.facts.least_temperature_k, |asked_k, least_k| asked_k < least_k);
        let high = || beyond("most_temperature", self.facts.most_temperature_k, |asked_k, most_k| asked_k > most_k);
        let wrong = low.or_else(high);
        let wrong = wrong.map(|(field, limit_k)| {
            errors::temperature_out_of_range(asked.span, temperature, self.device, field, limit_k)
        });
        let is_cold = self.facts.least_temperature_k.is_none() && temperature.si < LEAST_HEATED_K;
        let wrong = wrong.or_else(|| is_cold.then(|| errors::too_cold_for_heaters(asked.span, temperature)));
        asked.unless(wrong, self.sink)?;
        Some(temperature.si)
    }
}
