// The tightest clearances: what the verifier measured, and a ruler between the two points that come nearest to each other.
"use strict";

/** What comes near to what, by the rule that limits it, and how the needed gap is meant. */
const GAPS = {
  E0727: ["tip to obstacle", "more than"],
  E0770: ["tip to tip", "more than"],
  E0734: ["part to part", "at least"],
  E0735: ["part to obstacle", "at least"],
  E0746: ["robot to obstacle", "at least"],
  E0747: ["robot to robot", "at least"],
  E0760: ["fingertip to fingertip", "at least"],
};

/** A gap in its unit; that of electrodes is counted from centre to centre. */
function gapText(gap, unit) {
  return unit === "um" ? `${short(gap)} um` : counted(gap, "electrode");
}

/** The card of the clearances; each leads to its instant and to its ruler. */
function drawClearances(root, { page, devices }, measure) {
  const { clearances = [] } = page.evidence || {};
  if (clearances.length === 0) return;
  const card = add(root, "section", "", "card clearances");
  add(card, "h3", "Tightest clearance");
  for (const found of clearances) {
    const [what, how] = GAPS[found.code];
    const of = devices.length > 1 && !found.between.includes(found.device) ? ` on ${found.device}` : "";
    card.append(claimRow(`${what}${of}`, gapText(found.gap, found.unit)));
    const jump = add(card, "button", `${found.between.join(" – ")} at ${timeText(found.t_ns)}`, "jump instant");
    jump.type = "button";
    jump.title = "jump there and draw the ruler";
    jump.addEventListener("click", () => measure(found));
    const off = found.within ? `, measured to ${short(found.within)} um` : "";
    add(card, "p", `${how} ${gapText(found.needed, found.unit)} needed${off}`, "remark");
  }
}

/** The card of the rules, each with the number of things that it was asked of. */
function drawRules(root, { page }) {
  const { rules = [] } = page.evidence || {};
  if (rules.length === 0) return;
  const card = add(root, "section", "", "card");
  const list = add(card, "details", "", "rules");
  const total = rules.reduce((sum, { times }) => sum + times, 0);
  const head = add(list, "summary", "What the verifier checked");
  add(head, "span", `${counted(rules.length, "rule")}, ${total.toLocaleString("en")} times`);
  for (const { code, says, times } of rules) {
    const line = claimRow(says.replaceAll("`", ""), times.toLocaleString("en"), "rule");
    line.title = `a violation would be ${code}`;
    list.append(line);
  }
}

/** Gaps on the canvas below which a ruler is drawn in a loupe. */
const NARROW = 40;

/** Share of the scene that a loupe takes, gaps from its middle to its side, and how much it must enlarge to be of use. */
const LOUPE = 0.42;
const LOUPE_GAPS = 1.9;
const LOUPE_TIMES = 1.6;

/** A ruler between two points of a view, in a loupe where they are too near to each other to be seen apart. */
function drawRuler(pen, view, clearance, drawScene) {
  const marks = clearance.points.map((point) => (view.seen ? view.seen(point) : point.slice(0, 2)));
  const [from, to] = marks.map((mark) => pen.at(mark));
  view.ruled = pen;
  const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
  const { g, theme, box } = pen;
  const size = Math.min(box.width, box.height) * LOUPE;
  const half = LOUPE_GAPS * Math.hypot(...clearance.points[0].map((value, axis) => value - clearance.points[1][axis])) || 1;
  const times = size / (2 * half) / pen.scale;
  if (length >= NARROW || times < LOUPE_TIMES) {
    const [u, v] = length > 1e-3 ? [(to[0] - from[0]) / length, (to[1] - from[1]) / length] : [1, 0];
    return drawGap(pen, marks, clearance, view, [18, 30, 46, 64].flatMap((far) => [[-v * far, u * far], [v * far, -u * far]]));
  }
  const middle = [0, 1].map((axis) => (marks[0][axis] + marks[1][axis]) / 2);
  const [x, y] = pen.at(middle);
  const [right, bottom] = [box.x + box.width - size, box.y + box.height - size];
  const all = [[box.x, box.y], [right, box.y]];
  // A corner may be taken by the inset of a bed, those at the bottom by the words of a hand.
  if (view.devices[0].kind !== "fingers") all.push([box.x, bottom], [right, bottom]);
  const isTaken = (corner, inset) => Math.abs(corner[0] - inset.x) < size && Math.abs(corner[1] - inset.y) < size;
  const corners = all.filter((corner) => !view.inset || !isTaken(corner, view.inset));
  // The nearest corner that is clear of the place itself.
  const off = ([left, top]) => Math.hypot(left + size / 2 - x, top + size / 2 - y);
  const clear = corners.filter((corner) => off(corner) > size * 0.75 + 30);
  const [left, top] = (clear.length ? clear : corners).reduce((best, corner) => (off(corner) < off(best) ? corner : best));
  const place = { x: left, y: top, width: size, height: size };
  const loupe = new Pen(pen.canvas, place, [middle.map((value) => value - half), middle.map((value) => value + half)], theme);
  view.ruled = loupe;
  // Where it is: a ring, and a line from there to the loupe.
  const way = [left + size / 2 - x, top + size / 2 - y];
  const far = Math.hypot(...way) || 1;
  for (const [color, width] of [[theme.paper, 5], [theme.ruler, 2]]) {
    Object.assign(g, { strokeStyle: color, lineWidth: width, lineCap: "butt" });
    g.beginPath();
    g.arc(x, y, 11, 0, 2 * Math.PI);
    g.moveTo(x + (11 * way[0]) / far, y + (11 * way[1]) / far);
    g.lineTo(left + size / 2, top + size / 2);
    g.stroke();
  }
  g.save();
  g.beginPath();
  g.rect(left, top, size, size);
  g.fillStyle = theme.paper;
  g.fill();
  g.clip();
  drawScene(loupe);
  drawGap(loupe, marks, clearance, view, [[0, size / 2 - 14], [0, 34 - size / 2], [0, size / 2 - 34]]);
  g.restore();
  Object.assign(g, { strokeStyle: theme.ruler, lineWidth: 1.5 });
  g.strokeRect(left, top, size, size);
  const words = `${times >= 10 ? Math.round(times) : short(times, 2)} × enlarged`;
  Object.assign(g, { font: "11px system-ui, sans-serif", textAlign: "left", textBaseline: "top", lineWidth: 3, strokeStyle: theme.paper, fillStyle: theme.soft });
  g.strokeText(words, left + 6, top + 5);
  g.fillText(words, left + 6, top + 5);
}

