//! Pictures of electrode arrays: the board with its obstacles, the parts at their start and end, and their routes.

use crate::claims::electrode_array::{BoardZone, ElectrodeArrayObstacle, ElectrodeArrayOrder, ZoneSort};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell, Electrodes};
use crate::emit::electrode_array::motion::{PartsMoment, body, goal_cells, moments, outline, place, runs, zone_body};
use crate::emit::svg::drawing::{
    Drawing, HAIR_PT, PaperBox, PaperView, PlacedLabel, ShapeStyle, THIN_PT, TextStyle, WAY_PT, color, decimal,
};
use crate::emit::svg::legend::{LegendSymbol, PanelLegend};
use crate::emit::svg::scenery::{self, simplified};
use crate::emit::svg::strobe::{MAX_NUMBERS, MAX_STROBES, StrobedPlace, Strobes, length, ranges};
use crate::emit::svg::{Panel, Pictured, Subject};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

/// Least distance of electrodes on paper; of a finer board only the outline is drawn.
const ELECTRODE_PT: f64 = 2.0;

/// Opacity of heaters, detectors and magnets over the electrodes.
const ZONE_OPACITY: f64 = 0.7;

/// Greatest number of corners of all routes together.
const MAX_ROUTE_CORNERS: usize = 20_000;

struct BoardPanel<'a> {
    subject: Subject<'a>,
    orders: Vec<Cow<'a, ElectrodeArrayOrder>>,
    moments: Vec<PartsMoment>,
    /// Names of all parts, in source order.
    parts: Vec<&'a str>,
    strobes: Strobes,
    /// Whether positions between start and end are numbered.
    has_numbers: bool,
}

impl Pictured for ElectrodeArrayOrder {
    fn panels<'a>(&'a self, subject: Subject<'a>) -> Vec<Box<dyn Panel + 'a>> {
        let runs = runs(subject.verified, subject.device).into_iter();
        let orders: Vec<Cow<ElectrodeArrayOrder>> = runs.map(|(order, _)| order).collect();
        let moments = moments(subject.verified, subject.device);
        let parts: Vec<&str> = self.parts.iter().map(|part| part.name.as_str()).collect();
        let moving = parts.iter().filter(|part| way(&moments, part).len() > 1).count();
        let most = MAX_NUMBERS / moving.max(1);
        let strobes = strobes(&orders, &moments, &parts, most.min(MAX_STROBES));
        vec![Box::new(BoardPanel { subject, orders, moments, parts, strobes, has_numbers: most > 2 })]
    }
}

/// The sequence of places of a part.
fn way(moments: &[PartsMoment], part: &str) -> Vec<[f64; 2]> {
    simplified(moments.iter().filter_map(|moment| moment.cell(part)).map(place))
}

/// The instants at which a part has come to another cell, and those at which one comes to a stop.
fn strobes(orders: &[Cow<ElectrodeArrayOrder>], moments: &[PartsMoment], parts: &[&str], most: usize) -> Strobes {
    let mut all: BTreeSet<u64> = moments.first().map(|moment| moment.t_ns).into_iter().collect();
    for pair in moments.windows(2).filter(|pair| pair[0].parts != pair[1].parts) {
        all.insert(pair[1].t_ns);
    }
    let goals: BTreeSet<(&str, ElectrodeCell)> = orders
        .iter()
        .flat_map(|order| goal_cells(order))
        .filter_map(|(part, cell)| Some((*parts.get(part?)?, cell)))
        .collect();
    let arrived = |(part, cell): &(&str, ElectrodeCell)| {
        moments.iter().find(|moment| moment.parts.get(*part) == Some(cell)).map(|moment| moment.t_ns)
    };
    let stops: BTreeSet<u64> = goals.iter().filter_map(arrived).collect();
    Strobes::chosen(&all, &stops, most)
}

