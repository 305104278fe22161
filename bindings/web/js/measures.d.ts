/** A scene of the catalog. */
export interface CatalogEntry {
  name: string;
  about: string;
  /** The scene file, to copy and change. */
  text: string;
}

/** Triangles in space, which face outwards. */
export interface Surfaces {
  /** Three numbers per vertex, in mm. */
  positions: Float32Array;
  /** Rows of the vertices, three per triangle. */
  indices: Uint32Array;
}

/** A force by the name of its hold or grip, in N. */
export interface NamedForce {
  name: string;
  force_n: [number, number, number];
}

/** What was torn, as `report.json` has it. Lengths are those of the rest shape. */
export interface TearFigures {
  length_mm: number;
  starts: number;
  advances: number;
  ended: number;
  fragments_freed: number;
  branches: number;
  refusals: number;
  tips: number;
}

/** The force of one grasp. */
export interface GraspFigures {
  from_ms: number;
  until_ms: number;
  force_mean_n: number;
  force_rms_n: number;
  force_peak_n: number;
}

/** The course of a tear about the axis of the rim, as `report.json` has it. */
export interface CourseFigures {
  outcome: "closed" | "ran_out" | "torn_off" | "unfinished";
  completion_deg: number;
  diameter_mm: number | null;
  diameter_as_it_lies_mm: number | null;
  circularity_as_it_lies: number | null;
  circularity: number | null;
  decentration_mm: number | null;
  largest_radius_mm: number;
  grasps: number;
  time_ms: number;
  force_rms_n: number;
  force_peak_n: number;
  force_mean_n: number;
  force_time_above_mn_s: number;
  tool_path_mm: number;
  tremor_mm: number | null;
  zonule_load_n: number | null;
  spikes: number | null;
  optic_covered: number | null;
  optic_overlap_mm: number | null;
  force_by_grasp: GraspFigures[];
}

/** One body. */
export interface BodyFigures {
  name: string;
  vertices: number;
  triangles: number;
  elastic_mj: number;
  kinetic_mj: number;
  reactions: NamedForce[];
  grips: NamedForce[];
  course: CourseFigures | null;
  tear: TearFigures | null;
}

/** The figures of a world as it stands. */
export interface Measures {
  scene: string;
  steps: number;
  steps_planned: number;
  simulated_ms: number;
  dt_ms: number;
  is_finished: boolean;
  /** Sixteen hexadecimal digits. */
  hash: string;
  /** Torn and cut, of all bodies. */
  length_mm: number;
  tips: number;
  criterion: number;
  /** Amount of the hand's force on the tissue. */
  hand_n: number;
  /** Largest amount of a force of hand, grips and holds. */
  force_n: number;
  solver: { iterations: number; residual: number; rolled_back: number; has_failed: boolean };
  bodies: BodyFigures[];
}

/** Something that has happened. */
export interface WorldEvent {
  time_ms: number;
  body: string;
  /** In the engine's words. */
  what: string;
}
