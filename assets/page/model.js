// What a schedule says, as functions of time. No drawing here: everything can be tested without a browser.
//
// Times are nanoseconds from the start, as in the schedule; lengths are micrometres. The page holds `schedule` and `claims` in the forms
// that `schema/` and the log describe, and `sources`, the text of each file. Of a program that could not be built they hold the part that
// could, and `failure` says why; without such a part both are null.
"use strict";

/** The schedule of a program of which nothing could be built. */
const NOTHING = { channels: [], actuations: [], steps: [], plans: [], duration_ns: 0 };

/** The schedule, its claims and its sources, indexed by device, channel and event. */
function buildModel(page) {
  const schedule = page.schedule || NOTHING;
  const claims = page.claims || { jobs: [] };
  const channels = schedule.channels.map((channel, index) => ({ ...channel, index, actuations: [] }));
  for (const actuation of schedule.actuations) channels[actuation.channel].actuations.push(actuation);
  const devices = [];
  schedule.plans.forEach((plan, index) => {
    let device = devices.find((known) => known.name === plan.device);
    if (!device) {
      device = { name: plan.device, kind: plan.kind, runs: [], channels: channels.filter((c) => c.device === plan.device) };
      devices.push(device);
    }
    const order = atChosenPlaces(claims.jobs[index].order[plan.kind], schedule.steps.filter((step) => step.plan === index));
    device.runs.push({ plan, order, requirements: claims.jobs[index].requirements, index });
  });
  for (const device of devices) device.runs.sort((a, b) => a.plan.start_ns - b.plan.start_ns);
  for (const device of devices) device.reaches = reachesOf(page, device.name);
  const model = { page, schedule, claims, channels, devices, steps: schedule.steps, duration_ns: schedule.duration_ns };
  model.failure = page.failure || null;
  model.blamed = blamedNames(page);
  model.works = worksOf(model);
  model.events = eventsOf(model);
  for (const device of devices) if (device.kind === "fingers") prepareHand(device, page.evidence);
  for (const device of devices) if (device.kind === "electrode_array") prepareBoard(device);
  return model;
}

/** What takes place when: every step or, where its operations overlap, each of them. */
function worksOf(model) {
  const works = model.steps.flatMap((step) => (step.operations ? step.operations.map((own) => ({ ...step, ...own })) : [step]));
  return works.map((work, index) => ({ ...work, index }));
}

/** The text of a program between two places of one line; columns count characters. */
function excerptOf(sources, { file, line, column, end_line, end_column }) {
  const source = sources.find(({ name }) => name === file);
  if (!source || line !== end_line) return "";
  return [...(source.text.split(/\r\n|\r|\n/)[line - 1] || "")].slice(column - 1, end_column - 1).join("");
}

