//! Instruments: the facts that their families derive from their fields.

use super::devices::CheckedDeclaration;
use super::figures::Figures;
use super::value::Accepted;
use super::{Checker, errors};
use crate::device::instrument::{
    DRIVER_HEATER_DEGC, DataAcquisitionFacts, ElectrodeDriverFacts, Family, HEATERS, InstrumentFacts,
    MachineControllerFacts, Protocol, StageControllerFacts, StageProtocol, Start, VoltageOutput,
    WaveformGeneratorFacts, heater_setting,
};
use std::collections::BTreeMap;

impl Checker<'_> {
    /// The facts of an instrument that lacks no field; `None` after an error.
    pub fn facts_of_instrument(&mut self, declared: &CheckedDeclaration<Family>) -> Option<InstrumentFacts> {
        let fields = &declared.fields;
        let voltage = || {
            Some(VoltageOutput { peak_v: fields.si("peak")?, bits: fields.count("bits")?, rate_hz: fields.si("rate")? })
        };
        let start = fields.word("start").and_then(Start::find).unwrap_or_default();
        match declared.root {
            Family::WaveformGenerator => {
                let facts = WaveformGeneratorFacts {
                    outputs: fields.count("outputs")?,
                    voltage: voltage()?,
                    least_points: fields.count("least_points")?,
                    most_points: fields.count("most_points")?,
                    most_steps: fields.count("most_steps")?,
                    start,
                };
                if facts.least_points > facts.most_points {
                    let [least, most] =
                        ["least_points", "most_points"].map(|name| fields.get(name).map(|field| field.span));
                    self.sink.push(errors::no_number_of_points(least?, most?, facts.least_points, facts.most_points));
                    return None;
                }
                Some(InstrumentFacts::WaveformGenerator(facts))
            }
            Family::ElectrodeDriver => self.facts_of_driver(fields, start),
            Family::StageController => self.facts_of_controller(fields, start),
            Family::MachineController => {
                let facts = MachineControllerFacts { axes: fields.count("axes")?, rate_hz: fields.si("rate")? };
                Some(InstrumentFacts::MachineController(facts))
            }
            Family::DataAcquisition => {
                let facts = DataAcquisitionFacts {
                    ports: fields.count("ports")?,
                    lines: fields.count("lines")?,
                    digital_rate_hz: fields.si("digital_rate").unwrap_or(0.0),
                    analog_outputs: fields.count("analog_outputs")?,
                    voltage: voltage(),
                    start,
                };
                if facts.analog_outputs > 0 && facts.voltage.is_none() {
                    let analog = ["peak", "bits", "rate"].into_iter().filter(|name| !fields.contains_key(name));
                    let missing: Vec<_> = analog
                        .filter_map(|name| declared.root.fields().iter().find(|field| field.name == name))
                        .collect();
                    let owner = format!("instrument `{}`", declared.name);
                    self.sink.push(errors::missing_fields(declared.span, &owner, &missing, None));
                    return None;
                }
                Some(InstrumentFacts::DataAcquisition(facts))
            }
        }
    }

    fn facts_of_driver(&mut self, fields: &Accepted, start: Start) -> Option<InstrumentFacts> {
        let facts = ElectrodeDriverFacts {
            protocol: Protocol::find(fields.word("protocol")?)?,
            channels: fields.count("channels")?,
            least_v: fields.si("least_potential")?,
            most_v: fields.si("most_potential")?,
            least_frame_ns: fields.clock_ns("least_frame", self.sink)?,
            frequency_hz: fields.si("frequency"),
            heaters_degc: BTreeMap::new(),
            start,
        };
        let most = facts.protocol.channels();
        let wrong = if facts.channels > most {
            Some(("channels", errors::too_many_driver_channels(facts.protocol.name(), facts.channels, most)))
        } else if facts.least_v > facts.most_v {
            let text = |name: &str| fields.text(name);
            let finding = errors::no_driver_voltage(&text("least_potential"), &text("most_potential"));
            Some(("least_potential", finding))
        } else if facts.frequency_hz.is_some() && !facts.protocol.sets_voltage() {
            Some(("frequency", errors::no_driver_frequency(facts.protocol.name())))
        } else {
            None
        };
        if let Some((field, finding)) = wrong {
            self.sink.push(finding.label(fields.get(field)?.span, "here"));
            return None;
        }
        let heaters_degc = self.heaters_of_driver(fields, facts.protocol)?;
        Some(InstrumentFacts::ElectrodeDriver(ElectrodeDriverFacts { heaters_degc, ..facts }))
    }

    /// The temperatures of its heaters, by their numbers; `None` after an error.
    fn heaters_of_driver(&mut self, fields: &Accepted, protocol: Protocol) -> Option<BTreeMap<u32, u32>> {
        let mut heaters = BTreeMap::new();
        for (field, number) in HEATERS.iter().zip(1..) {
            let (Some(given), Some(temperature)) = (fields.get(field), fields.quantity(field)) else { continue };
            let found = heater_setting(temperature);
            let wrong = if number > protocol.heaters() {
                Some(errors::no_driver_heater(field, protocol.name()))
            } else if found.is_none() {
                let [least, most] = [*DRIVER_HEATER_DEGC.start(), *DRIVER_HEATER_DEGC.end()];
                Some(errors::temperature_of_no_frame(&fields.text(field), [least, most]))
            } else {
                None
            };
            self.sink.push_if_some(wrong.map(|finding| finding.label(given.span, "here")))?;
            heaters.extend(found.map(|whole| (number, whole)));
        }
        Some(heaters)
    }

    fn facts_of_controller(&mut self, fields: &Accepted, start: Start) -> Option<InstrumentFacts> {
        let facts = StageControllerFacts {
            protocol: StageProtocol::find(fields.word("protocol")?)?,
            axes: fields.count("axes")?,
            rate_hz: fields.si("rate")?,
            most_points: fields.count("most_points"),
            start,
        };
        if let Some(rates) = facts.protocol.refuses_rate(facts.rate_hz) {
            let finding = errors::no_stream_rate(facts.protocol.name(), &fields.text("rate"), rates);
            self.sink.push(finding.label(fields.get("rate")?.span, "here"));
            return None;
        }
        Some(InstrumentFacts::StageController(facts))
    }
}
