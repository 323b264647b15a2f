// Why a program could not be built, or a log was refused: its errors as cards, at their lines, instants and places in the scene.
"use strict";

/** Says at the top that the program was not built. */
function showRefusal(verdict, { failure }) {
  const errors = failure.findings.filter(({ severity }) => severity === "error").length;
  verdict.className = "failed";
  if (failure.is_refused) {
    verdict.textContent = `✗ refused: ${counted(errors, "violation")}`;
    verdict.title = "The scene shows what the log says, which breaks rules";
    return;
  }
  verdict.textContent = `✗ not built: ${counted(errors, "error")}`;
  verdict.title = "The scene shows what of the program could be built";
}

/** What is wrong: each finding with its places, and what the scene shows instead. */
function drawFailure(root, { failure, page, steps, devices }, { reveal, seek }) {
  let lastHelp = null;
  // Errors before warnings; each kind stays in the order of its places.
  const isWarning = ({ severity }) => Number(severity === "warning");
  for (const { code, severity, title, help, labels, t_ns, reaches } of [...failure.findings].sort((a, b) => isWarning(a) - isWarning(b))) {
    const card = add(root, "section", "", `card ${severity}`);
    const head = add(card, "p", "", "finding");
    add(head, "b", `${severity} ${code}`);
    head.append(` ${title}`);
    if (t_ns !== null && page.schedule) {
      const jump = add(card, "button", `at ${timeText(t_ns)}`, "jump instant");
      jump.type = "button";
      jump.addEventListener("click", () => seek(t_ns));
    }
    for (const reach of reaches || []) {
      const line = add(card, "p", "", "reached");
      const swatch = add(line, "span", "", reach.pose ? "swatch last" : "swatch");
      const own = partColors(devices.find(({ name }) => name === reach.device), reach);
      if (own) Object.assign(swatch.style, { background: own[0], borderColor: own[1] });
      line.append(reachText(reach));
    }
    for (const label of labels) {
      const place = `${label.file}:${label.line}`;
      const jump = add(card, "button", label.text ? `${place} ${label.text}` : place, "jump");
      jump.type = "button";
      jump.addEventListener("click", () => reveal(label));
    }
    // One that several have in common is said once.
    if (help && help !== lastHelp) add(card, "p", `help: ${help}`, "help");
    lastHelp = help;
  }
  if (failure.more) add(root, "p", `and ${failure.more} more`, "remark");
  if (!page.schedule) return;
  if (failure.is_refused) {
    add(add(root, "section", "", "card"), "p", "Shown is what the log says. No instrument should play it.", "remark");
    return;
  }
  const built = steps.length ? `${counted(steps.length, "step")}, planned and verified` : "the scene before the first step";
  add(add(root, "section", "", "card"), "p", `Shown is what could be built: ${built}.`, "remark");
}

/** How far something came in a search that found no plan. */
function reachText({ what, runs, plane, reached_deg, asked_deg, pose }) {
  if (runs) return `reached by ${what}: ${counted(runs.reduce((sum, [, first, last]) => sum + last - first + 1, 0), "cell")}`;
  if (plane) return `${what} turns ${short(reached_deg, 6)} of ${short(asked_deg, 6)} deg about ${plane === "xy" ? "z" : "y"}`;
  return `${what} comes to (${pose.slice(0, 2).map((value) => short(value, 6)).join(", ")}) um`;
}

/** The colours of what a part has reached, where several parts keep one another from their goals; null otherwise. */
function partColors(device, reach) {
  if (!device || !device.reaches.some((one) => one.isShared && one.what === reach.what)) return null;
  const color = colorOf(device.runs[0].order.parts.findIndex(({ name }) => name === reach.what));
  return [`${color}30`, color];
}

/** Share of a scene by which it grows to say that a place is far outside of it. */
const GROWTH = 0.3;

/** Sizes of a scene beyond which a place outside of it is too far away to be shown to scale. */
const FAR = 1.5;

