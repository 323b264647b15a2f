// Puts the page together: one clock for program, scenes, timeline and claims.
"use strict";

/** Colours of the canvases, from the style sheet, so that light and dark stay in one place. */
function themeOf() {
  const style = getComputedStyle(document.documentElement);
  const names = ["paper", "panel", "ink", "soft", "faint", "rule", "dots", "obstacle", "grown", "heater", "detector", "magnet", "lit", "stop", "ahead", "board", "electrode", "live", "liveEdge", "section", "alarm", "reached", "reachedEdge", "ruler", "now", "block", "blockNow", "wave"];
  return Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
}

/** The speeds that are offered: real time, and slower or faster by powers of ten, halves and fifths. */
const SPEEDS = [-4, -3, -2, -1, 0, 1, 2, 3].flatMap((power) => [1, 2, 5].map((factor) => factor * 10 ** power));

/** Seconds that a whole schedule takes at the speed that is chosen first. */
const SHOW_S = 12;

class Player {
  constructor(page) {
    this.model = buildModel(page);
    this.t_ns = 0;
    this.isPlaying = false;
    const dark = window.matchMedia("(prefers-color-scheme: dark)");
    document.documentElement.dataset.theme = dark.matches ? "dark" : "light";
    dark.addEventListener("change", () => this.retheme(dark.matches));
    this.theme = themeOf();
    this.views = viewsOf(this.model);
    this.views.forEach((view) => placeFaults(view, this.model.failure ? this.model.failure.places : []));
    const find = (id) => document.getElementById(id);
    Object.assign(this, { play: find("play"), clock: find("clock"), slider: find("slider"), speeds: find("speed"), stage: find("stage") });
    const seek = (t_ns) => this.seek(t_ns);
    const light = (thing) => this.light(thing);
    this.program = new Program(find("program"), this.model, { seek, light });
    const { failure } = this.model;
    if (failure) drawFailure(find("claims"), this.model, { reveal: (label) => this.program.reveal(label), seek });
    // What was refused claims nothing.
    if (!failure || !failure.is_refused) {
      const root = find("claims");
      drawClaims(root, this.model, seek);
      drawClearances(root, this.model, (found) => this.measure(found));
      drawRules(root, this.model);
      if (page.schedule) drawAbout(root, this.model);
    }
    this.timeline = new Timeline(find("timeline"), this.model, this.theme, seek);
    this.timeline.onChange = () => this.draw();
    this.addStage();
    this.addControls();
    document.body.classList.toggle("still", Boolean(this.model.failure) && this.model.duration_ns === 0);
    const name = page.schedule ? page.schedule.name : page.sources[0].name;
    document.title = `${name} – Tweeze`;
    find("name").textContent = name;
    if (failure) showRefusal(find("verdict"), this.model);
    find("facts").textContent = this.model.devices.map((device) => `${device.name}: ${device.kind.replaceAll("_", " ")}`).join(", ");
    if (failure && failure.is_refused) this.seek(failure.findings[0].t_ns, false);
    this.readLink();
    window.addEventListener("hashchange", () => this.readLink());
    window.addEventListener("resize", () => this.draw());
    this.draw();
    this.program.revealFirstFault();
  }

  addStage() {
    this.views.forEach((view) => {
      const figure = document.createElement("figure");
      const canvas = document.createElement("canvas");
      canvas.setAttribute("role", "img");
      canvas.setAttribute("aria-label", `scene of ${view.title}`);
      figure.append(canvas);
      this.stage.append(figure);
      Object.assign(view, { canvas, figure });
      canvas.addEventListener("pointermove", (event) => {
        if (view.turnable && event.buttons) {
          view.yaw += event.movementX / 150;
          view.pitch = Math.max(-1.5, Math.min(1.5, view.pitch + event.movementY / 150));
          this.draw();
        } else if (view.pen) {
          this.light(view.hit(view.pen.under([event.offsetX, event.offsetY]), this.t_ns));
        }
      });
      canvas.addEventListener("pointerleave", () => this.light(null));
    });
    this.stage.dataset.count = Math.min(4, this.views.length);
    if (this.views.length === 0) add(this.stage, "p", "There is no scene to show: no part of the program could be built.", "empty");
  }

