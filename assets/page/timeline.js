// The strip under the scene: steps as blocks, operations by parts where they overlap, other outputs, then the channels of each device, all on one clock.
"use strict";

const RULER = 20;
const LABELS = 118;

/** Rows of the strip, from top to bottom. */
function rowsOf(model) {
  const rows = [];
  const lanes = new Map();
  model.steps.forEach((step, index) => {
    const { device } = model.schedule.plans[step.plan];
    if (!lanes.has(device)) {
      lanes.set(device, { kind: "steps", label: device, steps: [], height: 24, gap: 4 });
      rows.push(lanes.get(device));
    }
    lanes.get(device).steps.push({ ...step, index });
  });
  for (const device of model.devices) rows.push(...operationRows(model, device));
  // Other outputs of the bench have a scale each: a trigger at 5 V beside a valve at 24 V.
  const others = model.channels.filter((channel) => channel.actuations.length && !model.devices.some(({ name }) => name === channel.device));
  others.forEach((channel, number) => {
    const values = [0, channel.rest_v || 0, ...channel.actuations.map(({ from }) => from)];
    const range = [Math.min(...values), Math.max(...values)];
    rows.push({ kind: "channel", label: channel.device, channel, range, height: 12, gap: number ? 2 : 6 });
  });
  for (const device of model.devices) {
    if (device.kind === "microrobots") {
      rows.push({ kind: "ladder", label: `${device.name} (V)`, device, height: 120, gap: 8 });
    } else {
      const used = device.channels.filter((channel) => channel.actuations.length);
      const values = used.flatMap((channel) => [channel.rest_v || 0, ...channel.actuations.flatMap(({ from, to }) => [from, to])]);
      const range = [Math.min(0, ...values), Math.max(0, ...values)];
      used.forEach((channel, number) => {
        const label = model.devices.length > 1 ? channel.name : channel.name.slice(device.name.length + 1);
        const height = channel.unit === "um" ? 18 : used.length > 40 ? 7 : 12;
        rows.push({ kind: "channel", label, channel, range, height, gap: number ? 0 : 6, device });
      });
    }
  }
  let y = RULER;
  for (const row of rows) {
    y += row.gap;
    row.y = y;
    y += row.height;
  }
  return { rows, height: y + 4 };
}

/** A row for each part that does something of its own, in the order of the scene. */
function operationRows(model, device) {
  const steps = model.steps.filter((step) => step.operations && model.schedule.plans[step.plan].device === device.name);
  const works = steps.flatMap((step) => step.operations.map((own) => ({ ...step, ...own })));
  const names = works.length ? device.runs[0].order.parts.map((part) => part.name) : [];
  const rowOf = (name, number) => ({
    kind: "operations", label: name, color: colorOf(number), steps: works.filter((work) => work.parts.includes(name)).map(onItsWay), height: 15, gap: 1,
  });
  // An operation of two begins when the first of them is free; each is on its way only when it is free itself.
  const onItsWay = (work, index, own) => {
    const before = own[index - 1];
    return { ...work, way_ns: before ? Math.max(work.start_ns, before.start_ns + before.duration_ns) : work.start_ns };
  };
  return names.map(rowOf).filter((row) => row.steps.length);
}

/** A step between ticks that people count in, for about `count` ticks. */
function tickOf(span, count) {
  const raw = span / count;
  const size = 10 ** Math.floor(Math.log10(raw));
  return [1, 2, 5, 10].map((factor) => factor * size).find((tick) => tick >= raw);
}

