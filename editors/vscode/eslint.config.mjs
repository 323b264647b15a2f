import js from "@eslint/js";
import globals from "globals";

const rules = {
  eqeqeq: "error",
  "no-shadow": "error",
  "no-unused-vars": ["error", { argsIgnorePattern: "^_" }],
  "no-var": "error",
  "prefer-const": "error",
};

export default [
  { ignores: ["dist/"] },
  js.configs.recommended,
  { files: ["src/**/*.js"], languageOptions: { sourceType: "commonjs", globals: globals.node }, rules },
  { files: ["**/*.mjs"], languageOptions: { sourceType: "module", globals: globals.node }, rules },
];
