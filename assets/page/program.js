// The program's text: highlighted, with the lines at work lit.
"use strict";

const WORDS = new Set(("use let device instrument output scene task program wiring table for in on as to from by about after at among via with within true false " +
  "obstacle part reservoir heater detector magnet robot frame state any minimize require avoid wash using start run wait prompt pulse set together assay move visit merge split mix discard dispense incubate heat detect hold " +
  "apply assemble drive grasp orient release rotate translate simultaneous precision").split(" "));

/** Pieces of a line: [class, text] each; names of the scene get their own class. */
function piecesOf(line, names) {
  const pieces = [];
  const token = /(\/\/.*$)|("(?:[^"\\]|\\.)*")|(0b[01_]+|\d[\d_]*(?:\.\d+)?(?:e[+-]?\d+)?)|([A-Za-z_µ%][\w]*)|(\s+)|(.)/gu;
  for (const [text, comment, string, number, word] of line.matchAll(token)) {
    if (comment) pieces.push(["comment", text]);
    else if (string) pieces.push(["string", text]);
    else if (number) pieces.push(["number", text]);
    else if (word && names.has(word)) pieces.push(["thing", text]);
    else if (word && WORDS.has(word)) pieces.push(["word", text]);
    else pieces.push(["", text]);
  }
  return pieces;
}

/** The lines of a step: from its first to the one that closes its brackets. */
function linesOfStep(lines, { line, column }) {
  let depth = 0;
  for (let at = line - 1; at < lines.length; at += 1) {
    const text = (at === line - 1 ? lines[at].slice(column - 1) : lines[at]).replace(/\/\/.*$/, "");
    for (const letter of text) depth += "{([".includes(letter) ? 1 : "})]".includes(letter) ? -1 : 0;
    if (depth <= 0) return [line, at + 1];
  }
  return [line, line];
}

/** Underlines the characters of a row from one column to another, counted from 0. */
function underline(row, from, to, kind) {
  let at = 0;
  for (const piece of [...row.children].filter((child) => !child.classList.contains("note"))) {
    const letters = [...piece.textContent];
    const [start, end] = [Math.max(0, from - at), Math.min(letters.length, to - at)];
    at += letters.length;
    if (start >= end) continue;
    // What is underlined already stays one piece, and is underlined whole.
    if (start === 0 && end === letters.length || piece.children.length) {
      piece.classList.add("fault", kind);
      continue;
    }
    piece.replaceChildren(letters.slice(0, start).join(""));
    add(piece, "span", letters.slice(start, end).join(""), `fault ${kind}`);
    piece.append(letters.slice(end).join(""));
  }
}

class Program {
  constructor(root, model, { seek, light }) {
    Object.assign(this, { root, model, seek, shown: null });
    const names = new Set(viewsOf(model).flatMap((view) => view.things()));
    const tabs = root.querySelector(".tabs");
    this.files = model.page.sources.map((source) => this.file(source, names, light));
    this.files.forEach((file) => {
      const tab = document.createElement("button");
      Object.assign(tab, { type: "button", textContent: file.name });
      tab.addEventListener("click", () => this.show(file));
      tabs.append(tab);
      file.tab = tab;
      root.append(file.code);
    });
    tabs.hidden = this.files.length < 2;
    this.show(this.files[0]);
    this.addFaults();
  }

  /** Marks the lines that findings point to, each with what is said there. */
  addFaults() {
    const findings = this.model.failure ? this.model.failure.findings : [];
    for (const { severity, title, labels } of findings) {
      labels.forEach((label, nth) => {
        const file = this.files.find(({ name }) => name === label.file);
        if (!file) return;
        const row = file.rows[label.line - 1];
        const kind = nth === 0 ? severity : "related";
        row.classList.add(kind);
        if (label.end_line === label.line) underline(row, label.column - 1, label.end_column - 1, kind);
        const words = label.text || title;
        if (![...row.querySelectorAll(".note")].some(({ textContent }) => textContent === words)) add(row, "span", words, `note ${kind}`);
      });
    }
  }

  /** Shows the first line that is at fault. */
  revealFirstFault() {
    const first = this.model.failure && this.model.failure.findings.flatMap(({ labels }) => labels.slice(0, 1))[0];
    if (first) this.reveal(first);
  }

  /** Shows the line of a finding. */
  reveal({ file: name, line }) {
    const file = this.files.find((known) => known.name === name);
    if (!file) return;
    this.show(file);
    file.rows[line - 1].scrollIntoView({ block: "center" });
  }

  file({ name, text }, names, light) {
    const code = document.createElement("ol");
    code.className = "code";
    const lines = text.replace(/\n$/, "").split(/\r\n|\r|\n/);
    const works = this.model.works.filter((work) => work.file === name);
    const rows = lines.map((line) => {
      const row = document.createElement("li");
      for (const [kind, part] of piecesOf(line, names)) {
        const piece = document.createElement("span");
        piece.textContent = part;
        if (kind) piece.className = kind;
        if (kind === "thing") {
          piece.dataset.thing = part;
          piece.addEventListener("pointerenter", () => light(part));
          piece.addEventListener("pointerleave", () => light(null));
        }
        row.append(piece);
      }
      code.append(row);
      return row;
    });
    const blocks = [];
    for (const work of works) {
      const [from, to] = linesOfStep(lines, work);
      blocks.push({ work, from, to });
      for (let line = from; line <= to; line += 1) {
        const row = rows[line - 1];
        row.classList.add("step");
        row.tabIndex = line === from ? 0 : -1;
        row.title = `jump to ${timeText(work.start_ns)}`;
        const jump = () => {
          // A line that runs several times: from one run to the next.
          const all = blocks.filter((block) => line >= block.from && line <= block.to).map((block) => block.work.start_ns);
          const later = all.filter((start_ns) => start_ns > this.t_ns);
          this.seek(Math.min(...(later.length ? later : all)));
        };
        row.onclick = jump;
        row.onkeydown = (event) => { if (event.key === "Enter") jump(); };
      }
    }
    return { name, code, rows, blocks };
  }

  show(file) {
    for (const other of this.files) {
      other.code.hidden = other !== file;
      other.tab.classList.toggle("chosen", other === file);
    }
    this.shown = file;
  }

  /** Lights the lines at work, and ticks those that are over. */
  draw(t_ns) {
    this.t_ns = t_ns;
    const atWork = new Set(worksAt(this.model, t_ns));
    const over = this.model.works.filter((work) => work.start_ns + work.duration_ns <= t_ns);
    const key = [...atWork, "over", over.length].join();
    if (key === this.key) return;
    this.key = key;
    for (const file of this.files) {
      const kinds = file.rows.map(() => new Set());
      for (const { work, from, to } of file.blocks) {
        const kind = atWork.has(work.index) ? "now" : work.start_ns + work.duration_ns <= t_ns ? "done" : "due";
        for (let line = from; line <= to; line += 1) kinds[line - 1].add(kind);
      }
      file.rows.forEach((row, at) => {
        row.classList.toggle("now", kinds[at].has("now"));
        row.classList.toggle("done", kinds[at].has("done") && kinds[at].size === 1);
      });
      const first = kinds.findIndex((kind) => kind.has("now"));
      if (first >= 0 && file === this.shown) file.rows[first].scrollIntoView({ block: "nearest" });
    }
  }

  light(thing) {
    this.root.querySelectorAll(".thing").forEach((piece) => piece.classList.toggle("lit", piece.dataset.thing === thing));
  }
}