class Timeline {
  constructor(canvas, model, theme, seek) {
    Object.assign(this, { canvas, model, theme, seek, ...rowsOf(model), from_ns: 0, to_ns: Math.max(1, model.duration_ns), scroll: 0, hover: null });
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.isHeld = true;
      this.seekTo(event);
    });
    canvas.addEventListener("pointermove", (event) => {
      this.hover = [event.offsetX, event.offsetY];
      if (this.isHeld) this.seekTo(event);
      canvas.title = this.titleAt(event.offsetX, event.offsetY);
    });
    canvas.addEventListener("pointerup", () => { this.isHeld = false; });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      if (event.ctrlKey || event.metaKey) this.zoom(Math.exp(event.deltaY / 300), this.timeAt(event.offsetX));
      else if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) this.pan((event.deltaX || event.deltaY) / this.width());
      else this.scroll += event.deltaY;
      this.onChange();
    }, { passive: false });
  }

  width() {
    return Math.max(1, this.canvas.clientWidth - LABELS);
  }

  timeAt(x) {
    return this.from_ns + ((x - LABELS) / this.width()) * (this.to_ns - this.from_ns);
  }

  xOf(t_ns) {
    return LABELS + ((t_ns - this.from_ns) / (this.to_ns - this.from_ns)) * this.width();
  }

  seekTo(event) {
    this.seek(Math.round(Math.min(this.model.duration_ns, Math.max(0, this.timeAt(event.offsetX)))));
  }

  zoom(factor, about_ns) {
    const span = Math.min(this.model.duration_ns, Math.max(1000, (this.to_ns - this.from_ns) * factor));
    const share = (about_ns - this.from_ns) / (this.to_ns - this.from_ns);
    this.from_ns = Math.min(this.model.duration_ns - span, Math.max(0, about_ns - share * span));
    this.to_ns = this.from_ns + Math.max(1, span);
  }

  pan(share) {
    const span = this.to_ns - this.from_ns;
    this.from_ns = Math.min(this.model.duration_ns - span, Math.max(0, this.from_ns + share * span));
    this.to_ns = this.from_ns + span;
  }

  /** Moves the window so that it shows an instant. */
  follow(t_ns) {
    if (t_ns >= this.from_ns && t_ns <= this.to_ns) return;
    const span = this.to_ns - this.from_ns;
    this.from_ns = Math.min(Math.max(0, t_ns - span * 0.1), Math.max(0, this.model.duration_ns - span));
    this.to_ns = this.from_ns + span;
  }

  rowAt(y) {
    return this.rows.find((row) => y + this.scroll >= row.y && y + this.scroll < row.y + row.height);
  }

  titleAt(x, y) {
    const row = this.rowAt(y);
    const t_ns = this.timeAt(x);
    if (!row || x < LABELS) return row && row.channel ? row.channel.name + (row.channel.wire ? ` → ${row.channel.wire}` : "") : "";
    if (row.kind === "steps" || row.kind === "operations") {
      const step = row.steps.find(({ start_ns, duration_ns }) => t_ns >= start_ns && t_ns < start_ns + duration_ns);
      return step ? `${step.file}:${step.line} ${step.text}\n${timeText(step.start_ns)} to ${timeText(step.start_ns + step.duration_ns)}` : "";
    }
    const channel = row.channel || row.device.channels[0];
    return `${channel.name}: ${short(valueAt(channel, t_ns))} ${channel.unit} at ${timeText(Math.round(t_ns))}`;
  }

  draw(t_ns) {
    const { canvas, theme } = this;
    const [width, height, ratio] = [canvas.clientWidth, canvas.clientHeight, window.devicePixelRatio || 1];
    const size = [Math.round(width * ratio), Math.round(height * ratio)];
    if (!size[0] || !size[1]) return;
    if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
    this.scroll = Math.max(0, Math.min(this.scroll, this.height - height));
    const hovered = this.hover ? this.rows.indexOf(this.rowAt(this.hover[1])) : -1;
    // All but the steps at work and the line of now stays from frame to frame.
    const key = [...size, this.from_ns, this.to_ns, this.scroll, hovered, theme.paper].join();
    if (key !== this.key) {
      this.key = key;
      this.still = this.still || document.createElement("canvas");
      [this.still.width, this.still.height] = size;
      this.drawStill(this.still.getContext("2d"), [width, height, ratio]);
    }
    const g = canvas.getContext("2d");
    g.setTransform(1, 0, 0, 1, 0, 0);
    g.clearRect(0, 0, ...size);
    g.drawImage(this.still, 0, 0);
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.inRows(g, [width, height], (row) => row.kind === "steps" && this.drawSteps(g, row, (step) => t_ns >= step.start_ns && t_ns < step.start_ns + step.duration_ns, theme.blockNow));
    const x = this.xOf(t_ns);
    if (x >= LABELS - 1) {
      Object.assign(g, { strokeStyle: theme.now, lineWidth: 1.5 });
      g.beginPath();
      g.moveTo(x, 0);
      g.lineTo(x, height);
      g.stroke();
    }
  }

  drawStill(g, [width, height, ratio]) {
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.inRows(g, [width, height], (row) => this.drawRow(g, row, width));
    this.drawRuler(g, width, height);
  }

  /** Does something for each row that is in sight, clipped to the place of the rows. */
  inRows(g, [width, height], act) {
    g.save();
    g.beginPath();
    g.rect(0, RULER, width, height - RULER);
    g.clip();
    g.translate(0, -this.scroll);
    for (const row of this.rows) {
      if (row.y + row.height >= this.scroll + RULER && row.y <= this.scroll + height) act(row);
    }
    g.restore();
  }

  drawRuler(g, width, height) {
    const { theme } = this;
    Object.assign(g, { font: "11px system-ui, sans-serif", textBaseline: "middle", textAlign: "center", lineWidth: 1 });
    const tick = tickOf(this.to_ns - this.from_ns, Math.max(2, this.width() / 110));
    for (let t = Math.ceil(this.from_ns / tick) * tick; t <= this.to_ns; t += tick) {
      const x = this.xOf(t);
      g.strokeStyle = theme.rule;
      g.beginPath();
      g.moveTo(x, RULER - 4);
      g.lineTo(x, height);
      g.stroke();
      g.fillStyle = theme.soft;
      if (x < width - 24) g.fillText(timeText(Math.round(t)), x, RULER / 2 - 1);
    }
  }

  drawRow(g, row, width) {
    const { theme } = this;
    Object.assign(g, { font: `${Math.min(11, Math.max(8, row.height))}px system-ui, sans-serif`, textBaseline: "middle", textAlign: "right" });
    if (row.height >= 9 || row === this.rowAt(this.hover ? this.hover[1] : -1)) {
      g.fillStyle = theme.soft;
      g.fillText(row.label, LABELS - 8, row.y + row.height / 2);
    }
    g.save();
    g.beginPath();
    g.rect(LABELS, row.y - 1, width - LABELS, row.height + 2);
    g.clip();
    if (row.kind === "steps") this.drawSteps(g, row, () => true, theme.block);
    if (row.kind === "operations") this.drawOperations(g, row);
    if (row.kind === "channel") this.drawChannel(g, row);
    if (row.kind === "ladder") this.drawLadder(g, row);
    g.restore();
  }

  /** The steps of a row that are wanted, as blocks with their text. */
  drawSteps(g, row, isWanted, color) {
    const { theme } = this;
    for (const step of row.steps.filter(isWanted)) {
      const [x0, x1] = [Math.max(LABELS, this.xOf(step.start_ns)), this.xOf(step.start_ns + step.duration_ns)];
      if (x1 < LABELS || x0 > LABELS + this.width()) continue;
      g.fillStyle = color;
      g.fillRect(x0 + 0.5, row.y, Math.max(1, x1 - x0 - 1), row.height);
      if (x1 - x0 < 24) continue;
      g.save();
      g.beginPath();
      g.rect(x0, row.y, x1 - x0 - 4, row.height);
      g.clip();
      Object.assign(g, { fillStyle: theme.ink, textAlign: "left", textBaseline: "middle", font: "11px ui-monospace, monospace" });
      g.fillText(step.text, x0 + 6, row.y + row.height / 2 + 0.5);
      g.restore();
    }
  }

  /** The operations of a part: a line while it is on its way, a block while it stays. */
  drawOperations(g, row) {
    const { theme } = this;
    for (const { start_ns, way_ns, arrival_ns, duration_ns, text } of row.steps) {
      const [x0, x1, x2] = [way_ns, arrival_ns, start_ns + duration_ns].map((t_ns) => this.xOf(t_ns));
      if (x2 < LABELS || x0 > LABELS + this.width()) continue;
      g.fillStyle = row.color;
      g.fillRect(x0, row.y + row.height / 2 - 1, Math.max(1, x1 - x0), 2);
      g.globalAlpha = 0.35;
      g.fillRect(x1 + 0.5, row.y, Math.max(0, x2 - x1 - 1), row.height);
      g.globalAlpha = 1;
      // Where it arrives: so two stays without a way between them are told apart.
      g.fillRect(x1 - 1, row.y + 1, 2, row.height - 2);
      const left = Math.max(LABELS, x1);
      if (x2 - left < 24) continue;
      g.save();
      g.beginPath();
      g.rect(left, row.y, x2 - left - 4, row.height);
      g.clip();
      Object.assign(g, { fillStyle: theme.ink, textAlign: "left", textBaseline: "middle", font: "10px ui-monospace, monospace" });
      g.fillText(text, left + 6, row.y + row.height / 2 + 0.5);
      g.restore();
    }
  }

  drawChannel(g, row) {
    const { theme } = this;
    const { channel, range: [low, high] } = row;
    const yOf = (value) => row.y + row.height - 1.5 - ((value - low) / (high - low || 1)) * (row.height - 3);
    const color = channel.unit === "um" ? colorOf(Number((/f(\d+)\./.exec(channel.name) || [0, 1])[1]) - 1) : theme.wave;
    Object.assign(g, { strokeStyle: color, fillStyle: color, lineWidth: 1.25 });
    // Voltages stand on 0 V, at rest too.
    const [base, rest_v] = [yOf(0), channel.rest_v || 0];
    const level = (x0, x1, value) => g.fillRect(x0, Math.min(yOf(value), base), Math.max(1, x1 - x0), Math.abs(base - yOf(value)) || 1);
    if (channel.unit === "V") {
      g.globalAlpha = 0.25;
      g.fillRect(LABELS, base, this.width(), 0.75);
      g.globalAlpha = 1;
    }
    const { actuations } = channel;
    const first = Math.max(0, lastAtMost(actuations, "start_ns", this.from_ns));
    let drawn = -Infinity;
    let since = first ? this.xOf(actuations[first].start_ns) : this.xOf(0);
    g.beginPath();
    for (let at = first; at < actuations.length; at += 1) {
      const { start_ns, duration_ns, from, to } = actuations[at];
      if (start_ns > this.to_ns) break;
      const [x0, x1] = [this.xOf(start_ns), this.xOf(start_ns + duration_ns)];
      if (channel.unit === "V") {
        if (rest_v && x0 > since) level(since, x0, rest_v);
        since = Math.max(since, x1);
        // Pulses closer than a pixel are one block.
        if (x1 - drawn >= 0.5) level(x0, x1, from);
        drawn = Math.max(drawn, x1);
      } else {
        g.moveTo(Math.max(x0, LABELS - 10), yOf(from));
        g.lineTo(x1, yOf(to));
        const next = actuations[at + 1];
        g.lineTo(next ? this.xOf(next.start_ns) : this.xOf(this.model.duration_ns), yOf(to));
      }
    }
    if (channel.unit === "um") g.stroke();
    const end = this.xOf(this.model.duration_ns);
    if (rest_v && end > since) level(since, end, rest_v);
  }

  /** The drive voltage against each robot's release and snap-down voltage, with the margin as a band. */
  drawLadder(g, row) {
    const { theme } = this;
    const { facts } = row.device.runs[0].order;
    const yOf = (value) => row.y + row.height - 2 - (value / facts.max_v) * (row.height - 4);
    facts.robots.forEach((robot, number) => {
      for (const [level, dash] of [[robot.release_v, [2, 3]], [robot.snap_down_v, []]]) {
        g.fillStyle = colorOf(number);
        g.globalAlpha = 0.14;
        g.fillRect(LABELS, yOf(level + facts.margin_v), this.width(), yOf(level - facts.margin_v) - yOf(level + facts.margin_v));
        g.globalAlpha = 0.8;
        Object.assign(g, { strokeStyle: colorOf(number), lineWidth: 1 });
        g.setLineDash(dash);
        g.beginPath();
        g.moveTo(LABELS, yOf(level));
        g.lineTo(LABELS + this.width(), yOf(level));
        g.stroke();
        g.setLineDash([]);
        g.globalAlpha = 1;
      }
    });
    const [channel] = row.device.channels;
    for (let at = Math.max(0, lastAtMost(channel.actuations, "start_ns", this.from_ns)); at < channel.actuations.length; at += 1) {
      const { start_ns, duration_ns, from, to, swing } = channel.actuations[at];
      if (start_ns > this.to_ns) break;
      const [x0, x1] = [this.xOf(start_ns), this.xOf(start_ns + duration_ns)];
      const levels = swing ? swing.levels : [from, to];
      const [high, low] = [yOf(Math.max(...levels)), yOf(Math.min(...levels))];
      g.fillStyle = theme.wave;
      g.globalAlpha = swing ? 0.45 : 1;
      g.fillRect(x0, high, Math.max(1, x1 - x0), Math.max(1.5, low - high));
      g.globalAlpha = 1;
    }
    Object.assign(g, { textAlign: "left", font: "9px system-ui, sans-serif" });
    facts.robots.forEach((robot, number) => {
      g.fillStyle = colorOf(number);
      g.fillText(`${robot.name}: down at ${short(robot.snap_down_v)}, up at ${short(robot.release_v)}`, LABELS + 6 + 130 * (number % 6), yOf(facts.max_v) + 5);
    });
  }
}
