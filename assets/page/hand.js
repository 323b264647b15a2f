// Draws the scene of a hand: part and tips in space, seen from any side, with the contacts, friction cones and forces of the fingers that hold.
"use strict";

function handView(device) {
  const { order } = device.runs[0];
  const sections = [["xy", order.part.xy], ["xz", order.part.xz]].filter(([, section]) => section);
  const outlines = sections.map(([plane, { outline }]) => ({
    plane,
    points: outlinePoints(outline).map(([u, v]) => (plane === "xy" ? [u, v, 0] : [u, 0, v])),
  }));
  const size = Math.max(...outlines.flatMap(({ points }) => points.map((point) => Math.hypot(...point))));
  const reach = size + 3.2 * order.facts.tip_radius_um;
  const view = { title: device.name, devices: [device], unit_um: 1, extent: [[-reach, -reach], [reach, reach]], turnable: true, yaw: -0.5, pitch: outlines.length > 1 ? 0.5 : 1.1 };
  view.things = () => [order.part.name];
  view.hit = ([x, y]) => (Math.hypot(x, y) < reach / 3 ? order.part.name : null);
  // World z is up; the viewer looks along the third of these.
  view.seen = ([x, y, z]) => {
    const [cy, sy, cp, sp] = [Math.cos(view.yaw), Math.sin(view.yaw), Math.cos(view.pitch), Math.sin(view.pitch)];
    const [u, v] = [x * cy - y * sy, x * sy + y * cy];
    return [u, z * cp + v * sp, v * cp - z * sp];
  };
  // Turns until a direction is seen across, by as little as can be: then nothing at its ends hides what is between them.
  view.face = ([x, y, z]) => {
    const flat = Math.hypot(x, y);
    const most = Math.atan2(flat, Math.abs(z));
    view.pitch = Math.min(most, Math.max(-most, view.pitch));
    const lean = flat > 0 ? Math.asin(Math.min(1, Math.max(-1, (z * Math.tan(view.pitch)) / flat))) : 0;
    const turns = [lean, Math.PI - lean].map((turn) => Math.atan2(Math.sin(turn - Math.atan2(y, x) - view.yaw), Math.cos(turn - Math.atan2(y, x) - view.yaw)));
    view.yaw += Math.abs(turns[0]) < Math.abs(turns[1]) ? turns[0] : turns[1];
  };
  view.draw = (pen, t_ns, lights) => {
    const { theme } = pen;
    const { seen } = view;
    drawAxes(pen, seen, reach);
    const part = partAt(device, t_ns);
    const placed = (point) => seen(turned(part.turn, point).map((value, axis) => value + part.place[axis]));
    const state = stateAt(device, t_ns);
    for (const { plane, points } of outlines) {
      const isInUse = state.plane === plane;
      pen.shape(points.map(placed), {
        fill: isInUse ? theme.section : undefined,
        stroke: lights.hovered === order.part.name ? theme.lit : isInUse ? theme.ink : theme.faint,
        width: isInUse ? 2 : 1,
      });
    }
    const held = outlines.find(({ plane }) => plane === state.plane) || outlines[0];
    const fingers = tipsAt(device, t_ns);
    const cones = conesOf(order, part, held, fingers);
    for (const [finger, cone] of cones) {
      pen.shape(cone.map(placed), { fill: `${colorOf(finger)}40`, stroke: colorOf(finger) });
    }
    const forces = forcesAt(device, t_ns);
    if (forces) drawForces(pen, cones, forces, placed);
    for (const turn of device.reaches) drawTurn(pen, turn, 0.5 * size, placed);
    const mark = outlines[0].points[0];
    pen.disc(placed(mark), 0, { fill: theme.ink, least: 3 });
    const tips = fingers.map((tip, finger) => ({ ...tip, finger, spot: seen(tip.place) }));
    tips.sort((a, b) => b.spot[2] - a.spot[2]);
    for (const { spot, contact, finger } of tips) {
      const color = colorOf(finger);
      if (contact) pen.line([spot, seen(part.place)], color, 1, [3, 3]);
      pen.disc(spot, order.facts.tip_radius_um, { fill: contact ? color : theme.panel, stroke: color, width: 2 });
    }
    for (const { spot, contact, finger } of tips) {
      const words = contact ? `f${finger + 1} on ${contact}` : `f${finger + 1}`;
      pen.text(spot, words, theme.ink, { align: "center", dy: order.facts.tip_radius_um * pen.scale + 10, size: 11 });
    }
    const words = `cones: friction ${short(order.facts.friction)}; ${forces ? "arrows: forces in balance; " : ""}drag to turn the view`;
    pen.text([-reach, -reach], words, theme.soft, { dx: 4, dy: -8, size: 11 });
  };
  return view;
}

