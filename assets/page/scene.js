// Draws the scene of each kind of device at an instant, to scale.
//
// A view shows one device, or several DiMiBots that share a scene. Every view has `extent` (the corners that must be seen, in its own
// unit), `draw(pen, t_ns, lights)`, and `unit_um`, the length of its unit; a flat one also `spot(place)`, where a place of the program is in
// it. `lights` says what is pointed at (`hovered`), and what errors are about (`blamed`). A view that can be
// turned has `seen(place)`, where a place in space is in it.
"use strict";

/** Colours that people with any colour vision tell apart (Okabe and Ito). */
const TURNS = ["#56b4e9", "#e69f00", "#009e73", "#cc79a7", "#0072b2", "#d55e00", "#f0e442"];
const colorOf = (index) => TURNS[index % TURNS.length];

/** States of a path drawn behind and ahead of now: more would lie over one another. */
const TRAIL = 400;

/** The states of a plan about an index: those behind it, and those from it on. */
function around(list, index) {
  return [list.slice(Math.max(0, index + 1 - TRAIL), index + 1), list.slice(index, index + TRAIL)];
}

/** Whether a thing is lit: it is pointed at, or an error is about it. */
const isLit = (lights, name) => lights.hovered === name || lights.blamed.has(name);

/** Draws an obstacle: lit where it is pointed at, with a bright edge where an error is about it. */
function drawObstacle(pen, { name, shape, pose }, lights) {
  const { theme } = pen;
  if (lights.blamed.has(name)) drawShape(pen, shapePoints(shape, pose, 4 / pen.scale), theme.alarm);
  drawShape(pen, shapePoints(shape, pose), isLit(lights, name) ? theme.lit : theme.obstacle);
}

/** How corners of a thing are filled and edged. */
function obstacleStyle(theme, name, lights) {
  const edge = lights.blamed.has(name) ? { stroke: theme.alarm, width: 3 } : {};
  return { fill: isLit(lights, name) ? theme.lit : theme.obstacle, ...edge };
}

/** How a thing that moves is filled and edged. */
function moverStyle(theme, name, color, lights) {
  const stroke = lights.hovered === name ? theme.lit : lights.blamed.has(name) ? theme.alarm : theme.ink;
  return { fill: color, stroke, width: isLit(lights, name) ? 3 : 1 };
}

// DiMiBot

