// Loads the engine: the module with 128-bit SIMD where the browser has it, the plain one elsewhere. Both compute the same bits.

/** A module that uses one SIMD instruction: valid where they are known. */
const SIMD_PROBE = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11,
]);

/** Whether WebAssembly has 128-bit SIMD here. */
export function hasSimd() {
  return WebAssembly.validate(SIMD_PROBE);
}

/**
 * Loads the engine, in a page, a worker or Node.
 * `simd`: the module to take, by default the one that runs here. `module`: its bytes, address or compiled form, where it is not the file beside this one.
 */
export async function load({ simd = hasSimd(), module } = {}) {
  const flavour = simd ? "simd" : "plain";
  const glue = simd ? await import("./simd/rhexis_web.js") : await import("./plain/rhexis_web.js");
  const source = readable(module ?? (simd ? simdFile() : plainFile()));
  const { memory } = await glue.default({ module_or_path: source });
  const { World, Recipe, catalog, version, replay } = glue;
  return { World, Recipe, catalog, version, replay, world: (options) => world(glue, options), flavour, memory };
}

// Bundlers find a file by an address in exactly this form, with its path as a literal.
const simdFile = () => new URL("./simd/rhexis_web_bg.wasm", import.meta.url);
const plainFile = () => new URL("./plain/rhexis_web_bg.wasm", import.meta.url);

/** Node does not fetch files: their bytes. No import of its modules, which bundlers for browsers refuse. */
function readable(source) {
  if (!(source instanceof URL) || source.protocol !== "file:") return source;
  return globalThis.process?.getBuiltinModule?.("node:fs").readFileSync(source) ?? source;
}

/** Builds a world from a scene and what goes with it. */
function world({ Recipe }, { scene, set = [], files = {}, byHand = false }) {
  const recipe = new Recipe(scene);
  try {
    set.forEach((assignment) => recipe.set(assignment));
    Object.entries(files).forEach(([path, bytes]) => recipe.file(path, bytes));
    recipe.byHand(byHand);
    return recipe.build();
  } finally {
    recipe.free();
  }
}
