import type { World, Recipe, CatalogEntry } from "./simd/rhexis_web.js";
export type {
  World, Recipe, CatalogEntry, Measures, BodyFigures, TearFigures, CourseFigures, GraspFigures, NamedForce, Surfaces, WorldEvent,
} from "./simd/rhexis_web.js";

/** Whether WebAssembly has 128-bit SIMD here. */
export function hasSimd(): boolean;

/** What a world is made from. */
export interface WorldOptions {
  /** The text of a scene (TOML), or the name of one of the catalog. */
  scene: string;
  /** Changes, as `rhexis run --set` takes them: `"run.dt=5"`. */
  set?: string[];
  /** Contents of files by the paths that the scene names them by. */
  files?: Record<string, Uint8Array>;
  /** Whether the motions of the scene's own grips and holds are left out. */
  byHand?: boolean;
}

/** The engine, loaded. */
export interface Engine {
  World: typeof World;
  Recipe: typeof Recipe;
  /** The scenes of the catalog. */
  catalog(): CatalogEntry[];
  version(): string;
  /** Repeats a recording: the hash of its end; throws where it is not the recorded one. */
  replay(recording: Uint8Array): string;
  /** Builds a world; throws with place, reason and remedy where the scene is refused. `free()` it when it is done with. */
  world(options: WorldOptions): World;
  /** Which module runs. */
  flavour: "simd" | "plain";
  memory: WebAssembly.Memory;
}

/** Loads the engine, in a page, a worker or Node. */
export function load(options?: {
  /** Module with SIMD or without: by default the one that runs here. */
  simd?: boolean;
  /** Bytes, address, answer or compiled form of that module, where it is not the file beside this one. */
  module?: BufferSource | WebAssembly.Module | URL | string | Response | Promise<Response>;
}): Promise<Engine>;