function dimibotView(devices) {
  const places = [];
  const cells = (order) => [2 ** order.facts.left - 1, 2 ** order.facts.right - 1];
  for (const device of devices) {
    for (const { order } of device.runs) {
      const [dx, dy] = pitchUm(order.facts);
      const [nx, ny] = cells(order);
      for (const corner of [[0, 0], [nx * dx, 0], [0, ny * dy], [nx * dx, ny * dy]]) places.push(inScene(order, corner));
    }
  }
  const view = { title: devices.map((device) => device.name).join(" and "), devices, unit_um: 1, extent: boxAbout(places), foot: 26 * devices.length + 8 };
  const solids = (run) => run.order.obstacles.filter((obstacle) => obstacle.body.solid);
  view.things = () => {
    const all = devices.flatMap((device) => device.runs.flatMap((run) => run.order.obstacles));
    return [...new Set(all.map((obstacle) => obstacle.name))];
  };
  view.hit = ([x, y]) => {
    for (const device of devices) {
      for (const obstacle of solids(device.runs[0])) {
        const { shape, pose } = obstacle.body.solid;
        const [u, v] = shapeMiddle(shape, pose);
        if (Math.hypot(x - u, y - v) < (shape.disc ? shape.disc.radius_um : 0.6)) return obstacle.name;
      }
    }
    return null;
  };
  view.spot = ({ unit, at: [x, y], device }) => {
    const { order } = (devices.find(({ name }) => name === device) || devices[0]).runs[0];
    const [dx, dy] = pitchUm(order.facts);
    return unit === "cells" ? inScene(order, [x * dx, y * dy]) : [x, y];
  };
  view.draw = (pen, t_ns, lights) => {
    const { theme } = pen;
    for (const device of devices) {
      const { order } = runAt(device, t_ns);
      const [dx, dy] = pitchUm(order.facts);
      const [nx, ny] = cells(order);
      const corners = [[0, 0], [nx * dx, 0], [nx * dx, ny * dy], [0, ny * dy]].map((corner) => inScene(order, corner));
      drawReaches(pen, device, ([column, row]) => inScene(order, [column * dx, row * dy]));
      pen.shape(corners, { stroke: theme.faint });
      if (dx * pen.scale > 5 && dy * pen.scale > 5) {
        pen.g.fillStyle = theme.dots;
        for (let column = 0; column <= nx; column += 1) {
          for (let row = 0; row <= ny; row += 1) {
            const [x, y] = pen.at(inScene(order, [column * dx, row * dy]));
            pen.g.fillRect(x - 1, y - 1, 2, 2);
          }
        }
      }
    }
    // Obstacles of a shared scene are every robot's; each is drawn once, with the largest growth.
    const seen = new Set();
    for (const device of devices) {
      const run = runAt(device, t_ns);
      const { facts } = run.order;
      for (const obstacle of run.order.obstacles) {
        if (seen.has(obstacle.name)) continue;
        seen.add(obstacle.name);
        if (obstacle.body.solid) {
          const { shape, pose } = obstacle.body.solid;
          drawShape(pen, shapePoints(shape, pose, facts.tip_radius_um + facts.repeatability_um), theme.grown);
          drawObstacle(pen, { name: obstacle.name, shape, pose }, lights);
          pen.text(shapeMiddle(shape, pose), obstacle.name, theme.ink, { align: "center" });
        } else {
          const { from, to } = obstacle.body.cells;
          const [dx, dy] = pitchUm(facts);
          const [a, b, c, d] = [from.x - 0.4, from.y - 0.4, to.x + 0.4, to.y + 0.4];
          const corners = [[a, b], [c, b], [c, d], [a, d]].map(([x, y]) => inScene(run.order, [x * dx, y * dy]));
          pen.shape(corners, obstacleStyle(theme, obstacle.name, lights));
          const middle = inScene(run.order, [((from.x + to.x) / 2) * dx, ((from.y + to.y) / 2) * dy]);
          pen.text(middle, obstacle.name, theme.ink, { align: "center", size: 11 });
        }
      }
    }
    devices.forEach((device, number) => drawDimibot(pen, device, t_ns, colorOf(number)));
    devices.forEach((device, number) => drawModules(pen, device, t_ns, number, devices.length));
  };
  return view;
}

function drawDimibot(pen, device, t_ns, color) {
  const { theme } = pen;
  const { plan, order } = runAt(device, t_ns);
  const place = (state) => inScene(order, state.position_um);
  const [behind, ahead] = around(plan.states, stateIndexAt(plan, t_ns));
  const tip = tipAt(device, t_ns);
  pen.line(ahead.map(place), theme.ahead, 1.5, [3, 4]);
  pen.line([...behind.map(place), tip], color, 2.5);
  const marked = new Set();
  order.steps.forEach((step) => {
    const stops = step.action.move || step.action.visit || [];
    for (const { cell } of stops) {
      if (marked.has(cell.x * 2 ** 32 + cell.y)) continue;
      marked.add(cell.x * 2 ** 32 + cell.y);
      const [dx, dy] = pitchUm(order.facts);
      const stop = inScene(order, [cell.x * dx, cell.y * dy]);
      pen.disc(stop, 0, { stroke: theme.stop, width: 2, least: 6 });
      const isAtEdge = pen.at(stop)[0] > pen.box.x + pen.box.width - 56;
      pen.text(stop, `(${cell.x}, ${cell.y})`, theme.stop, { dx: isAtEdge ? -10 : 10, align: isAtEdge ? "right" : "left", size: 11 });
    }
  });
  pen.disc(place(plan.states[0]), 0, { stroke: color, width: 1.5, least: 4 });
  pen.disc(tip, order.facts.tip_radius_um, { fill: color, stroke: theme.paper, width: 1.5, least: 5.5 });
}

