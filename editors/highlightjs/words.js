// Written by scripts/words.js from ../words.json.
export default {
  "declarations": ["device", "instrument", "let", "output", "program", "scene", "task", "use", "wiring"],
  "functions": ["abs", "atan2", "cos", "count", "euler", "floor", "max", "min", "pose", "quaternion", "round", "sin", "sqrt"],
  "nouns": ["detector", "frame", "heater", "magnet", "obstacle", "part", "reservoir", "robot"],
  "operators": ["!=", "*", "+", "-", "..", "/", "<", "<=", "==", ">", ">=", "^"],
  "prefixed_units": ["A", "C", "F", "Hz", "J", "K", "N", "Pa", "V", "W", "g", "m", "s"],
  "prefixes": ["G", "M", "T", "c", "d", "f", "k", "m", "n", "p", "u", "µ", "μ"],
  "prepositions": ["about", "after", "among", "at", "by", "for", "from", "in", "on", "to", "via", "with", "within"],
  "reserved": ["about", "after", "among", "as", "at", "by", "device", "false", "for", "from", "in", "instrument", "let", "on", "output", "program", "scene", "table", "task", "to", "true", "use", "via", "wiring", "with", "within"],
  "step_nouns": ["any", "state"],
  "steps": ["apply", "assay", "assemble", "avoid", "detect", "discard", "dispense", "drive", "grasp", "heat", "hold", "incubate", "merge", "minimize", "mix", "move", "orient", "prompt", "pulse", "release", "require", "rotate", "run", "set", "split", "start", "together", "translate", "using", "visit", "wait", "wash"],
  "truths": ["false", "true"],
  "units": ["%", "deg", "degC", "h", "min", "px", "rad", "turn"]
};
