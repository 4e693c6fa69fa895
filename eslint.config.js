// What the page's scripts are held to; the vendored one is not ours.
import js from "@eslint/js";
import globals from "globals";

export default [
  { ignores: ["**/vendor/**", "**/.venv/**", "**/build/**", "**/node_modules/**"] },
  js.configs.recommended,
  {
    files: ["tissue_probe/workbench/page/*.js"],
    languageOptions: { ecmaVersion: 2024, sourceType: "module", globals: globals.browser },
    rules: {
      eqeqeq: "error",
      "no-implicit-coercion": "error",
      "no-restricted-properties": [
        "error",
        { property: "innerHTML", message: "make elements (elements.js): text stays text" },
        { property: "outerHTML", message: "make elements (elements.js): text stays text" },
      ],
      "no-eval": "error",
      "no-shadow": ["error", { builtinGlobals: false }],
      "no-unused-vars": "error",
      "no-var": "error",
      "prefer-const": "error",
    },
  },
];