impl BoardPanel<'_> {
    fn facts(&self) -> &ElectrodeArrayFacts {
        &self.orders[0].facts
    }

    fn place(&self, part: &str, t_ns: u64) -> Option<[f64; 2]> {
        let after = self.moments.partition_point(|moment| moment.t_ns <= t_ns);
        let here = self.moments.get(after.saturating_sub(1))?;
        let cell = *here.parts.get(part)?;
        let next = self.moments.get(after).filter(|_| after > 0);
        // A part that is gone in the next state moves to where it merges or leaves.
        let to = next.and_then(|next| next.cell(part)).unwrap_or(cell);
        let places = [(here.t_ns, place(cell)), (next.map_or(u64::MAX, |next| next.t_ns), place(to))];
        scenery::between(&places, t_ns, |place| *place)
    }

    /// The outline of a part at a place.
    fn shape(&self, at: [f64; 2], view: &PaperView, style: ShapeStyle, data: &[(&str, String)], to: &mut Drawing) {
        let layout = &self.facts().layout;
        let half_pt = layout.half_width_pitches * view.scale;
        let at = view.at(at);
        match layout.electrodes {
            Electrodes::Quad => to.rect(PaperBox::about(at, half_pt), style, data),
            Electrodes::Single => to.disc(at, half_pt, style, data),
        }
    }

    /// Labels a part with its name and numbers, if there are few parts or the label fits into the part.
    fn name(&self, text: String, at: [f64; 2], to: &mut Drawing, view: &PaperView) {
        let radius_pt = self.facts().layout.half_width_pitches * view.scale;
        let text_style = TextStyle::SMALL.bold();
        let may_cover = text_style.width_pt(&text) < 2.0 * radius_pt;
        if may_cover || self.parts.len() <= scenery::MAX_NAMES {
            to.label(PlacedLabel { text, text_style, at, radius_pt, may_cover });
        }
    }

    fn attributes_of<'f>(&self, part: &str, place: &StrobedPlace) -> Vec<(&'f str, String)> {
        let [column, row] = place.place.map(|value| decimal(value + 1.0, 6));
        let device = self.subject.device.to_owned();
        vec![
            ("device", device),
            ("part", part.to_owned()),
            ("t-ns", place.instants()),
            ("column", column),
            ("row", row),
        ]
    }
}

impl Panel for BoardPanel<'_> {
    fn title(&self) -> String {
        let facts = self.facts();
        let pitch = length(facts.pitch_um());
        format!("{}: {} × {} electrodes, {pitch} apart", self.subject.device, facts.columns, facts.rows)
    }

    fn extent(&self) -> [[f64; 2]; 2] {
        // A part in the corner may reach beyond the board.
        let beyond = (self.facts().layout.half_width_pitches - 0.5).max(0.0);
        scenery::about(outline(self.facts()), beyond)
    }

    fn unit_um(&self) -> f64 {
        self.facts().pitch_um()
    }

    fn draw(&self, view: &PaperView, to: &mut Drawing) -> PanelLegend {
        let mut legend = PanelLegend::default();
        draw_board(self, view, to, &mut legend);
        draw_zones(self, view, to, &mut legend);
        draw_obstacles(self, view, to, &mut legend);
        match self.subject.moment_ns {
            Some(t_ns) => draw_moment(self, t_ns, view, to, &mut legend),
            None => draw_strobes(self, view, to, &mut legend),
        }
        legend
    }
}