/** The places of a view that errors are about, those far outside of the scene drawn in to its edge; the view grows to show them. */
function placeFaults(view, places) {
  const [low, high] = view.extent;
  const isOfView = ({ device }) => device === null || view.devices.some(({ name }) => name === device);
  const spots = view.spot ? places.filter(isOfView).map((place) => ({ place, at: view.spot(place) })).filter(({ at }) => at) : [];
  const size = Math.max(...[0, 1].map((axis) => high[axis] - low[axis]));
  const within = (at, more) => at.map((value, axis) => Math.min(high[axis] + more * size, Math.max(low[axis] - more * size, value)));
  const named = spots.map(({ place, at }) => {
    const words = `(${place.at.map((value) => short(value)).join(", ")})${place.unit === "um" ? " um" : ""}`;
    const isFar = within(at, FAR).some((value, axis) => value !== at[axis]);
    return isFar ? [`far off: ${words}`, within(at, GROWTH)] : [words, at];
  });
  view.faults = [...new Map(named)].map(([words, at]) => ({ words, at }));
  if (view.faults.length) {
    const [least, most] = boxAbout([...view.faults.map(({ at }) => at)], 0);
    const more = 0.04 * size;
    view.extent = [low.map((value, axis) => Math.min(value, least[axis] - more)), high.map((value, axis) => Math.max(value, most[axis] + more))];
  }
}

/** Shades what a proof has reached, with an edge round it; `place` leads from columns and rows into the scene. */
function drawReaches(pen, device, place) {
  const { g, theme } = pen;
  for (const reach of device.reaches) {
    const { runs, edges } = reach;
    const [fill, edge] = partColors(device, reach) || [theme.reached, theme.reachedEdge];
    g.fillStyle = fill;
    g.beginPath();
    for (const [row, first, last] of runs) {
      const corners = [[first - 0.5, row - 0.5], [last + 0.5, row - 0.5], [last + 0.5, row + 0.5], [first - 0.5, row + 0.5]];
      corners.forEach((corner, at) => (at ? g.lineTo(...pen.at(place(corner))) : g.moveTo(...pen.at(place(corner)))));
      g.closePath();
    }
    g.fill();
    g.beginPath();
    for (const [from, to] of edges) {
      g.moveTo(...pen.at(place(from)));
      g.lineTo(...pen.at(place(to)));
    }
    Object.assign(g, { strokeStyle: edge, lineWidth: 1.5, lineCap: "round" });
    g.stroke();
  }
}

/** Rings the places that errors are about, and names each where there is room for it. */
function drawFaults(pen, faults) {
  if (faults.length === 0) return;
  const { g, theme } = pen;
  const radius = 9;
  const taken = pen.texts.map((text) => boxOfText(g, text));
  for (const { at } of faults) {
    const [x, y] = pen.at(at);
    for (const [color, width] of [[theme.paper, 6], [theme.alarm, 3]]) {
      Object.assign(g, { strokeStyle: color, lineWidth: width, lineCap: "butt" });
      g.beginPath();
      g.arc(x, y, radius, 0, 2 * Math.PI);
      for (const [dx, dy] of [[1, 1], [-1, 1], [1, -1], [-1, -1]]) {
        g.moveTo(x + radius * Math.SQRT1_2 * dx, y + radius * Math.SQRT1_2 * dy);
        g.lineTo(x + (radius + 4) * dx, y + (radius + 4) * dy);
      }
      g.stroke();
    }
    taken.push([x - radius, y - radius, x + radius, y + radius]);
  }
  for (const { at, words } of faults) {
    const [x, y] = pen.at(at);
    // A goal names itself.
    if (pen.texts.some((text) => text.words === words && Math.hypot(text.x - x, text.y - y) < 60)) continue;
    for (const [dx, dy, align] of [[14, -14, "left"], [-14, -14, "right"], [14, 14, "left"], [-14, 14, "right"], [0, -26, "center"], [0, 26, "center"]]) {
      const corners = boxOfText(g, { words, x: x + dx, y: y + dy, align, size: 12 });
      if (!pen.isFree(corners, taken)) continue;
      pen.text(at, words, theme.alarm, { dx, dy, align, weight: "600" });
      taken.push(corners);
      break;
    }
  }
}