/** The names that errors point to or put in quotes; those of things of the scene are lit there. */
function blamedNames({ failure, sources }) {
  const names = new Set();
  for (const { severity, title, help, labels } of failure ? failure.findings : []) {
    if (severity !== "error") continue;
    const texts = [title, help || "", ...labels.map((label) => label.text)].flatMap((text) => text.match(/`[^`]+`/g) || []);
    for (const text of [...texts, ...labels.map((label) => excerptOf(sources, label))]) {
      for (const [name, word] of text.matchAll(/([A-Za-z_]\w*)(?:\[[^\]]*\])?/g)) names.add(name).add(word);
    }
  }
  return names;
}

/** How far a device came in searches that found no plan; for cells also the edges behind which nothing was reached. */
function reachesOf({ failure }, name) {
  const found = (failure ? failure.findings : []).flatMap(({ reaches }) => reaches || []).filter((reach) => reach.device === name);
  const isShared = new Set(found.filter(({ runs }) => runs).map(({ what }) => what)).size > 1;
  return found.map((reach) => {
    const { runs } = reach;
    if (!runs) return reach;
    const met = new Set(runs.flatMap(([row, first, last]) => Array.from({ length: last - first + 1 }, (_, at) => `${first + at}/${row}`)));
    const edges = [];
    for (const key of met) {
      const [column, row] = key.split("/").map(Number);
      for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
        if (met.has(`${column + dx}/${row + dy}`)) continue;
        const middle = [column + dx / 2, row + dy / 2];
        edges.push([[middle[0] - dy / 2, middle[1] - dx / 2], [middle[0] + dy / 2, middle[1] + dx / 2]]);
      }
    }
    return { ...reach, edges, isShared };
  });
}

/** Instants at which something begins or ends, for stepping through. */
function eventsOf(model) {
  const instants = new Set([0, model.duration_ns]);
  for (const work of [...model.steps, ...model.works]) instants.add(work.start_ns).add(work.start_ns + work.duration_ns);
  for (const plan of model.schedule.plans) for (const state of plan.states) instants.add(state.t_ns);
  return [...instants].sort((a, b) => a - b);
}

/** Index of the last entry whose `key` is at most `value`; -1 for none. */
function lastAtMost(list, key, value) {
  let low = 0;
  let high = list.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (list[middle][key] <= value) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/** The run of a device that has begun last at an instant; before all of them the first. */
function runAt(device, t_ns) {
  let found = device.runs[0];
  for (const run of device.runs) if (run.plan.start_ns <= t_ns) found = run;
  return found;
}

/** Index of the recorded state that holds at an instant. */
function stateIndexAt(plan, t_ns) {
  return Math.max(0, lastAtMost(plan.states, "t_ns", t_ns));
}

/** The recorded state of a device that holds at an instant. */
function stateAt(device, t_ns) {
  const { plan } = runAt(device, t_ns);
  return plan.states[stateIndexAt(plan, t_ns)];
}

/** The actuation of a channel at an instant, if there is one. */
function actuationAt(channel, t_ns) {
  const actuation = channel.actuations[lastAtMost(channel.actuations, "start_ns", t_ns)];
  return actuation && t_ns < actuation.start_ns + actuation.duration_ns ? actuation : null;
}

/** The value of a channel: volts, which are at rest outside of actuations, or micrometres, which are held. */
function valueAt(channel, t_ns) {
  const actuation = actuationAt(channel, t_ns);
  if (actuation) {
    if (actuation.swing) {
      const phase = (t_ns - actuation.start_ns) % actuation.swing.period_ns;
      return actuation.swing.levels[phase < actuation.swing.period_ns / 2 ? 0 : 1];
    }
    return actuation.from + ((actuation.to - actuation.from) * (t_ns - actuation.start_ns)) / actuation.duration_ns;
  }
  if (channel.unit === "V") return channel.rest_v || 0;
  const before = channel.actuations[lastAtMost(channel.actuations, "start_ns", t_ns)];
  return before ? before.to : channel.actuations.length ? channel.actuations[0].from : 0;
}

/** The works that take place at an instant, by index; at the very end the last ones still do. */
function worksAt(model, t_ns) {
  const found = [];
  model.works.forEach((work, index) => {
    const end_ns = work.start_ns + work.duration_ns;
    if (work.start_ns <= t_ns && (t_ns < end_ns || (end_ns === model.duration_ns && t_ns >= end_ns))) found.push(index);
  });
  return found;
}

const mix = (a, b, share) => a + (b - a) * share;

// DiMiBot

/** Distance between neighbouring cells along x and y (the paper's equations 2 and 6). */
function pitchUm(facts) {
  const widest_um = facts.gain * facts.stroke_um * Math.SQRT2;
  return [widest_um / 2 ** (facts.left - 1), widest_um / 2 ** (facts.right - 1)];
}

/** A place of a robot's own frame in its scene. */
function inScene(order, [x, y]) {
  if (!order.frame) return [x, y];
  const { x_um, y_um, heading_rad } = order.frame;
  const [cos, sin] = [Math.cos(heading_rad), Math.sin(heading_rad)];
  return [x_um + x * cos - y * sin, y_um + x * sin + y * cos];
}

/** The tip in its scene; within a pulse on its way from one place to the next. */
function tipAt(device, t_ns) {
  const { plan, order } = runAt(device, t_ns);
  const index = stateIndexAt(plan, t_ns);
  const [here, next] = [plan.states[index], plan.states[index + 1]];
  if (!next || t_ns <= next.t_ns - order.facts.pulse_duration_ns) return inScene(order, here.position_um);
  const share = 1 - (next.t_ns - t_ns) / order.facts.pulse_duration_ns;
  const place = [0, 1].map((axis) => mix(here.position_um[axis], next.position_um[axis], Math.min(1, Math.max(0, share))));
  return inScene(order, place);
}

// Electrode array

/** What the parts are to do in a task, one after the other. */
function movesOf(order) {
  return order.steps.flatMap(({ action }) => action.move || action.assay || []);
}

/** An order with its operations at the places that its plan has chosen; the steps are those of the plan. */
function atChosenPlaces(order, steps) {
  if (!steps.some(({ operations = [] }) => operations.some(({ at }) => at))) return order;
  const chosen = (one, at) => (at ? { ...one, stops: [{ cell: { column: at[0], row: at[1] } }] } : one);
  const placedStep = (step, { operations = [] }) => {
    if (!operations.some(({ at }) => at)) return step;
    const assay = step.action.assay.map((one, place) => chosen(one, operations[place]?.at));
    return { ...step, action: { assay } };
  };
  return { ...order, steps: order.steps.map((step, nth) => placedStep(step, steps[nth])) };
}

/** Where a part merges with another, or leaves the board, after which it is gone. */
function departureOf(order, name) {
  const part = order.parts.findIndex((known) => known.name === name);
  const last = movesOf(order).find((one) => one.with === part || (one.leaves && one.part === part));
  const stop = last && last.stops[last.stops.length - 1];
  return stop && [stop.cell.column, stop.cell.row];
}

/** Where every part is, in columns and rows; between two electrodes while it moves. */
function partsAt(device, t_ns) {
  const { plan, order } = runAt(device, t_ns);
  const index = stateIndexAt(plan, t_ns);
  const [here, next] = [plan.states[index], plan.states[index + 1]];
  const begins_ns = next ? Math.max(here.t_ns, next.t_ns - order.facts.step_ns) : 0;
  const share = next && t_ns > begins_ns ? (t_ns - begins_ns) / (next.t_ns - begins_ns) : 0;
  const places = {};
  for (const [name, cell] of Object.entries(here.parts)) {
    // A part that is gone in the next state comes to where it merges or leaves.
    const to = next ? next.parts[name] || departureOf(order, name) || cell : cell;
    places[name] = [mix(cell[0], to[0], share), mix(cell[1], to[1], share)];
  }
  return places;
}

/**
 * Finds what droplets leave on the electrodes of a board, run after run: `traces` has for each electrode that they come to its place and
 * `changes`, the fluids that are on it from an instant on. A droplet of nothing but washing fluids takes away what is there.
 */
function prepareBoard(device) {
  device.traces = new Map();
  device.fluids = [];
  const held = new Map();
  const tread = ([column, row], t_ns, fluids, washes) => {
    const key = `${column}/${row}`;
    if (!device.traces.has(key)) device.traces.set(key, { cell: [column, row], changes: [{ t_ns: -1, fluids: [] }] });
    const { changes } = device.traces.get(key);
    const last = changes[changes.length - 1].fluids;
    const isWash = fluids.size > 0 && [...fluids].every((fluid) => washes.includes(fluid));
    const next = isWash ? [] : [...new Set([...last, ...fluids])];
    if (next.length !== last.length) changes.push({ t_ns, fluids: next });
  };
  for (const { plan, order } of device.runs) {
    if (order.facts.layout?.electrodes !== "single") return;
    const { washes = [] } = order.contamination || {};
    const works = movesOf(order);
    const part = (name) => order.parts.findIndex((known) => known.name === name);
    for (const [index, { t_ns, parts }] of plan.states.entries()) {
      for (const name of Object.keys(parts)) if (!held.has(name)) held.set(name, fluidsOf(order, works, part(name), held));
      for (const [name, fluids] of held) {
        if (parts[name]) continue;
        const merge = works.find((work) => work.with === part(name));
        const into = merge && order.parts[merge.part].name;
        if (held.has(into)) held.set(into, new Set([...held.get(into), ...fluids]));
        const left = !merge && index > 0 && departureOf(order, name);
        if (left) tread(left, t_ns, fluids, washes);
        held.delete(name);
      }
      for (const [name, cell] of Object.entries(parts)) tread(cell, t_ns, held.get(name), washes);
    }
  }
  const order = device.runs[0].order;
  const names = [...new Set([...device.traces.values()].flatMap(({ changes }) => changes.flatMap(({ fluids }) => fluids)))];
  // A fluid has the colour of the first droplet that is of it.
  const all = device.runs.flatMap((run) => movesOf(run.order));
  const partOf = (fluid) => {
    const dispensed = all.find((work) => work.comes && work.fluid === fluid);
    return dispensed ? dispensed.part : order.parts.findIndex(({ name }) => name === fluid);
  };
  device.fluids = names.map((name) => ({ name, part: partOf(name) }));
}

/** What a droplet contains as it comes: what its reservoir holds, what the droplet has that it is split from, or a fluid of its own name. */
function fluidsOf(order, works, part, held) {
  const dispensed = works.find((work) => work.comes && work.part === part);
  if (dispensed && dispensed.fluid) return new Set([dispensed.fluid]);
  const split = works.find((work) => work.splits && work.splits.part === part);
  return new Set((split && held.get(order.parts[split.part].name)) || [order.parts[part].name]);
}

/** The fluids on the electrodes of a board at an instant, where there are any. */
function tracesAt(device, t_ns) {
  const found = [...device.traces.values()].map(({ cell, changes }) => ({ cell, fluids: changes[lastAtMost(changes, "t_ns", t_ns)].fluids }));
  return found.filter(({ fluids }) => fluids.length > 0);
}

// Microrobots

/** The drive train of a leg: the first that begins between its start and the next state. */
function trainOf(channel, start_ns, end_ns) {
  const { actuations } = channel;
  for (let at = lastAtMost(actuations, "start_ns", start_ns - 1) + 1; at < actuations.length; at += 1) {
    if (actuations[at].start_ns >= end_ns) return null;
    if (actuations[at].swing) return actuations[at];
  }
  return null;
}

/** The path of a robot along its heading, or along its circle with its arm down. */
function moved(facts, [x, y, heading_rad], isDown, way_um) {
  if (!isDown) return [x + way_um * Math.cos(heading_rad), y + way_um * Math.sin(heading_rad), heading_rad];
  const side = facts.turning === "clockwise" ? -1 : 1;
  const radius_um = facts.turning_radius_um;
  const turned_rad = heading_rad + (side * way_um) / radius_um;
  return [
    x + side * radius_um * (Math.sin(turned_rad) - Math.sin(heading_rad)),
    y - side * radius_um * (Math.cos(turned_rad) - Math.cos(heading_rad)),
    turned_rad,
  ];
}

/** The centre of a robot's circle. */
function orbitCentre(facts, [x, y, heading_rad]) {
  const side = facts.turning === "clockwise" ? -1 : 1;
  return [x - side * facts.turning_radius_um * Math.sin(heading_rad), y + side * facts.turning_radius_um * Math.cos(heading_rad)];
}

/** Pose, arm and docking of every robot at an instant. */
function robotsAt(device, t_ns) {
  const { plan, order } = runAt(device, t_ns);
  const index = stateIndexAt(plan, t_ns);
  const state = plan.states[index];
  const end_ns = plan.states[index + 1] ? plan.states[index + 1].t_ns : plan.start_ns + plan.duration_ns;
  const train = trainOf(device.channels[0], state.t_ns, end_ns);
  const driven_ns = train ? Math.min(train.duration_ns, Math.max(0, t_ns - train.start_ns)) : 0;
  const strokes = train ? driven_ns / train.swing.period_ns : 0;
  return order.robots.map(({ row }) => {
    const facts = order.facts.robots[row];
    const isDown = state.arms[row] === 1;
    const isDocked = (state.docked || []).includes(facts.name);
    const pose = poseIn(state, facts.name);
    return {
      name: facts.name,
      facts,
      isDown,
      isDocked,
      isDriven: driven_ns > 0 && train && t_ns < train.start_ns + train.duration_ns,
      pose: isDocked ? pose : moved(facts, pose, isDown, strokes * facts.step_um),
    };
  });
}

// Fingers

/** Finds for each pair of states when the fingers that hold move, and the channels of each finger. */
function prepareHand(device, evidence) {
  const byName = new Map(device.channels.map((channel) => [channel.name, channel]));
  const count = device.runs[0].order.facts.fingers;
  device.stages = Array.from({ length: count }, (_, finger) =>
    ["x", "y", "z"].map((axis) => byName.get(`${device.name}.f${finger + 1}.${axis}`)));
  for (const run of device.runs) {
    const { states } = run.plan;
    run.forces = forcesOf(evidence, run);
    run.motions = states.slice(0, -1).map((state, index) => {
      let [first, last] = [Infinity, -Infinity];
      state.grasp.forEach((contact, finger) => {
        if (contact === 0) return;
        for (const channel of device.stages[finger]) {
          for (let at = lastAtMost(channel.actuations, "start_ns", state.t_ns - 1) + 1; at < channel.actuations.length; at += 1) {
            const ramp = channel.actuations[at];
            if (ramp.start_ns + ramp.duration_ns > states[index + 1].t_ns) break;
            if (ramp.from === ramp.to) continue;
            first = Math.min(first, ramp.start_ns);
            last = Math.max(last, ramp.start_ns + ramp.duration_ns);
          }
        }
      });
      return first < last ? [first, last] : null;
    });
  }
}

/** The forces of the fingers in each state of a run, along the axes of the part; null where none are known. */
function forcesOf(evidence, { plan, index }) {
  const found = evidence ? evidence.forces.find((forces) => forces.plan === index) : null;
  return plan.states.map(({ orientation: [w, x, y, z] }, at) => {
    const forces = found && found.states[at];
    return forces ? forces.map((force) => force && turned([w, -x, -y, -z], force)) : null;
  });
}

/** The force of each finger on the part along the axes of the part; in a motion on its way to those of the next state. */
function forcesAt(device, t_ns) {
  const run = runAt(device, t_ns);
  const index = stateIndexAt(run.plan, t_ns);
  const [here, next, motion] = [run.forces[index], run.forces[index + 1], run.motions[index]];
  const isSame = here && next && here.every((force, finger) => Boolean(force) === Boolean(next[finger]));
  if (!isSame || !motion || t_ns <= motion[0]) return here;
  const share = (Math.min(t_ns, motion[1]) - motion[0]) / (motion[1] - motion[0]);
  return here.map((force, finger) => force && force.map((value, axis) => mix(value, next[finger][axis], share)));
}

/** Middle of each tip, and whether it holds. */
function tipsAt(device, t_ns) {
  const { grasp } = stateAt(device, t_ns);
  return device.stages.map((stage, finger) => ({
    place: stage.map((channel) => valueAt(channel, t_ns)),
    contact: grasp[finger],
  }));
}

/** Position and unit quaternion (w, x, y, z) of the part of a hand. */
function partAt(device, t_ns) {
  const run = runAt(device, t_ns);
  const { states } = run.plan;
  const index = stateIndexAt(run.plan, t_ns);
  const [here, next, motion] = [states[index], states[index + 1], run.motions[index]];
  if (!next || !motion || t_ns <= motion[0]) return { place: here.position_um, turn: here.orientation };
  const share = (Math.min(t_ns, motion[1]) - motion[0]) / (motion[1] - motion[0]);
  const place = here.position_um.map((value, axis) => mix(value, next.position_um[axis], share));
  // A quaternion and its negative are the same turn: the near one is meant.
  const sign = here.orientation.reduce((sum, value, at) => sum + value * next.orientation[at], 0) < 0 ? -1 : 1;
  const turn = here.orientation.map((value, at) => mix(value, sign * next.orientation[at], share));
  const norm = Math.hypot(...turn) || 1;
  return { place, turn: turn.map((value) => value / norm) };
}

/** A vector turned by a unit quaternion. */
function turned([w, x, y, z], [a, b, c]) {
  const [p, q, r] = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
  return [a + w * p + y * r - z * q, b + w * q + z * p - x * r, c + w * r + x * q - y * p];
}

/** The point of a closed line that is nearest to a point. */
function nearestOn(points, [x, y]) {
  let nearest = points[0];
  let least = Infinity;
  points.forEach(([ax, ay], at) => {
    const [bx, by] = points[(at + 1) % points.length];
    const [dx, dy] = [bx - ax, by - ay];
    const share = Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1)));
    const point = [ax + share * dx, ay + share * dy];
    const apart = Math.hypot(x - point[0], y - point[1]);
    if (apart < least) [nearest, least] = [point, apart];
  });
  return nearest;
}

/**
 * The friction cone of a tip on an outline, in the plane of the section: its apex at the contact, and its two corners inside of the part,
 * `length` away. A force of the tip within it makes no slip (Coulomb). `tip` is the middle of the tip.
 */
function frictionCone(points, tip, friction, length) {
  const apex = nearestOn(points, tip);
  const [u, v] = [apex[0] - tip[0], apex[1] - tip[1]];
  const far = Math.hypot(u, v) || 1;
  const half_rad = Math.atan(friction);
  const corner = (angle) => {
    const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
    return [apex[0] + ((u * cos - v * sin) * length) / far, apex[1] + ((u * sin + v * cos) * length) / far];
  };
  return [apex, corner(-half_rad), corner(half_rad)];
}

/** Points round an outline of a section, counter-clockwise. */
function outlinePoints(outline, count = 96) {
  const angles = Array.from({ length: count }, (_, at) => (2 * Math.PI * at) / count);
  if (outline.ellipse) {
    const [a, b] = outline.ellipse.semi_um;
    return angles.map((angle) => [a * Math.cos(angle), b * Math.sin(angle)]);
  }
  if (outline.superellipse) {
    const { semi_um: [a, b], exponent } = outline.superellipse;
    const power = (value) => Math.sign(value) * Math.abs(value) ** (2 / exponent);
    return angles.map((angle) => [a * power(Math.cos(angle)), b * power(Math.sin(angle))]);
  }
  if (outline.rounded_rectangle) {
    const { half_um: [a, b], radius_um } = outline.rounded_rectangle;
    return angles.map((angle) => {
      const corner = Math.floor(angle / (Math.PI / 2));
      const [sx, sy] = [[1, 1], [-1, 1], [-1, -1], [1, -1]][corner];
      return [sx * (a - radius_um) + radius_um * Math.cos(angle), sy * (b - radius_um) + radius_um * Math.sin(angle)];
    });
  }
  return outline.spline.points_um;
}

/** Whether an outcome keeps a limit on it. */
function isKept(value, { relation, limit }) {
  return { at_most: value <= limit, at_least: value >= limit, less: value < limit, more: value > limit, equal: value === limit }[relation];
}

// Numbers as people read them

/** A number with at most `digits` significant digits. */
function short(value, digits = 4) {
  if (Number.isInteger(value) && Math.abs(value) < 1e15) return String(value);
  const text = Number(value).toPrecision(digits);
  return text.includes("e") ? text : String(Number(text));
}

/** A time with a unit that fits. */
function timeText(t_ns) {
  if (t_ns === 0) return "0 s";
  for (const [unit, size] of [["s", 1e9], ["ms", 1e6], ["us", 1e3]]) {
    if (Math.abs(t_ns) >= size) return `${short(t_ns / size, 5)} ${unit}`;
  }
  return `${t_ns} ns`;
}

/** How many SI units the unit at the end of an outcome's key has. */
const OUTCOME_UNITS = { deg: Math.PI / 180, j: 1, ns: 1e-9, um: 1e-6 };

/** The outcome of a key of the schedule, such as `distance_um`, and its value in SI units, in which claims have their limits. */
function outcomeOf(key, value) {
  const [, word, unit] = key.match(/^(.*)_(deg|j|ns|um)$/) || [null, key, null];
  return [word, unit ? value * OUTCOME_UNITS[unit] : value];
}

/** An outcome in SI units, in the unit of its word. */
function outcomeText(outcome, value) {
  if (outcome === "time") return timeText(value * 1e9);
  if (outcome === "distance") return `${short(value * 1e6)} um`;
  if (outcome === "energy") return `${short(value * 1e3)} mJ`;
  if (outcome === "effort") return `${short((value * 180) / Math.PI)} deg`;
  return short(value, 6);
}

/** Place and heading, in radians, of a robot in a state. */
function poseIn(state, name) {
  const { x_um, y_um, heading_deg } = state.poses[name];
  return [x_um, y_um, (heading_deg * Math.PI) / 180];
}