fn draw_board(panel: &BoardPanel, view: &PaperView, to: &mut Drawing, legend: &mut PanelLegend) {
    let facts = panel.facts();
    let [[x0, y0], [x1, y1]] = outline(facts);
    let [low, high] = [view.at([x0, y0]), view.at([x1, y1])];
    let room = PaperBox { left: low[0], top: high[1], right: high[0], bottom: low[1] };
    to.rect(room, ShapeStyle::filled(color::BOARD).with_stroke(color::FAINT, HAIR_PT), &[]);
    let diameter_pt = 2.0 * facts.radius_um / facts.pitch_um() * view.scale;
    let cells =
        || (1..=facts.columns).flat_map(|column| (1..=facts.rows).map(move |row| ElectrodeCell { column, row }));
    for gap in cells().filter(|cell| !facts.has_electrode(*cell)) {
        let [x, y] = place(gap);
        let [low, high] = [view.at([x - 0.5, y - 0.5]), view.at([x + 0.5, y + 0.5])];
        let room = PaperBox { left: low[0], top: high[1], right: high[0], bottom: low[1] };
        to.rect(room, ShapeStyle::filled(color::PAPER), &[]);
    }
    if view.scale >= ELECTRODE_PT {
        let works = cells().filter(|cell| facts.has_electrode(*cell) && !facts.is_disabled(*cell));
        to.dots(works.map(|cell| view.at(place(cell))), diameter_pt, color::ELECTRODE);
        legend.add(LegendSymbol::Disc, ShapeStyle::filled(color::ELECTRODE), "electrode");
        let style = ShapeStyle::filled(color::PAPER).with_stroke(color::FAINT, THIN_PT);
        for cell in cells().filter(|cell| facts.is_disabled(*cell)) {
            to.disc(view.at(place(cell)), diameter_pt / 2.0, style, &[]);
            legend.add(LegendSymbol::Disc, style, "disabled");
        }
    } else {
        legend.notes.push(format!(
            "the {} × {} electrodes of {} are not drawn",
            facts.columns, facts.rows, panel.subject.device
        ));
    }
    let Some(t_ns) = panel.subject.moment_ns else { return };
    let signals = panel.subject.signals;
    let device = panel.subject.device;
    let of_device = signals.schedule.channels.iter().enumerate().filter(|(_, channel)| channel.device == device);
    let on = of_device.filter(|(index, _)| signals.value(*index, t_ns) != 0.0);
    let firsts = on.filter_map(|(_, channel)| facts.electrode(channel.name.strip_prefix(device)?.strip_prefix('.')?));
    let cells = firsts.flat_map(|first| facts.working_on_channel_of(first));
    let style = ShapeStyle::filled(color::LIVE).with_stroke(color::LIVE_EDGE, HAIR_PT);
    for cell in cells {
        to.disc(
            view.at(place(cell)),
            (diameter_pt / 2.0).max(0.8),
            style,
            &[("on", format!("{} {}", cell.column, cell.row))],
        );
    }
    legend.add(LegendSymbol::Disc, style, "electrode that is on");
}

fn draw_zones(panel: &BoardPanel, view: &PaperView, to: &mut Drawing, legend: &mut PanelLegend) {
    let all: BTreeMap<(&str, ZoneSort), &BoardZone> = panel
        .orders
        .iter()
        .flat_map(|order| order.zones.iter())
        .map(|zone| ((zone.name.as_str(), zone.sort), zone))
        .collect();
    for zone in all.values() {
        let [[x0, y0], [x1, y1]] = zone_body(zone);
        let [low, high] = [view.at([x0, y0]), view.at([x1, y1])];
        let room = PaperBox { left: low[0], top: high[1], right: high[0], bottom: low[1] };
        let style = ShapeStyle::filled(color_of_zone(zone.sort)).with_opacity(ZONE_OPACITY);
        to.rect(room, style, &[(zone.sort.name(), zone.name.clone())]);
        if all.len() <= scenery::MAX_NAMES {
            to.label(scenery::name(&zone.name, room.middle()));
        }
        legend.add(LegendSymbol::Box, style, zone.sort.name());
    }
}

fn color_of_zone(sort: ZoneSort) -> &'static str {
    match sort {
        ZoneSort::Heater => color::HEATER,
        ZoneSort::Detector => color::DETECTOR,
        ZoneSort::Magnet => color::MAGNET,
    }
}

fn draw_obstacles(panel: &BoardPanel, view: &PaperView, to: &mut Drawing, legend: &mut PanelLegend) {
    let mut all: Vec<&ElectrodeArrayObstacle> = Vec::new();
    let mut known = BTreeSet::new();
    for obstacle in panel.orders.iter().flat_map(|order| order.obstacles.iter()) {
        if known.insert((&obstacle.name, format!("{:?}", obstacle.body))) {
            all.push(obstacle);
        }
    }
    let drawn = &all[..all.len().min(scenery::MAX_OBSTACLES)];
    for obstacle in drawn {
        let [[x0, y0], [x1, y1]] = body(panel.facts(), obstacle);
        let [low, high] = [view.at([x0, y0]), view.at([x1, y1])];
        let room = PaperBox { left: low[0], top: high[1], right: high[0], bottom: low[1] };
        to.rect(room, ShapeStyle::filled(color::OBSTACLE), &[]);
        if all.len() <= scenery::MAX_NAMES {
            to.label(scenery::name(&obstacle.name, room.middle()));
        }
    }
    if !all.is_empty() {
        legend.add(
            LegendSymbol::Box,
            ShapeStyle::filled(color::OBSTACLE),
            scenery::obstacles_text(all.len(), drawn.len()),
        );
    }
}

