// The model that a page builds from a schedule, as functions of time.

import assert from "node:assert/strict";
import test from "node:test";
import { model, plain } from "./script.mjs";

const { buildModel, valueAt, worksAt, lastAtMost, timeText, short, isKept, outcomeText, tipAt, partsAt, turned, moved, frictionCone, tracesAt, forcesAt, reachesOf } = model;

const plan = (kind, more) => ({ task: "go", device: "it", kind, start_ns: 0, states: [], outcomes: {}, ...more });
const page = (schedule, order = {}) => ({
  schedule: { channels: [], actuations: [], steps: [], plans: [], duration_ns: 0, ...schedule },
  claims: { jobs: [{ order, requirements: [] }] },
  sources: [{ name: "go.twz", text: "use std.dimibot\ntask go on it {\n  grüße()\n}\n" }],
});

test("the last entry at most as large is found", () => {
  const list = [0, 10, 10, 20].map((t_ns) => ({ t_ns }));
  assert.deepEqual([-1, 0, 9, 10, 19, 20, 99].map((value) => lastAtMost(list, "t_ns", value)), [-1, 0, 0, 2, 2, 3, 3]);
  assert.equal(lastAtMost([], "t_ns", 5), -1);
});

test("a voltage is zero outside of its actuations, a length is held", () => {
  const actuation = { start_ns: 100, duration_ns: 50, from: 10, to: 20 };
  const volts = { unit: "V", actuations: [actuation] };
  assert.deepEqual([99, 100, 125, 149, 150].map((t_ns) => valueAt(volts, t_ns)), [0, 10, 15, 19.8, 0]);
  const axis = { unit: "um", actuations: [actuation] };
  assert.deepEqual([0, 99, 125, 150, 900].map((t_ns) => valueAt(axis, t_ns)), [10, 10, 15, 20, 20]);
  assert.equal(valueAt({ unit: "um", actuations: [] }, 5), 0);
});

test("a swing takes turns between its levels", () => {
  const swing = { unit: "V", actuations: [{ start_ns: 0, duration_ns: 100, from: 0, to: 0, swing: { period_ns: 20, levels: [5, 40] } }] };
  assert.deepEqual([0, 9, 10, 19, 20, 99].map((t_ns) => valueAt(swing, t_ns)), [5, 5, 40, 40, 5, 40]);
});

test("operations of a step are works of their own, and the last one is at work at the very end", () => {
  const steps = [
    { plan: 0, start_ns: 0, duration_ns: 100 },
    { plan: 0, start_ns: 100, duration_ns: 100, operations: [{ start_ns: 100, duration_ns: 60 }, { start_ns: 140, duration_ns: 60 }] },
  ];
  const built = buildModel(page({ steps, duration_ns: 200 }));
  assert.deepEqual([0, 99, 100, 150, 199, 200].map((t_ns) => plain(worksAt(built, t_ns))), [[0], [0], [1], [1, 2], [2], [2]]);
  assert.deepEqual(plain(built.events), [0, 100, 140, 160, 200]);
});

test("a tip is on its way while a pulse lasts", () => {
  const states = [{ t_ns: 0, position_um: [0, 0] }, { t_ns: 150, position_um: [3, 6] }];
  const order = { dimibot: { facts: { pulse_duration_ns: 100 } } };
  const device = (frame) => buildModel(page({ plans: [plan("dimibot", { states })] }, { dimibot: { ...order.dimibot, frame } })).devices[0];
  const alone = device(null);
  assert.deepEqual([0, 50, 100, 150, 400].map((t_ns) => plain(tipAt(alone, t_ns))), [[0, 0], [0, 0], [1.5, 3], [3, 6], [3, 6]]);
  // In a scene, rotated by a quarter turn.
  const [x, y] = tipAt(device({ x_um: 10, y_um: 20, heading_rad: Math.PI / 2 }), 150);
  assert.ok(Math.hypot(x - 4, y - 23) < 1e-9);
});

test("a part comes to where its plan has chosen, and is gone there", () => {
  const states = [{ t_ns: 0, parts: { a: [1, 1] } }, { t_ns: 10, parts: {} }];
  const cell = (column) => ({ cell: { column, row: 1 } });
  const leave = { part: 0, leaves: true, stops: [cell(0)], among: [{ stop: cell(0) }, { stop: cell(2) }] };
  const order = { facts: { step_ns: 10 }, parts: [{ name: "a" }], steps: [{ action: { assay: [leave] } }] };
  const steps = [{ plan: 0, start_ns: 0, duration_ns: 10, operations: [{ start_ns: 0, duration_ns: 10, at: [2, 1] }] }];
  const device = buildModel(page({ steps, plans: [plan("electrode_array", { states })] }, { electrode_array: order })).devices[0];
  assert.deepEqual(plain(device.runs[0].order.steps[0].action.assay[0].stops), [cell(2)]);
  assert.deepEqual(plain(partsAt(device, 5)), { a: [1.5, 1] });
});