/** The friction cones of the fingers that hold, in the frame of the part. */
function conesOf({ facts }, part, { plane, points }, tips) {
  const across = plane === "xy" ? 1 : 2;
  const flat = (point) => [point[0], point[across]];
  const back = [part.turn[0], ...part.turn.slice(1).map((value) => -value)];
  const solid = ([u, v]) => (plane === "xy" ? [u, v, 0] : [u, 0, v]);
  const outline = points.map(flat);
  const length = 0.8 * Math.min(...outline.map((point) => Math.hypot(...point)));
  return tips.flatMap(({ place, contact }, finger) => {
    if (!contact) return [];
    const tip = turned(back, place.map((value, axis) => value - part.place[axis]));
    return [[finger, frictionCone(outline, flat(tip), facts.friction, length).map(solid)]];
  });
}

/** The forces of the fingers on the part, from each contact on; the greatest is as long as the cones. */
function drawForces(pen, cones, forces, placed) {
  const { g, theme } = pen;
  const greatest = Math.max(...forces.map((force) => (force ? Math.hypot(...force) : 0))) || 1;
  for (const [finger, [apex, corner]] of cones) {
    const force = forces[finger];
    if (!force) continue;
    const length = Math.hypot(...corner.map((value, axis) => value - apex[axis])) / greatest;
    const [tail, head] = [apex, apex.map((value, axis) => value + force[axis] * length)].map((place) => pen.at(placed(place)));
    const far = Math.hypot(head[0] - tail[0], head[1] - tail[1]);
    if (far < 3) continue;
    const [u, v] = [(head[0] - tail[0]) / far, (head[1] - tail[1]) / far];
    for (const [color, width] of [[theme.paper, 5], [theme.ink, 2.2]]) {
      Object.assign(g, { strokeStyle: color, lineWidth: width, lineCap: "round", lineJoin: "round" });
      g.beginPath();
      g.moveTo(...tail);
      g.lineTo(...head);
      g.moveTo(head[0] - 7 * u - 4 * v, head[1] - 7 * v + 4 * u);
      g.lineTo(...head);
      g.lineTo(head[0] - 7 * u + 4 * v, head[1] - 7 * v - 4 * u);
      g.stroke();
    }
  }
}

/** How far a turn comes of which no end was reached: a sector from where contact 1 is, and the rest of it as a dashed arc. */
function drawTurn(pen, { plane, reached_deg, asked_deg }, radius, placed) {
  const { theme } = pen;
  const at = (deg) => {
    const [u, v] = [radius * Math.cos((deg * Math.PI) / 180), radius * Math.sin((deg * Math.PI) / 180)];
    return placed(plane === "xy" ? [u, v, 0] : [u, 0, -v]);
  };
  const arc = (from, to) => Array.from({ length: 49 }, (_, part) => at(from + ((to - from) * part) / 48));
  const reached = arc(0, reached_deg);
  pen.shape([placed([0, 0, 0]), ...reached], { fill: theme.reached, stroke: theme.reachedEdge, width: 1.5 });
  pen.line(arc(reached_deg, asked_deg), theme.alarm, 1.5, [4, 3]);
  pen.disc(at(asked_deg), 0, { stroke: theme.alarm, least: 4 });
  pen.text(reached[reached.length - 1], `${short(reached_deg, 6)} of ${short(asked_deg, 6)} deg`, theme.ink, { dx: 8, dy: -8, size: 11 });
}

function drawAxes(pen, seen, reach) {
  const { theme } = pen;
  const at = [-reach * 0.82, reach * 0.78];
  [["x", [1, 0, 0]], ["y", [0, 1, 0]], ["z", [0, 0, 1]]].forEach(([name, axis], number) => {
    const [u, v] = seen(axis);
    const end = [at[0] + u * reach * 0.15, at[1] + v * reach * 0.15];
    pen.line([at, end], colorOf([5, 2, 0][number]), 2);
    pen.text(end, name, theme.soft, { align: "center", dx: u * 9, dy: -v * 9, size: 11 });
  });
}