/// Marks the goals of all steps.
fn draw_goals(panel: &BoardPanel, view: &PaperView, to: &mut Drawing, legend: &mut PanelLegend) {
    let goals: BTreeSet<(Option<usize>, ElectrodeCell)> =
        panel.orders.iter().flat_map(|order| goal_cells(order)).collect();
    for (part, cell) in &goals {
        // A goal that any of several parts may take has none of their colours.
        let style = ShapeStyle::line(part.map_or(color::SOFT, color::in_turn), 1.0).dashed("2 1.5");
        to.rect(
            PaperBox::about(view.at(place(*cell)), 0.5 * view.scale),
            style,
            &[("stop", format!("{} {}", cell.column, cell.row))],
        );
    }
    if !goals.is_empty() {
        legend.add(LegendSymbol::Box, ShapeStyle::line(color::SOFT, 1.0).dashed("2 1.5"), "stop or goal");
    }
}

fn draw_strobes(panel: &BoardPanel, view: &PaperView, to: &mut Drawing, legend: &mut PanelLegend) {
    let ways: Vec<Vec<[f64; 2]>> = panel.parts.iter().map(|part| way(&panel.moments, part)).collect();
    let corners: usize = ways.iter().map(Vec::len).sum();
    let (Some(first), Some(last)) = (panel.strobes.instants.first(), panel.strobes.instants.last()) else { return };
    for (index, (part, _)) in panel.parts.iter().zip(&ways).enumerate().filter(|(_, (_, way))| way.len() > 1) {
        let style = ShapeStyle::filled(color::PAPER).with_stroke(color::in_turn(index), THIN_PT);
        if let Some(start) = panel.place(part, *first) {
            panel.shape(start, view, style, &[("start", (*part).to_owned())], to);
        }
    }
    for (index, way) in ways.iter().enumerate().filter(|_| corners <= MAX_ROUTE_CORNERS) {
        to.line(&view.all(way.iter().copied()), ShapeStyle::line(color::in_turn(index), WAY_PT), &[]);
    }
    let ends: BTreeMap<&str, [f64; 2]> =
        panel.parts.iter().filter_map(|part| Some((*part, panel.place(part, *last)?))).collect();
    for (index, part) in panel.parts.iter().enumerate() {
        let style = ShapeStyle::filled(color::in_turn(index)).with_stroke(color::INK, HAIR_PT).with_opacity(0.75);
        if let Some(end) = ends.get(part) {
            panel.shape(*end, view, style, &[("end", (*part).to_owned())], to);
        }
    }
    draw_goals(panel, view, to, legend);
    for (index, part) in panel.parts.iter().enumerate() {
        draw_part(panel, index, part, view, to);
    }
    let grey = color::AHEAD;
    legend.add(LegendSymbol::Box, ShapeStyle::filled(color::PAPER).with_stroke(grey, THIN_PT), "part at its start");
    legend.add(
        LegendSymbol::Box,
        ShapeStyle::filled(grey).with_stroke(color::INK, HAIR_PT).with_opacity(0.75),
        "part at its end",
    );
    if corners <= MAX_ROUTE_CORNERS {
        legend.add(LegendSymbol::Line, ShapeStyle::line(grey, WAY_PT), "route of its middle");
    } else {
        legend.notes.push(format!("routes are not drawn: they have {corners} corners"));
    }
    if panel.has_numbers {
        legend.add(
            LegendSymbol::Disc,
            ShapeStyle::filled(color::PAPER).with_stroke(color::INK, THIN_PT),
            "numbered position of its middle",
        );
        legend.under.push(panel.strobes.times());
        legend.under.extend(panel.strobes.note.clone());
    } else {
        legend.notes.push(format!(
            "{} parts move: positions between start and end have no numbers",
            ways.iter().filter(|way| way.len() > 1).count()
        ));
    }
}