/** The modules as switches, the top one first, with the pulse at work; below the scene. */
function drawModules(pen, device, t_ns, number, of) {
  const { g, theme, box } = pen;
  const run = runAt(device, t_ns);
  const { facts } = run.order;
  const { word } = stateAt(device, t_ns);
  const lit = new Map();
  for (const channel of device.channels) {
    const actuation = actuationAt(channel, t_ns);
    if (actuation && actuation.from !== 0) lit.set(channel.name.slice(device.name.length + 1, channel.name.lastIndexOf(".")), channel.name.split(".").pop());
  }
  const size = Math.min(20, (box.width - 150) / (facts.left + facts.right + 1));
  let x = box.x + 8;
  const y = box.y + box.height + 6 + 26 * number;
  Object.assign(g, { font: "12px system-ui, sans-serif", textAlign: "left", textBaseline: "middle", fillStyle: theme.ink });
  if (of > 1) {
    g.fillText(device.name, x, y + 9);
    x += 64;
  }
  for (const [side, count, shift] of [["bl", facts.left, facts.right], ["br", facts.right, 0]]) {
    g.fillStyle = theme.ink;
    g.textAlign = "left";
    g.fillText(side, x, y + 9);
    x += 20;
    for (let module = count - 1; module >= 0; module -= 1) {
      const isSet = Math.floor(word / 2 ** (shift + module)) % 2 === 1;
      const pulse = lit.get(`${side}${module}`);
      g.fillStyle = pulse ? theme.lit : isSet ? colorOf(number) : theme.panel;
      Object.assign(g, { strokeStyle: pulse ? theme.ink : theme.faint, lineWidth: pulse ? 2 : 1 });
      g.fillRect(x, y, size - 3, 18);
      g.strokeRect(x, y, size - 3, 18);
      g.fillStyle = isSet && !pulse ? "#fff" : theme.ink;
      if (pulse) g.fillStyle = "#111";
      g.textAlign = "center";
      g.fillText(pulse ? (pulse === "set" ? "▲" : "▼") : isSet ? "1" : "0", x + (size - 3) / 2, y + 9.5);
      x += size;
    }
    x += 12;
  }
}

// Electrode array

function arrayView(device) {
  const { facts } = device.runs[0].order;
  const view = {
    title: device.name,
    devices: [device],
    unit_um: 2 * facts.radius_um * (1 + facts.pitch_ratio),
    extent: [[0.3, 0.3], [facts.columns + 0.7, facts.rows + 0.7]],
  };
  view.things = () => [...new Set(device.runs.flatMap(({ order }) => [...order.parts, ...order.obstacles, ...zonesOf(order)].map((thing) => thing.name)))];
  view.hit = ([x, y], t_ns) => {
    for (const [name, place] of Object.entries(partsAt(device, t_ns))) {
      if (Math.hypot(x - place[0], y - place[1]) < facts.layout.half_width_pitches) return name;
    }
    for (const { name, body } of runAt(device, t_ns).order.obstacles) {
      if (!body.electrodes) continue;
      const { from, to } = body.electrodes;
      if (isWithin([x, y], from, to)) return name;
    }
    const zone = zonesOf(runAt(device, t_ns).order).find(({ from, to }) => isWithin([x, y], from, to));
    return zone ? zone.name : null;
  };
  view.spot = ({ unit, at }) => (unit === "cells" ? at : null);
  if (device.fluids.length) view.legend = ["left on electrodes:", device.fluids.map(({ name, part }) => [name, `${colorOf(part)}59`])];
  view.draw = (pen, t_ns, lights) => {
    drawBoard(pen, device, t_ns, lights);
    drawReaches(pen, device, (cell) => cell);
    drawParts(pen, device, t_ns, lights);
  };
  return view;
}

/** The heaters, detectors and magnets of a board. */
function zonesOf(order) {
  return order.zones || [];
}

function isWithin([x, y], from, to) {
  return x > from.column - 0.5 && x < to.column + 0.5 && y > from.row - 0.5 && y < to.row + 0.5;
}

/** The squares of zones, under the electrodes. */
function drawZones(pen, order, lights) {
  const { theme } = pen;
  for (const { name, sort, from, to } of zonesOf(order)) {
    const [low, high] = [[from.column - 0.5, from.row - 0.5], [to.column + 0.5, to.row + 0.5]];
    pen.shape([low, [high[0], low[1]], high, [low[0], high[1]]], { fill: theme[sort], stroke: isLit(lights, name) ? theme.lit : undefined, width: 2 });
  }
}

