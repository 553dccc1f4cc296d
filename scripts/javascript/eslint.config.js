// The rules of eslint for the explorer's page and its tests; tsc checks types and unknown names, prettier checks the format.
import js from "@eslint/js";
import globals from "globals";

export default [
  js.configs.recommended,
  {
    languageOptions: { ecmaVersion: 2022, sourceType: "module", globals: globals.browser },
    linterOptions: { reportUnusedDisableDirectives: "error" },
    rules: {
      curly: ["error", "multi-line"],
      eqeqeq: "error",
      "max-lines": ["error", { max: 400, skipComments: true }],
      "no-console": "error",
      "no-implicit-coercion": ["error", { boolean: true, number: true, string: true }],
      "no-unused-vars": ["error", { args: "after-used" }],
      "no-var": "error",
      "object-shorthand": "error",
      "prefer-const": "error",
      "prefer-template": "off",
    },
  },
  { files: ["**/*.mjs"], languageOptions: { globals: globals.node } },
];