/// Draws the numbered places of a part, with its name at its start and end.
fn draw_part(panel: &BoardPanel, index: usize, part: &str, view: &PaperView, to: &mut Drawing) {
    let places = StrobedPlace::all(&panel.strobes, |t_ns| panel.place(part, t_ns));
    let radius_pt = 0.4 * panel.facts().layout.half_width_pitches * view.scale;
    for place in &places {
        let style = ShapeStyle::filled(color::PAPER).with_stroke(color::in_turn(index), THIN_PT);
        let at = view.at(place.place);
        to.disc(at, radius_pt.clamp(0.5, 1.2), style, &panel.attributes_of(part, place));
        to.mark(PaperBox::about(at, 1.2));
    }
    let is_gone = panel.strobes.instants.last().is_some_and(|last| panel.place(part, *last).is_none());
    let clusters = StrobedPlace::clustered(places.iter().map(|place| (place, view.at(place.place))));
    let last = clusters.len().saturating_sub(1);
    for (index, (at, numbers)) in clusters.iter().enumerate() {
        let numbers = Some(numbers).filter(|_| panel.has_numbers && last > 0);
        let is_end = index == 0 || (index == last && !is_gone);
        match (is_end, numbers) {
            (true, Some(numbers)) => panel.name(format!("{part} {}", ranges(numbers)), *at, to, view),
            (true, None) => panel.name(part.to_owned(), *at, to, view),
            (false, Some(numbers)) => to.label(scenery::numbers(numbers, *at, 1.5)),
            (false, None) => {}
        }
    }
}

fn draw_moment(panel: &BoardPanel, t_ns: u64, view: &PaperView, to: &mut Drawing, legend: &mut PanelLegend) {
    let until = |is_behind: bool| {
        let is_meant = move |moment: &&PartsMoment| (moment.t_ns <= t_ns) == is_behind;
        move |part: &str| -> Vec<[f64; 2]> {
            panel.moments.iter().filter(is_meant).filter_map(|moment| moment.cell(part)).map(place).collect()
        }
    };
    let (behind, ahead) = (until(true), until(false));
    let corners: usize = panel.parts.iter().map(|part| way(&panel.moments, part).len()).sum();
    for (index, part) in panel.parts.iter().enumerate().filter(|_| corners <= MAX_ROUTE_CORNERS) {
        let here = panel.place(part, t_ns);
        let dashes = ShapeStyle::line(color::in_turn(index), THIN_PT).dashed("2 2");
        to.line(&view.all(simplified(here.into_iter().chain(ahead(part)))), dashes, &[]);
        to.line(
            &view.all(simplified(behind(part).into_iter().chain(here))),
            ShapeStyle::line(color::in_turn(index), WAY_PT),
            &[],
        );
    }
    for (index, part) in panel.parts.iter().enumerate() {
        let Some(here) = panel.place(part, t_ns) else { continue };
        let place = StrobedPlace { place: here, strobes: vec![(1, t_ns)] };
        let style = ShapeStyle::filled(color::in_turn(index)).with_stroke(color::INK, HAIR_PT).with_opacity(0.75);
        panel.shape(here, view, style, &panel.attributes_of(part, &place), to);
        panel.name((*part).to_owned(), view.at(here), to, view);
    }
    draw_goals(panel, view, to, legend);
    let grey = color::AHEAD;
    legend.add(LegendSymbol::Box, ShapeStyle::filled(grey).with_stroke(color::INK, HAIR_PT).with_opacity(0.75), "part");
    if corners <= MAX_ROUTE_CORNERS {
        legend.add(LegendSymbol::Line, ShapeStyle::line(grey, WAY_PT), "its route so far");
        legend.add(LegendSymbol::Line, ShapeStyle::line(grey, THIN_PT).dashed("2 2"), "its route ahead");
    } else {
        legend.notes.push(format!("routes are not drawn: they have {corners} corners"));
    }
}
