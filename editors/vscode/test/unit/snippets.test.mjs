// Snippets, filled in with the defaults of their placeholders, are correct programs.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import test from "node:test";
import { fileURLToPath } from "node:url";
import { scopesOf } from "./grammar.mjs";

const snippets = JSON.parse(readFileSync(new URL("../../snippets/tweeze.json", import.meta.url), "utf8"));
const executable = process.env.TWEEZE;

/** The text of a snippet with each placeholder replaced by its default, or by the first word of a choice. */
function filled(body) {
  const defaults = new Map([["0", ""]]);
  const placeholder = /\$(?:(\d+)|\{(\d+)(?::([^}]*)|\|([^,|]*)[^|]*\|)?\})/gu;
  return body.join("\n").replace(placeholder, (_, plain, number = plain, text, choice) => {
    const own = text ?? choice;
    if (own !== undefined) {
      assert.ok(!defaults.has(number), `placeholder ${number} has two defaults`);
      defaults.set(number, own);
    }
    assert.ok(defaults.has(number), `placeholder ${number} has no default, or a later one`);
    return defaults.get(number);
  });
}

// The text around a fragment, by the snippet's name.
const BOT = "use std.dimibot\ndevice bot : dimibot.femto_st { left: 5, right: 5 }\n";
const EA = "use std.electrode_array as ea\n";
const CHIP = `${EA}device chip : ea.droplet_chip { }\n`;
const PLATE = `${EA}device plate : ea.smart_platform { columns: 20, rows: 20 }\n`;
const BED = 'use std.microrobots\ndevice fleet : microrobots.bed\nscene field { robot D1 at pose(0 mm, 0 mm, 90 deg), robot D2 at pose(2 mm, 0 mm, 90 deg) }\n';
const HAND = "use std.fingers as f\ndevice hand : f.three_fingers\n";
const GO = "\ntask go on bot { move to (1, 1) }\n";
const inBench = (object) => `${BOT}scene bench {\n${object}\n}\ntask go on bot in bench { move to (1, 1) }\n`;
const inTask = (step) => `${BOT}output camera : trigger { duration: 5 ms }\noutput light : digital\ntask go on bot {\n${step}\nmove to (1, 1)\npulse camera\nset light to low\n}\n`;
const HOSTS = {
  "Use the standard library": (text) => `${text}\ndevice bot : dimibot.femto_st${GO}`,
  // The program is checked in the folder of the examples, which has such a file.
  "Use a file": (text) => `${text}\ntask go on lab.picker { move to (1, 1) }\n`,
  Value: (text) => `${text}\n${BOT}task go on bot { move to (pitch / 100, pitch / 100) }\n`,
  "Device: DiMiBot": (text) => `use std.dimibot\n${text}${GO}`,
  "Device: electrode array": (text) => `${EA}${text}\ntask go on plate { wait 1 s }\n`,
  "Device: droplet chip": (text) => `${EA}${text}\ntask go on chip { wait 1 s }\n`,
  "Device: microrobots": (text) => `use std.microrobots\n${text}\ntask go on fleet { wait 1 s }\n`,
  "Device: fingers": (text) => `use std.fingers as f\n${text}\nscene cell { part bead : ellipsoid { axes: (16 um, 12 um, 12 um) } }\ntask go on hand in cell { rotate bead by 40 deg about z }\n`,
  Instrument: (text) => `use std.instruments\n${BOT}${text}\nwiring bot {\nswitches: 20 V\nbl[0].set -> card.port0.line0\n}${GO}`,
  "Output: trigger": (text) => `${BOT}${text}\ntask go on bot { pulse camera }\n`,
  "Output: digital": (text) => `${BOT}${text}\ntask go on bot { set light to high }\n`,
  Scene: (text) => `${BOT}${text}\ntask go on bot in bench { move to (1, 1) }\n`,
  "Obstacle: disc": inBench,
  "Obstacle: box": inBench,
  "Obstacle: polygon": inBench,
  "Obstacle: capsule": inBench,
  "Obstacle: cells": inBench,
  "Frame of a device": inBench,
  "Frame of an image": inBench,
  "Part: micropart": (text) => `${PLATE}scene tray { ${text} }\ntask go on plate in tray { move m1 to (9, 9) }\n`,
  "Part: droplet": (text) => `${CHIP}scene assay { ${text} }\ntask go on chip in assay { move sample to (9, 9) }\n`,
  "Part: ellipsoid": (text) => `${HAND}scene cell { ${text} }\ntask go on hand in cell { rotate bead by 40 deg about z }\n`,
  Reservoir: (text) => `${CHIP}scene assay { ${text}, part a : ea.droplet }\ntask go on chip in assay { dispense a from bottle }\n`,
  Robot: (text) => `use std.microrobots\ndevice fleet : microrobots.bed\nscene field { ${text} }\ntask go on fleet in field { drive D1 to pose(2 mm, 4 mm, 45 deg) }\n`,
  "Task: DiMiBot": (text) => `${BOT}scene bench { obstacle o at (9, 9) }\n${text}\n`,
  "Task with parameters": (text) => `${BOT}scene bench { obstacle o at (9, 9) }\n${text}\nprogram p { run go((1, 1)) }\n`,
  "Task: electrode array": (text) => `${PLATE}scene tray { part m1 : ea.micropart at (5, 3) }\n${text}\n`,
  "Task: assay": (text) => `${CHIP}scene assay { part sample : ea.droplet at (1, 2), part reagent : ea.droplet at (1, 11) }\n${text}\n`,
  "Task: drive microrobots": (text) => `${BED}${text}\n`,
  "Task: assemble microrobots": (text) => `${BED}${text}\n`,
  "Task: fingers": (text) => `${HAND}scene cell { part bead : ellipsoid { axes: (16 um, 12 um, 12 um) } }\n${text}\n`,
  Program: (text) => `${BOT}task fetch on bot { move to (1, 1) }\n${text}\n`,
  "Together: runs": (text) => `${BOT}device twin : bot { }\ntask fetch on bot { move to (1, 1) }\ntask bring on twin { move to (1, 1) }\nprogram p {\n${text}\n}\n`,
  Loop: (text) => `${BOT}task go on bot {\n${text.replace("{\n  ", "{\n  move to (i, i)")}\n}\n`,
  "Wiring: digital lines": (text) => `use std.instruments\n${BOT}instrument card : instruments.ni_usb_6343\n${text}${GO}`,
  "Wiring: waveform generator": (text) => `use std.instruments\n${BED}instrument awg : instruments.keysight_33500b\n${text}\ntask go on fleet in field { wait 1 s }\n`,
  "Wiring: electrode driver": (text) => `use std.instruments\n${EA}device chip : ea.opendrop_v4\ninstrument driver : instruments.opendrop_v4\n${text}\ntask go on chip { wait 1 s }\n`,
  "Wiring: output": (text) => `use std.instruments\n${BOT}instrument card : instruments.ni_usb_6343\noutput camera : trigger { duration: 5 ms }\n${text}\ntask go on bot { pulse camera }\n`,
  Limit: inTask,
  Pulse: (text) => inTask(`${text}\nwait 10 ms`),
  Level: inTask,
  Share: (text) => `${BOT}output heater : level { to: 10 V }\ntask go on bot {\n${text}\nmove to (1, 1)\n}\n`,
  Prompt: inTask,
  Input: (text) => `use std.instruments\n${BOT}instrument card : instruments.ni_usb_6343\ntask go on bot {\n${text}\nmove to (1, 1)\n}\n`,
};