/** Their names, over the electrodes and at the rim, where droplets that stay there do not cover them. */
function nameZones(pen, order) {
  for (const { name, from, to } of zonesOf(order)) {
    pen.text([(from.column + to.column) / 2, to.row + 0.5], name, pen.theme.ink, { align: "center", dy: -4, size: 11 });
  }
}

function drawBoard(pen, device, t_ns, lights) {
  const { theme, g } = pen;
  const { order } = runAt(device, t_ns);
  const { facts } = order;
  const [x0, y0] = pen.at([0.5, facts.rows + 0.5]);
  g.fillStyle = theme.board;
  g.fillRect(x0, y0, facts.columns * pen.scale, facts.rows * pen.scale);
  const radius = 0.5 / (1 + facts.pitch_ratio);
  const isCoarse = pen.scale < 5;
  const channels = facts.map?.channels ?? [];
  const isGap = (column, row) => channels.length > 0 && channels[(row - 1) * facts.columns + column - 1] === null;
  const isDisabled = (column, row) => (facts.map?.disabled ?? []).some((cell) => cell.column === column && cell.row === row);
  g.fillStyle = theme.paper;
  for (let column = 1; column <= facts.columns; column += 1) {
    for (let row = 1; row <= facts.rows; row += 1) {
      if (isGap(column, row)) g.fillRect(...pen.at([column - 0.5, row + 0.5]), pen.scale, pen.scale);
    }
  }
  drawZones(pen, order, lights);
  g.fillStyle = theme.electrode;
  if (!isCoarse) {
    g.beginPath();
    for (let column = 1; column <= facts.columns; column += 1) {
      for (let row = 1; row <= facts.rows; row += 1) {
        if (isGap(column, row) || isDisabled(column, row)) continue;
        const [x, y] = pen.at([column, row]);
        g.moveTo(x + radius * pen.scale, y);
        g.arc(x, y, radius * pen.scale, 0, 2 * Math.PI);
      }
    }
    g.fill();
  }
  nameZones(pen, order);
  drawTraces(pen, device, t_ns);
  for (const { column, row } of facts.map?.disabled ?? []) pen.disc([column, row], radius, { stroke: theme.faint, least: 1.5 });
  for (const channel of device.channels) {
    const actuation = actuationAt(channel, t_ns);
    if (!actuation || actuation.from === 0) continue;
    const place = /\.e(\d+)_(\d+)$/.exec(channel.name);
    if (!place) continue;
    for (const cell of electrodesOn(facts, Number(place[1]), Number(place[2]))) {
      if (!isDisabled(...cell)) pen.disc(cell, radius * 1.15, { fill: theme.live, stroke: theme.liveEdge, least: 1.5 });
    }
  }
}

/** The electrodes on the channel that the first of them gives its name: one, or several that share it. */
function electrodesOn(facts, column, row) {
  const channels = facts.map?.channels ?? [];
  const number = channels[(row - 1) * facts.columns + column - 1];
  if (number === undefined || number === null) return [[column, row]];
  const cells = channels.map((other, index) => (other === number ? [(index % facts.columns) + 1, Math.floor(index / facts.columns) + 1] : null));
  return cells.filter((cell) => cell !== null);
}

/** What droplets have left on electrodes: a field in the colour of the fluid, or one stripe for each of several. */
function drawTraces(pen, device, t_ns) {
  const { g } = pen;
  const size = 0.84;
  for (const { cell, fluids } of tracesAt(device, t_ns)) {
    const width = size / fluids.length;
    fluids.forEach((fluid, at) => {
      const { part } = device.fluids.find(({ name }) => name === fluid);
      const [x, y] = pen.at([cell[0] - size / 2 + width * at, cell[1] + size / 2]);
      g.fillStyle = `${colorOf(part)}59`;
      g.fillRect(x, y, width * pen.scale, size * pen.scale);
    });
  }
}