test("a part that is gone comes to where it merges", () => {
  const states = [{ t_ns: 0, parts: { a: [1, 1], b: [3, 1] } }, { t_ns: 10, parts: { a: [2, 1] } }];
  const move = { part: 0, with: 1, stops: [{ cell: { column: 2, row: 1 } }] };
  const order = { facts: { step_ns: 10 }, parts: [{ name: "a" }, { name: "b" }], steps: [{ action: { move: [move] } }] };
  const { devices } = buildModel(page({ plans: [plan("electrode_array", { states })] }, { electrode_array: order }));
  assert.deepEqual(plain(partsAt(devices[0], 5)), { a: [1.5, 1], b: [2.5, 1] });
});

test("droplets leave what they contain where they come, until it is washed away", () => {
  const states = [
    { t_ns: 0, parts: { a: [1, 1], b: [4, 1] } },
    { t_ns: 10, parts: { a: [2, 1], b: [3, 1] } },
    { t_ns: 20, parts: { a: [2, 1] } },
    { t_ns: 30, parts: { a: [2, 2], half: [2, 1], rinse: [1, 1] } },
    { t_ns: 40, parts: { a: [2, 2], half: [2, 1] } },
  ];
  const stop = { cell: { column: 1, row: 2 } };
  const assay = [
    { part: 0, with: 1, stops: [stop] }, { part: 0, splits: { part: 2 }, stops: [stop] },
    { part: 3, comes: true, fluid: "water", stops: [stop] }, { part: 3, leaves: true, stops: [stop] },
  ];
  const parts = ["a", "b", "half", "rinse"].map((name) => ({ name }));
  const order = (electrodes) => ({ electrode_array: { parts, facts: { step_ns: 10, layout: { electrodes } }, contamination: { avoided: [], washes: ["water"] }, steps: [{ action: { assay } }] } });
  const device = (electrodes) => buildModel(page({ plans: [plan("electrode_array", { states })] }, order(electrodes))).devices[0];
  const at = (t_ns) => Object.fromEntries(tracesAt(device("single"), t_ns).map(({ cell, fluids }) => [cell.join(), [...fluids].join()]));
  assert.deepEqual(at(9), { "1,1": "a", "4,1": "b" });
  assert.deepEqual(at(20), { "1,1": "a", "4,1": "b", "2,1": "a,b", "3,1": "b" });
  // A droplet split off another carries all of its fluids; water washes the electrodes that it covers and leaves no trace.
  assert.deepEqual(at(40), { "4,1": "b", "2,1": "a,b", "3,1": "b", "2,2": "a,b" });
  assert.deepEqual(plain(tracesAt(device("quad"), 40)), []);
});

test("forces turn with the part, and go over into those of the next state", () => {
  const half = Math.SQRT1_2;
  const state = (t_ns, orientation) => ({ t_ns, grasp: [1, 1], orientation, position_um: [0, 0, 0] });
  const states = [state(0, [1, 0, 0, 0]), state(100, [half, 0, 0, half])];
  const order = { fingers: { facts: { fingers: 2 } } };
  const channels = [1, 2].flatMap((finger) => ["x", "y", "z"].map((axis) => ({ name: `it.f${finger}.${axis}`, device: "it", unit: "um" })));
  const actuations = [{ channel: 0, start_ns: 0, duration_ns: 100, from: 0, to: 5 }];
  const forces = (second) => [{ plan: 0, states: [[[2, 0, 0], [-2, 0, 0]], second] }];
  const device = (evidence) => buildModel({ ...page({ channels, actuations, plans: [plan("fingers", { states })] }, order), evidence }).devices[0];
  const rounded = (value) => plain(value).map((force) => force && force.map((part) => Math.round(part * 1e9) / 1e9 + 0));
  // A quarter turn about z: a push along y is then a push along the part's own x.
  const both = device({ forces: forces([[0, 4, 0], [0, -4, 0]]) });
  assert.deepEqual([0, 50, 100].map((t_ns) => rounded(forcesAt(both, t_ns))), [2, 3, 4].map((x) => [[x, 0, 0], [-x, 0, 0]]));
  // The force of a finger that lifts off stays constant until then.
  assert.deepEqual(rounded(forcesAt(device({ forces: forces([[0, 4, 0], null]) }), 50)), [[2, 0, 0], [-2, 0, 0]]);
  assert.equal(forcesAt(device({ forces: forces(null) }), 100), null);
  assert.equal(forcesAt(device(undefined), 0), null);
});