const isProgram = (snippet) => snippet.isFileTemplate === true;
const all = Object.entries(snippets).map(([title, snippet]) => ({ title, snippet, text: filled(snippet.body) }));

test("each fragment has a place where it is checked, and each has a prefix of its own", () => {
  const fragments = all.filter(({ snippet }) => !isProgram(snippet)).map(({ title }) => title);
  assert.deepEqual(fragments.sort(), Object.keys(HOSTS).sort());
  const prefixes = all.map(({ snippet }) => snippet.prefix);
  assert.deepEqual(prefixes.filter((prefix, at) => prefixes.indexOf(prefix) !== at), []);
  assert.ok(all.every(({ snippet }) => snippet.description.length > 0));
});

test("each snippet leaves no bracket open, and no mark of a placeholder", () => {
  for (const { title, text } of all) {
    assert.ok(!/[$|]\{|\$\d|\}\}/u.test(text), title);
    const [first, last] = [scopesOf("")[0], scopesOf(text).at(-1)];
    assert.equal(last.depth, first.depth, title);
  }
});

const skip = executable ? false : "TWEEZE names no executable";
const examples = fileURLToPath(new URL("../../../../examples/", import.meta.url));

for (const { title, snippet, text } of all) {
  const program = isProgram(snippet) ? text : HOSTS[title]?.(text);
  test(`tweeze check accepts the snippet "${title}"`, { skip }, () => {
    const { status, stderr } = spawnSync(executable, ["check", "--format", "short", "-"], { input: program, cwd: examples, encoding: "utf8" });
    assert.equal(status, 0, `${stderr}\n${program}`);
  });
  if (!isProgram(snippet)) continue;
  test(`tweeze builds the snippet "${title}", without a warning`, { skip }, () => {
    const output = mkdtempSync(path.join(tmpdir(), "tweeze-snippet-"));
    try {
      const options = ["--format", "short", "--output", output, "-"];
      const { status, stderr } = spawnSync(executable, ["build", ...options], { input: program, encoding: "utf8" });
      assert.deepEqual({ status, stderr }, { status: 0, stderr: "" }, program);
    } finally {
      rmSync(output, { recursive: true });
    }
  });
}

if (!executable) console.log("SKIPPED: snippets are not checked, since the environment variable TWEEZE names no executable");