function drawParts(pen, device, t_ns, lights) {
  const { theme } = pen;
  const run = runAt(device, t_ns);
  const { order, plan } = run;
  const half = order.facts.layout.half_width_pitches;
  const square = ([x, y], size) => [[x - size, y - size], [x + size, y - size], [x + size, y + size], [x - size, y + size]];
  for (const { name, body } of order.obstacles) {
    const [low, high] = body.electrodes
      ? [[body.electrodes.from.column - 0.45, body.electrodes.from.row - 0.45], [body.electrodes.to.column + 0.45, body.electrodes.to.row + 0.45]]
      : [[body.fixed.column - half, body.fixed.row - half], [body.fixed.column + half, body.fixed.row + half]];
    pen.shape([low, [high[0], low[1]], high, [low[0], high[1]]], obstacleStyle(theme, name, lights));
    pen.text([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2], name, theme.ink, { align: "center", size: 11 });
  }
  const [behind, ahead] = around(plan.states, stateIndexAt(plan, t_ns));
  const places = partsAt(device, t_ns);
  const stops = new Map();
  const whose = (move) => ("team" in move ? null : move.part);
  for (const move of movesOf(order)) stops.set(whose(move), [...(stops.get(whose(move)) || []), ...move.stops]);
  const mark = (stop, stroke) => pen.shape(square([stop.cell.column, stop.cell.row], 0.5), { stroke, width: 1.5, dash: [3, 2] });
  // A goal that any of several parts may take has none of their colours.
  for (const stop of stops.get(null) || []) mark(stop, theme.soft);
  order.parts.forEach(({ name }, number) => {
    const color = colorOf(number);
    const route = (states) => states.map((state) => state.parts[name]).filter(Boolean);
    pen.line(route(ahead), color, 1, [2, 4]);
    if (places[name]) pen.line([...route(behind), places[name]], color, 2);
    for (const stop of stops.get(number) || []) mark(stop, color);
  });
  order.parts.forEach(({ name }, number) => {
    const place = places[name];
    if (!place) return;
    const color = colorOf(number);
    const style = moverStyle(theme, name, color, lights);
    if (order.facts.layout.electrodes === "quad") pen.shape(square(place, half), style);
    else pen.disc(place, half, style);
    const isWide = half * 2 * pen.scale > 7 * name.length + 4;
    if (isWide || order.parts.length <= 24) {
      pen.text(place, name, theme.ink, { align: isWide ? "center" : "left", dx: isWide ? 0 : half * pen.scale + 4, size: 11, weight: "600" });
    }
  });
}

// Microrobots

function bedView(device) {
  const places = [];
  const reach = [];
  for (const { plan, order } of device.runs) {
    for (const state of plan.states) places.push(...Object.keys(state.poses).map((name) => poseIn(state, name)));
    for (const { pose } of [...order.obstacles, ...goalsOf(order)]) places.push([pose.x_um, pose.y_um]);
    reach.push(...order.facts.robots.map((robot) => 2 * robot.turning_radius_um + robot.length_um));
  }
  for (const { pose } of device.reaches) places.push(pose.slice(0, 2));
  const [low, high] = boxAbout(places, 0.02);
  const more = Math.max(...reach) / 2;
  const view = { title: device.name, devices: [device], unit_um: 1, extent: [low.map((v) => v - more), high.map((v) => v + more)] };
  view.places = places;
  view.things = () => [...new Set(device.runs.flatMap(({ order }) => [...order.obstacles.map((o) => o.name), ...order.robots.map(({ row }) => order.facts.robots[row].name)]))];
  view.hit = ([x, y], t_ns) => {
    for (const robot of robotsAt(device, t_ns)) {
      if (Math.hypot(x - robot.pose[0], y - robot.pose[1]) < robot.facts.length_um / 2) return robot.name;
    }
    return null;
  };
  view.spot = ({ unit, at }) => (unit === "um" ? at : null);
  view.draw = (pen, t_ns, lights) => {
    drawBed(pen, device, t_ns, lights, true);
    // A loupe shows what is there, and no inset.
    if (pen === view.pen) drawInset(pen, view, t_ns, lights);
  };
  return view;
}

/** Goals of a run: the poses of its stops and docks. */
function goalsOf(order) {
  const goals = [];
  for (const step of order.steps) {
    const { assemble, drive } = step.action;
    for (const dock of assemble || []) goals.push({ robot: dock.robot, pose: dock.goal.pose });
    if (drive) for (const stop of drive.stops) goals.push({ robot: drive.robot, pose: stop.pose });
  }
  return goals;
}

