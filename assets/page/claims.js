// What the plan claims: cost, bound and proof, limits and what was reached, and what remains to be known.
"use strict";

const RELATIONS = { at_most: "≤", at_least: "≥", less: "<", more: ">", equal: "=" };

function claimRow(label, value, kind = "") {
  const line = document.createElement("div");
  line.className = `claim ${kind}`;
  const [name, text] = [document.createElement("span"), document.createElement("b")];
  name.textContent = label;
  text.textContent = value;
  line.append(name, text);
  return line;
}

/** How a value that was reached differs from the one that was asked for. */
function reachedText(reached) {
  const pair = (list) => `(${list.map((value) => short(value)).join(", ")}) um`;
  const off_um = reached.off_um === undefined ? null : `${short(reached.off_um, 3)} um off`;
  const off_deg = reached.off_deg === undefined ? null : `${short(reached.off_deg, 3)} deg off`;
  const off = [off_um, off_deg].filter(Boolean).join(", ");
  const name = reached.robot || (reached.axis ? `about ${reached.axis}` : reached.of);
  const at = reached.reached_um ? pair(reached.reached_um) : `${short(reached.reached_deg, 6)} deg`;
  return [name, `${at}, ${off}`];
}

function add(parent, tag, text, className = "") {
  const element = document.createElement(tag);
  element.textContent = text;
  element.className = className;
  parent.append(element);
  return element;
}

/** A number of things: `1 error`, `2 errors`. */
const counted = (number, noun) => `${number} ${noun}${number === 1 ? "" : "s"}`;

function drawClaims(root, model, seek) {
  // What could not be planned claims nothing.
  const runs = model.devices.flatMap((device) => device.runs).filter(({ index }) => !model.failure || model.steps.some((step) => step.plan === index));
  const isRecorded = Boolean(model.page.recorded);
  for (const { plan, order, requirements } of runs.sort((a, b) => a.index - b.index)) {
    const card = add(root, "section", "", "card");
    const title = add(card, "button", `${plan.task} on ${plan.device}`, "jump");
    title.type = "button";
    title.title = `jump to ${timeText(plan.start_ns)}`;
    title.addEventListener("click", () => seek(plan.start_ns));
    const unit = plan.unit ? ` ${plan.unit}` : "";
    const proof = isRecorded ? "proven, says the log" : "proven";
    card.append(claimRow(`least ${plan.objective.replaceAll("_", " ")}`, plan.optimal ? proof : "best found", plan.optimal && !isRecorded ? "good" : "open"));
    card.append(claimRow("cost", short(plan.cost, 6) + unit));
    const bound = claimRow("bound", short(plan.bound, 6) + unit);
    bound.title = isRecorded ? "no plan costs less, says the log" : "no plan costs less";
    card.append(bound);
    for (const [outcome, value] of Object.entries(plan.outcomes).map((entry) => outcomeOf(...entry))) {
      const limits = requirements.filter((requirement) => requirement.outcome === outcome);
      const within = limits.map(({ relation, limit }) => ` ${RELATIONS[relation]} ${outcomeText(outcome, limit)}`);
      const kind = limits.length ? (limits.every((limit) => isKept(value, limit)) ? "good" : "open") : "";
      card.append(claimRow(outcome.replaceAll("_", " "), outcomeText(outcome, value) + within.join(","), kind));
    }
    for (const { part, share, relation, limit } of order.contents || []) {
      const name = `${order.parts[part].name}: ${share.fluid ?? "volume"}`;
      card.append(claimRow(name, `${RELATIONS[relation]} ${short(limit, 6)}`, "good"));
    }
    const { avoided = [], washes = [] } = order.contamination || {};
    for (const fluid of new Set(avoided.map(({ of }) => of))) {
      const others = avoided.filter(({ of }) => of === fluid).map(({ within }) => within);
      card.append(claimRow(`no ${fluid} in`, others.join(", "), "good"));
    }
    if (washes.length) card.append(claimRow("washed with", washes.join(", ")));
    card.append(claimRow("planner", plan.planner));
    for (const { subject, text } of plan.remarks || []) add(card, "p", `${subject}: ${text}`, "remark");
    if (isRecorded) add(card, "p", "Bounds, proofs, estimates, guarantees and remarks are as the log records them; the verifier does not derive them again.", "remark");
  }
  const reached = model.steps.flatMap((step) => (step.reached || []).map((one) => ({ step, one })));
  if (reached.length) {
    const card = add(root, "section", "", "card");
    add(card, "h3", "Reached, where a goal is not met exactly");
    for (const { step, one } of reached.slice(0, 100)) {
      const [name, text] = reachedText(one);
      const line = claimRow(name, text);
      line.title = `${step.file}:${step.line} ${step.text}`;
      card.append(line);
    }
    if (reached.length > 100) add(card, "p", `and ${reached.length - 100} more`, "remark");
  }
}

/** What kind of schedule it is. */
function drawAbout(root, model) {
  const card = add(root, "section", "", "card");
  add(card, "h3", "About this schedule");
  card.append(claimRow("channels", String(model.channels.length)), claimRow("actuations", String(model.schedule.actuations.length)));
  card.append(claimRow("tweeze", model.page.tweeze));
  for (const setting of model.page.settings || []) card.append(claimRow("set", setting));
}
