// The page: steps the run by the module that the address asks for, and shows its bits.

import { open } from "./engine.js";
import { bitsOf } from "./bits.js";

const simd = new URLSearchParams(location.search).get("simd");
try {
  window.bits = await bitsOf(await open(simd === null ? {} : { simd: simd === "true" }));
} catch (error) {
  window.bits = { error: `${error.stack ?? error}` };
}