/** Where the tips of DiMiBots may be that a clearance is about: a pulse may have brought them there at any instant of its own. */
function tipsOf({ code, between, points }, view) {
  if (code !== "E0727" && code !== "E0770") return [];
  return points.flatMap((point, end) => {
    const device = view.devices.find(({ name }) => name === between[end]);
    if (!device) return [];
    const radius = device.runs[0].order.facts.tip_radius_um;
    const other = points[1 - end];
    const far = Math.hypot(point[0] - other[0], point[1] - other[1]) || 1;
    return [{ at: [0, 1].map((axis) => point[axis] + ((point[axis] - other[axis]) * radius) / far), radius }];
  });
}

/** Marks at both ends of a gap, arrows between them, and its length at the first free one of some places from its middle. */
function drawGap(pen, marks, clearance, view, places) {
  const { g, theme } = pen;
  for (const { at, radius } of tipsOf(clearance, view)) pen.disc(at, radius, { stroke: theme.ruler, dash: [4, 3] });
  const [from, to] = marks.map((mark) => pen.at(mark));
  const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
  const [u, v] = length > 1e-3 ? [(to[0] - from[0]) / length, (to[1] - from[1]) / length] : [1, 0];
  const strokes = [[from, to]];
  for (const [[x, y], way] of [[from, 1], [to, -1]]) {
    strokes.push([[x - 9 * v, y + 9 * u], [x + 9 * v, y - 9 * u]]);
    strokes.push([[x + way * (6 * u - 3.5 * v), y + way * (6 * v + 3.5 * u)], [x, y], [x + way * (6 * u + 3.5 * v), y + way * (6 * v - 3.5 * u)]]);
  }
  Object.assign(g, { lineJoin: "round", lineCap: "round" });
  for (const [color, width] of [[theme.paper, 5], [theme.ruler, 2]]) {
    Object.assign(g, { strokeStyle: color, lineWidth: width });
    g.beginPath();
    for (const [first, ...others] of strokes) {
      g.moveTo(...first);
      others.forEach((point) => g.lineTo(...point));
    }
    g.stroke();
  }
  const words = gapText(clearance.gap, clearance.unit);
  const [x, y] = [(from[0] + to[0]) / 2, (from[1] + to[1]) / 2];
  const taken = pen.texts.map((text) => boxOfText(g, text));
  const spots = places.map(([dx, dy]) => ({ dx, dy, align: dx > 6 ? "left" : dx < -6 ? "right" : "center" }));
  const boxAt = ({ dx, dy, align }) => boxOfText(g, { words, x: x + dx, y: y + dy, align, size: 13 });
  const spot = spots.find((one) => pen.isFree(boxAt(one), taken)) || spots[0];
  pen.text(pen.under([x, y]), words, theme.ruler, { ...spot, size: 13, weight: "700" });
}