function bodyPoints(facts, [x, y, heading_rad]) {
  const [cos, sin] = [Math.cos(heading_rad), Math.sin(heading_rad)];
  const [a, b] = [facts.length_um / 2, facts.width_um / 2];
  return [[-a, -b], [a, -b], [a, b], [-a, b]].map(([u, v]) => [x + u * cos - v * sin, y + u * sin + v * cos]);
}

/** The path of a robot from a time on, as short lines. */
function trail(device, run, robot, upTo_ns) {
  const points = [];
  const { name } = robot.facts;
  for (const [index, state] of run.plan.states.entries()) {
    if (state.t_ns > upTo_ns) break;
    const end_ns = run.plan.states[index + 1] ? run.plan.states[index + 1].t_ns : run.plan.start_ns + run.plan.duration_ns;
    const isDown = state.arms[run.order.facts.robots.indexOf(robot.facts)] === 1;
    const until_ns = Math.min(end_ns, upTo_ns);
    const count = isDown ? 24 : 1;
    points.push(poseIn(state, name));
    for (let part = 1; part <= count; part += 1) {
      const at = robotsAt(device, state.t_ns + ((until_ns - state.t_ns) * part) / count - 1).find((other) => other.name === name);
      if (at) points.push(at.pose);
    }
  }
  return points;
}

function drawBed(pen, device, t_ns, lights, withNames) {
  const { theme } = pen;
  const run = runAt(device, t_ns);
  const { order } = run;
  for (const { name, shape, pose } of order.obstacles) {
    drawShape(pen, shapePoints(shape, pose, order.facts.clearance_um), theme.grown);
    drawObstacle(pen, { name, shape, pose }, lights);
    if (withNames) pen.text(shapeMiddle(shape, pose), name, theme.ink, { align: "center" });
  }
  for (const { robot, pose } of goalsOf(order)) {
    const facts = order.facts.robots[order.robots[robot].row];
    pen.shape(bodyPoints(facts, [pose.x_um, pose.y_um, pose.heading_rad]), { stroke: theme.stop, width: 1.5, dash: [4, 3] });
  }
  if (withNames) drawLastTry(pen, device, order);
  const robots = robotsAt(device, t_ns);
  robots.forEach((robot, number) => {
    if (withNames) pen.line(trailOf(device, run, robot, t_ns), colorOf(number), 1.25);
    if (robot.isDown && !robot.isDocked) {
      pen.disc(orbitCentre(robot.facts, robot.pose), robot.facts.turning_radius_um, { stroke: colorOf(number), dash: [5, 4] });
    }
  });
  robots.forEach((robot, number) => {
    pen.shape(bodyPoints(robot.facts, robot.pose), moverStyle(theme, robot.name, colorOf(number), lights));
    // The arm reaches out at the front, on the side to which the robot turns; it is filled where it touches the bed.
    const [x, y, heading_rad] = robot.pose;
    const side = robot.facts.turning === "clockwise" ? -1 : 1;
    const [cos, sin] = [Math.cos(heading_rad), Math.sin(heading_rad)];
    const [u, v] = [robot.facts.length_um * 0.3, side * robot.facts.width_um];
    const hand = [x + u * cos - v * sin, y + u * sin + v * cos];
    pen.line([[x + u * cos, y + u * sin], hand], theme.ink, 1.5);
    pen.disc(hand, robot.facts.width_um * 0.22, { fill: robot.isDown ? theme.alarm : theme.paper, stroke: theme.ink, least: 2.5 });
    // Docked robots stand close: their names are in the inset.
    if (withNames && !robot.isDocked) pen.text([x, y], robot.name, theme.ink, { dx: 10, dy: -14, size: 12, weight: "600" });
    if (!withNames && robot.isDocked) pen.text([x, y], robot.name, theme.ink, { align: "center", size: 10 });
  });
}

/** Where robots come too near to something on the way that was tried last. */
function drawLastTry(pen, { reaches }, { facts }) {
  for (const { what, pose } of reaches) {
    const robot = facts.robots.find(({ name }) => name === what);
    pen.shape(bodyPoints(robot, pose), { stroke: pen.theme.alarm, width: 2, dash: [3, 2] });
    pen.text(pose, `${what} too near`, pen.theme.alarm, { align: "center", dy: -robot.length_um * pen.scale * 0.5 - 8, size: 11, weight: "600" });
  }
}