  addControls() {
    const { duration_ns } = this.model;
    for (const speed of SPEEDS) {
      const option = document.createElement("option");
      Object.assign(option, { value: speed, textContent: speed >= 1 ? `${speed} ×` : `1/${Math.round(1 / speed)} ×` });
      this.speeds.append(option);
    }
    const wanted = duration_ns / 1e9 / SHOW_S;
    this.speeds.value = SPEEDS.reduce((best, speed) => (Math.abs(Math.log(speed / wanted)) < Math.abs(Math.log(best / wanted)) ? speed : best));
    this.slider.max = duration_ns;
    this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
    this.play.addEventListener("click", () => this.toggle());
    document.getElementById("back").addEventListener("click", () => this.toEvent(-1));
    document.getElementById("forth").addEventListener("click", () => this.toEvent(1));
    document.getElementById("theme").addEventListener("click", () => {
      this.retheme(document.documentElement.dataset.theme === "light");
    });
    document.addEventListener("keydown", (event) => this.key(event));
  }

  key(event) {
    if (event.target instanceof HTMLSelectElement || event.ctrlKey || event.metaKey || event.altKey) return;
    const { duration_ns } = this.model;
    const isOnButton = event.target instanceof HTMLButtonElement && event.key === " ";
    const acts = {
      " ": () => this.toggle(),
      ArrowLeft: () => (event.shiftKey ? this.seek(this.t_ns - duration_ns / 100) : this.toEvent(-1)),
      ArrowRight: () => (event.shiftKey ? this.seek(this.t_ns + duration_ns / 100) : this.toEvent(1)),
      Home: () => this.seek(0),
      End: () => this.seek(duration_ns),
      "+": () => { this.timeline.zoom(0.5, this.t_ns); this.draw(); },
      "-": () => { this.timeline.zoom(2, this.t_ns); this.draw(); },
      "0": () => { this.timeline.zoom(Infinity, this.t_ns); this.draw(); },
    };
    if (!acts[event.key] || isOnButton) return;
    event.preventDefault();
    acts[event.key]();
  }

  retheme(isDark) {
    document.documentElement.dataset.theme = isDark ? "dark" : "light";
    this.theme = themeOf();
    this.timeline.theme = this.theme;
    this.draw();
  }

  /** A link names an instant in seconds: `#t=0.105`. */
  readLink() {
    const link = /^#t=([\d.]+)$/.exec(window.location.hash);
    if (link) this.seek(Math.round(Number(link[1]) * 1e9), false);
  }

  seek(t_ns, isLinked = true) {
    this.t_ns = Math.round(Math.min(this.model.duration_ns, Math.max(0, t_ns)));
    this.timeline.follow(this.t_ns);
    if (isLinked && !this.isPlaying) this.link();
    this.draw();
  }

  /** Jumps to the instant of a clearance; its ruler is drawn until the time goes on. */
  measure(clearance) {
    this.ruler = clearance;
    const [from, to] = clearance.points;
    for (const view of this.views) {
      if (view.face && view.devices.some(({ name }) => name === clearance.device)) view.face(to.map((value, axis) => value - from[axis]));
    }
    this.seek(clearance.t_ns);
  }

  link() {
    window.history.replaceState(null, "", `#t=${this.t_ns / 1e9}`);
  }

  toEvent(direction) {
    const { events } = this.model;
    const next = direction > 0 ? events.find((t_ns) => t_ns > this.t_ns) : events.findLast((t_ns) => t_ns < this.t_ns);
    if (next !== undefined) this.seek(next);
  }

  toggle() {
    this.isPlaying = !this.isPlaying;
    if (this.isPlaying) {
      if (this.t_ns >= this.model.duration_ns) this.t_ns = 0;
      this.last_ms = performance.now();
      requestAnimationFrame((now_ms) => this.tick(now_ms));
    } else {
      this.link();
    }
    this.draw();
  }

  tick(now_ms) {
    if (!this.isPlaying) return;
    this.t_ns += Math.max(0, now_ms - this.last_ms) * 1e6 * Number(this.speeds.value);
    this.last_ms = now_ms;
    if (this.t_ns >= this.model.duration_ns) {
      this.t_ns = this.model.duration_ns;
      this.toggle();
      return;
    }
    this.timeline.follow(this.t_ns);
    this.draw();
    requestAnimationFrame((later_ms) => this.tick(later_ms));
  }

