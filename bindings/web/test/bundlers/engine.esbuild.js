import { hasSimd, load } from "rhexis";
import plainFile from "rhexis/plain.wasm";
import simdFile from "rhexis/simd.wasm";

export function open({ simd = hasSimd() } = {}) {
  return load({ simd, module: new URL(simd ? simdFile : plainFile, import.meta.url) });
}