test("what a proof has reached has an edge where nothing leads on", () => {
  const reach = { device: "it", what: "a", runs: [[1, 2, 3], [2, 2, 2]] };
  const failure = { findings: [{ reaches: [reach] }, {}, { reaches: [{ ...reach, device: "other" }] }] };
  const [{ runs, edges }, ...others] = plain(reachesOf({ failure }, "it"));
  assert.deepEqual([runs, others], [reach.runs, []]);
  const sorted = edges.map((edge) => edge.map((corner) => corner.join()).sort().join(" ")).sort();
  assert.deepEqual(sorted, ["1.5,0.5 1.5,1.5", "1.5,0.5 2.5,0.5", "1.5,1.5 1.5,2.5", "1.5,2.5 2.5,2.5", "2.5,0.5 3.5,0.5", "2.5,1.5 2.5,2.5", "2.5,1.5 3.5,1.5", "3.5,0.5 3.5,1.5"]);
  assert.deepEqual(plain(reachesOf({}, "it")), []);
  const turn = { device: "it", what: "bead", plane: "xy", reached_deg: 30, asked_deg: 90 };
  assert.deepEqual(plain(reachesOf({ failure: { findings: [{ reaches: [turn] }] } }, "it")), [turn]);
});

test("robots drive straight with the arm up and round with it down", () => {
  const facts = { turning: "clockwise", turning_radius_um: 100 };
  const near = (pose, wanted) => assert.ok(pose.every((value, at) => Math.abs(value - wanted[at]) < 1e-9), `${pose}`);
  near(moved(facts, [0, 0, 0], false, 50), [50, 0, 0]);
  near(moved(facts, [0, 0, 0], true, 50 * Math.PI), [100, -100, -Math.PI / 2]);
  near(moved({ ...facts, turning: "counter_clockwise" }, [0, 0, 0], true, 50 * Math.PI), [100, 100, Math.PI / 2]);
});

test("a unit quaternion turns a vector", () => {
  const half = Math.SQRT1_2;
  const along_y = turned([half, 0, 0, half], [1, 0, 0]);
  assert.ok(along_y.every((value, axis) => Math.abs(value - [0, 1, 0][axis]) < 1e-12));
});

test("a friction cone stands on the contact and opens into the part", () => {
  const square = [[1, 1], [-1, 1], [-1, -1], [1, -1]];
  const near = (points, wanted) => points.flat().forEach((value, at) => assert.ok(Math.abs(value - wanted.flat()[at]) < 1e-9, `${points}`));
  // From the right, with friction coefficient 1: 45 degrees to each side.
  const half = Math.SQRT1_2;
  near(frictionCone(square, [1.5, 0.25], 1, 1), [[1, 0.25], [1 - half, 0.25 + half], [1 - half, 0.25 - half]]);
  // Without friction the cone has no width.
  near(frictionCone(square, [0, -2], 0, 0.5), [[0, -1], [0, -0.5], [0, -0.5]]);
});

test("errors name the things of the scene that they are about, also behind letters that take several bytes", () => {
  const label = { file: "go.twz", line: 3, column: 3, end_line: 3, end_column: 8, text: "beside `m1[2]`" };
  const findings = [{ severity: "error", title: "no way round `post`", help: null, labels: [label] }, { severity: "warning", title: "`calm`", help: null, labels: [] }];
  const built = buildModel({ ...page({}), failure: { findings, more: 0, places: [] } });
  const names = [...built.blamed];
  for (const name of ["post", "m1", "m1[2]"]) assert.ok(names.includes(name), name);
  assert.ok(!names.includes("calm"));
});

test("a program of which nothing was built is empty, and not an error", () => {
  const built = buildModel({ schedule: null, claims: null, sources: [], failure: { findings: [], more: 0, places: [] } });
  assert.deepEqual([built.devices.length, built.steps.length, built.duration_ns], [0, 0, 0]);
});

test("limits are kept as their relation says", () => {
  const kept = (relation, value) => isKept(value, { relation, limit: 2 });
  assert.deepEqual(["at_most", "at_least", "less", "more", "equal"].map((relation) => [1, 2, 3].map((value) => kept(relation, value))), [
    [true, true, false],
    [false, true, true],
    [true, false, false],
    [false, false, true],
    [false, true, false],
  ]);
});

test("numbers and times are short, with the unit that fits", () => {
  assert.deepEqual([0, 1.23456, 1234567, 0.00012346, 1e-7].map((value) => short(value)), ["0", "1.235", "1234567", "0.0001235", "1.000e-7"]);
  assert.deepEqual([0, 950, 15_000, 2_500_000, 90e9].map((t_ns) => timeText(t_ns)), ["0 s", "950 ns", "15 us", "2.5 ms", "90 s"]);
  assert.deepEqual(
    [["time", 0.02], ["distance", 3.1e-5], ["energy", 0.27], ["effort", Math.PI], ["switches", 9]].map(([outcome, value]) => outcomeText(outcome, value)),
    ["20 ms", "31 um", "270 mJ", "180 deg", "9"],
  );
});