/** Trails are kept: a leg that is over no longer changes. */
function trailOf(device, run, robot, t_ns) {
  device.trails = device.trails || new Map();
  const index = stateIndexAt(run.plan, t_ns);
  const key = `${run.index}/${robot.name}/${index}`;
  if (!device.trails.has(key)) device.trails.set(key, trail(device, run, robot, run.plan.states[index].t_ns - 1));
  const from_ns = run.plan.states[index].t_ns;
  const now = [];
  const count = robot.isDown ? 24 : 1;
  for (let part = 0; part <= count; part += 1) {
    const at = robotsAt(device, from_ns + ((t_ns - from_ns) * part) / count).find((other) => other.name === robot.name);
    now.push(at.pose);
  }
  return [...device.trails.get(key), ...now];
}

/** The corner of a view in which the least is to be seen while the program lasts, the top right first. */
function emptiestCorner(pen, places, size, margin) {
  const { x, y, width, height } = pen.box;
  const [left, right, top, bottom] = [x + 6, x + width - size - 6, y + 6, y + height - size - 6];
  const corners = [[right, top], [left, top], [left, bottom], [right, bottom]];
  const marks = places.map((place) => pen.at(place));
  const met = ([a, b]) => marks.filter(([u, v]) => u > a - margin && u < a + size + margin && v > b - margin && v < b + size + margin).length;
  return corners.reduce((best, corner) => (met(corner) < met(best) ? corner : best));
}

/** What is built, enlarged, once two robots are near their goals. */
function drawInset(pen, view, t_ns, lights) {
  const device = view.devices[0];
  const { plan, order } = runAt(device, t_ns);
  const goals = goalsOf(order);
  view.inset = null;
  // Without a plan nothing meets.
  if (plan.states.length < 2 || !order.steps.some((step) => step.action.assemble)) return;
  const { box, g, theme } = pen;
  const size = Math.min(box.width, box.height) * 0.34;
  const [low, high] = boxAbout(goals.map(({ pose }) => [pose.x_um, pose.y_um]), 0.1);
  const more = 260;
  const half = (Math.max(...order.facts.robots.map((robot) => robot.length_um)) / 2) * pen.scale;
  // Once for each size of the view, and not for each frame.
  if (!view.corner || view.corner.pen !== pen) view.corner = { pen, at: emptiestCorner(pen, view.places, size, half) };
  const [left, top] = view.corner.at;
  const inset = { x: left, y: top, width: size, height: size };
  view.inset = inset;
  const close = new Pen(pen.canvas, inset, [low.map((v) => v - more), high.map((v) => v + more)], theme);
  g.save();
  g.beginPath();
  g.rect(inset.x, inset.y, size, size);
  g.fillStyle = theme.panel;
  g.fill();
  g.clip();
  drawBed(close, device, t_ns, lights, false);
  g.restore();
  Object.assign(g, { strokeStyle: theme.faint, lineWidth: 1 });
  g.strokeRect(inset.x, inset.y, size, size);
  Object.assign(g, { font: "11px system-ui, sans-serif", textAlign: "left", textBaseline: "top", fillStyle: theme.soft });
  g.fillText("where they meet", inset.x + 6, inset.y + 5);
}

/** The views of a model: DiMiBots of one scene together, each other device alone. */
function viewsOf(model) {
  const views = [];
  const placed = new Map();
  for (const { scene, frames } of model.claims.shared || []) for (const name of Object.keys(frames)) placed.set(name, scene);
  for (const device of model.devices) {
    if (device.kind === "electrode_array") views.push(arrayView(device));
    if (device.kind === "microrobots") views.push(bedView(device));
    if (device.kind === "fingers") views.push(handView(device));
    if (device.kind !== "dimibot") continue;
    const scene = placed.get(device.name);
    const first = model.devices.find((other) => other.kind === "dimibot" && scene && placed.get(other.name) === scene) || device;
    if (first !== device) continue;
    const together = model.devices.filter((other) => other === device || (scene && placed.get(other.name) === scene));
    views.push(dimibotView(together));
  }
  return views;
}