  light(thing) {
    if (thing === this.lit) return;
    this.lit = thing;
    this.program.light(thing);
    this.draw();
  }

  draw() {
    const { t_ns } = this;
    this.play.textContent = this.isPlaying ? "Pause" : "Play";
    this.clock.textContent = `${timeText(Math.round(t_ns))} of ${timeText(this.model.duration_ns)}`;
    this.slider.value = t_ns;
    this.slider.setAttribute("aria-valuetext", this.clock.textContent);
    this.views.forEach((view) => this.drawView(view, Math.round(t_ns)));
    this.program.draw(t_ns);
    this.timeline.draw(t_ns);
  }

  drawView(view, t_ns) {
    const { canvas } = view;
    const [width, height, ratio] = [canvas.clientWidth, canvas.clientHeight, window.devicePixelRatio || 1];
    if (!width || !height) return;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const g = canvas.getContext("2d");
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, width, height);
    const foot = 30 + (view.foot || 0);
    view.pen = new Pen(canvas, { x: 8, y: 26, width: width - 16, height: height - 34 - foot }, view.extent, this.theme);
    const lights = { hovered: this.lit, blamed: this.model.blamed };
    view.draw(view.pen, t_ns, lights);
    drawFaults(view.pen, view.faults);
    const { ruler } = this;
    view.ruled = null;
    if (ruler && ruler.t_ns === t_ns && view.devices.some(({ name }) => name === ruler.device)) {
      drawRuler(view.pen, view, ruler, (loupe) => view.draw(loupe, t_ns, lights));
    }
    this.drawFrame(view, width, height);
    if (view.legend) this.drawLegend(view, width, height);
  }

  /** What the colours of a view mean, as far as there is room beside the scale bar. */
  drawLegend(view, width, height) {
    const { g } = view.pen;
    const [head, entries] = view.legend;
    Object.assign(g, { font: "11px system-ui, sans-serif", textAlign: "left", textBaseline: "middle", fillStyle: this.theme.soft });
    const y = height - 15;
    let x = 10;
    g.fillText(head, x, y);
    x += g.measureText(head).width + 8;
    for (const [at, [words, color]] of entries.entries()) {
      const last = at === entries.length - 1 ? 0 : 20;
      if (x + 16 + g.measureText(words).width + last > 0.62 * width) {
        g.fillStyle = this.theme.soft;
        g.fillText("…", x, y);
        return;
      }
      Object.assign(g, { fillStyle: color, strokeStyle: this.theme.faint, lineWidth: 1 });
      g.fillRect(x, y - 5, 10, 10);
      g.strokeRect(x, y - 5, 10, 10);
      g.fillStyle = this.theme.ink;
      g.fillText(words, x + 14, y);
      x += 14 + g.measureText(words).width + 10;
    }
  }

  /** The title of a view, and its scale bar. */
  drawFrame(view, width, height) {
    const { g, scale } = view.pen;
    Object.assign(g, { font: "600 13px system-ui, sans-serif", textAlign: "left", textBaseline: "top", fillStyle: this.theme.ink });
    g.fillText(view.title, 10, 7);
    const most_um = ((width / 4) * view.unit_um) / scale;
    const power = 10 ** Math.floor(Math.log10(most_um));
    const bar_um = [5, 2, 1].map((factor) => factor * power).find((length) => length <= most_um);
    const length = (bar_um / view.unit_um) * scale;
    const [x, y] = [width - 14 - length, height - 12];
    Object.assign(g, { strokeStyle: this.theme.ink, lineWidth: 2 });
    g.beginPath();
    g.moveTo(x, y - 4);
    g.lineTo(x, y);
    g.lineTo(x + length, y);
    g.lineTo(x + length, y - 4);
    g.stroke();
    Object.assign(g, { font: "11px system-ui, sans-serif", textAlign: "right", textBaseline: "middle" });
    g.fillText(bar_um >= 1000 ? `${short(bar_um / 1000)} mm` : `${short(bar_um)} um`, x - 8, y - 3);
  }
}

window.tweeze = new Player(JSON.parse(document.getElementById("data").textContent));
follow(document.documentElement.dataset);
