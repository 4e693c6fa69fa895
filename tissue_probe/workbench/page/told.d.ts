// Types of what the server tells and takes: written by page_types.py, not by hand.

export interface AnswerMessage {
  verdict: "adequate" | "missing" | "ambiguous" | "unexplained";
  sentences: string[];
  effects: string[];
  indistinguishable: string[];
  unseen: string[];
  ranking: RankedMessage[];
  suggested_excitation: ExperimentMessage | null;
}

export interface Answers {
  cancel: null;
  compare: null;
  undo: null;
  rank: null;
  forget: null;
  map: null;
  recording: null;
  define: null;
  use: null;
  ask: null;
  add: null;
  site: null;
  example: null;
  effects: OwnEffectMessage[];
  command: string;
  recorded: NoMessage;
  lines: LinesMessage;
  dots: DotsMessage;
  spectrum: SpectrumMessage;
  brush: BrushMessage;
  where: WhereMessage;
  raster: NoMessage;
  next: NextMessage;
}

export interface Brush {
  axis: "frequency" | "time" | "indentation" | "speed" | "phase";
  low: number;
  high: number;
}

export interface BrushMessage {
  spans: [number, number][];
  count: number;
  rmse?: number;
}

export interface ChoicesMessage {
  question: ItemMessage[];
  rigs: RigMessage[];
  position_unit: string[];
  force_unit: string[];
  time_unit: string[];
  examples: ExampleMessage[];
  live: boolean;
  commands: boolean;
}

export interface ColumnMessage {
  name: string;
  unit: string;
  count: number;
  first: string[];
  sketch: (number | null)[];
}

export interface DeskMessage {
  files: FileMessage[];
  fitted: number | null;
  second: number | null;
  asked: Record<string, unknown>;
  rungs: RungMessage[];
  ranking: RankingMessage | null;
  map: MapMessage | null;
  own: OwnEffectMessage[];
  job: JobMessage | null;
  wants_rig: boolean;
  refusal: ProblemMessage | null;
}

export interface DotsMessage {
  limits: [number, number, number, number];
}

export interface ErrorsMessage {
  rmse: number | null;
  heldout_rmse: number | null;
}

export interface ExampleMessage {
  name: string;
  title: string;
  told: string;
}

export interface ExperimentMessage {
  excitation: Record<string, unknown>;
  separation: number | null;
  shows: string[];
  calibration: string;
  command: string;
  command_notes: string[];
}

export interface FileMessage {
  number: number;
  name: string;
  layout: Record<string, unknown>;
  ready: boolean;
  table: boolean;
  problem: ProblemMessage | null;
  preview: PreviewMessage | null;
  samples?: number;
  rate?: number;
  seconds?: number;
  sites?: number;
  notes?: string[];
}

export interface InclusionMessage {
  x: number;
  y: number;
  probability: number;
  stiffness: number | null;
  stiffness_sd: number | null;
  contrast: number;
  boundary_50: number[][];
  boundary_95: number[][];
}

export interface ItemMessage {
  name: string;
  kind: string;
  about: string;
  default: unknown;
  choices: string[];
  else_: string;
  option: string;
  metavar: string;
  label: string;
  example: string;
}

export interface JobMessage {
  title: string;
  doing: string;
  share: number | null;
  seconds: number;
  rows: Record<string, ErrorsMessage>;
}

export interface LinesMessage {
  noise: number;
  unused: [number, number][];
  dense: boolean;
  end: number;
  rmse?: number;
}

export interface LiveMessage {
  estimators: string[];
  fault: string;
  state: string;
  verdict: VerdictMessage | null;
  health: [string, number, string][];
}

export interface MapMessage {
  text: string;
  sites: SiteMessage[];
  inclusions: InclusionMessage[];
  contrast?: number;
  number?: number;
  file?: number;
  site?: number | null;
}

export interface News {
  choices: ChoicesMessage;
  desk: DeskMessage;
  job: JobMessage | null;
  study: StudyMessage;
  live: LiveMessage;
  live_map: MapMessage;
}

export interface NextMessage {
  models: string[];
  separation: number | null;
}

export interface NoMessage {}

export interface OwnEffectMessage {
  name: string;
  family: string;
  physics: string;
  file?: string;
}

export interface ParameterMessage {
  name: string;
  value: number;
  deviation: number | null;
  low: number | null;
  high: number | null;
  unit: string;
  at_limit: boolean;
  from: number;
  to: number;
}

export interface PreviewMessage {
  kind: "table" | "bag" | "recording";
  columns: ColumnMessage[];
  notes: string[];
}

export interface ProblemMessage {
  told: string;
  fields: string[];
}

export interface ProfileMessage {
  axis: string;
  unit: string;
  told: string;
  here: RegionMessage | null;
  foremost: boolean;
}

export interface QuantityMessage {
  name: "force" | "position";
  unit: "N" | "m";
  rate: string;
  drawn: string;
  per_drawn: number;
  small: string;
  per_small: number;
  zeroed: boolean;
}

export interface RankedMessage {
  rmse: number | null;
  heldout_rmse: number | null;
  effect: string;
  family: string;
  probability?: number | null;
  converged?: boolean;
}

export interface RankingMessage {
  rung: number;
  rows: Record<string, ErrorsMessage>;
  done: boolean;
  answer?: AnswerMessage;
  text?: string;
  converged?: boolean;
  physics?: Record<string, string>;
  rivals?: string[];
  settings?: Record<string, string>;
  shape?: string | null;
}

export interface RegionMessage {
  begin: number;
  end: number;
  excess: number;
  share: number;
  contrast: number;
}

export interface RigMessage {
  name: string;
  whose: string;
  drawing: string;
}

export interface RungMessage {
  number: number;
  added: string;
  title: string;
  output: QuantityMessage;
  input: QuantityMessage;
  rmse: number;
  heldout: number | null;
  noise: number;
  ratio: number;
  converged: boolean;
  parameters: ParameterMessage[];
  text: string;
  notes: string[];
  stretches: StretchesMessage;
  second: SecondMessage | null;
  second_told: string;
}

export interface SecondMessage {
  rmse: number | null;
  noise: number;
  stretches: StretchesMessage;
}

export interface SiteMessage {
  site: number | null;
  x: number;
  y: number;
  stiffness: number | null;
  stiffness_sd: number | null;
  verdict: string;
}

export interface SpectrumMessage {
  white: number;
}

export interface StretchesMessage {
  names: string[];
  worst: number;
  seconds: number[];
  samples: number[];
}

export interface StudyMessage {
  name: string;
  columns: string[];
  rows: ((string | number | boolean | null)[])[];
}

export interface VerdictMessage {
  verdict: string;
  effects: [string, number][];
  error_current: number | null;
  error_proposed: number | null;
  unseen: string[];
  experiment: string;
}

export interface WhereMessage {
  regions: ProfileMessage[];
}

export interface Requests {
  cancel: {};
  compare: {};
  undo: {};
  rank: {};
  raster: {};
  next: {};
  forget: {
    file: number;
  };
  map: {
    file: number;
  };
  recording: {
    row: number;
  };
  spectrum: {
    rung: number;
    source?: "fitted" | "second";
    stretch?: number;
    width?: number;
    height?: number;
    brush?: Brush | null;
  };
  brush: {
    rung: number;
    source?: "fitted" | "second";
    stretch?: number;
    width?: number;
    height?: number;
    brush?: Brush | null;
  };
  where: {
    rung: number;
    source?: "fitted" | "second";
    stretch?: number;
    width?: number;
    height?: number;
    brush?: Brush | null;
  };
  define: {
    file: number;
    layout: Record<string, unknown>;
  };
  use: {
    fitted: number;
    second?: number | null;
  };
  ask: {
    asked: Record<string, unknown>;
  };
  add: {
    effect: string;
    after?: number | null;
  };
  site: {
    site: number;
  };
  effects: {
    text?: string;
    name?: string;
    consent?: boolean;
  };
  example: {
    name: string;
  };
  recorded: {
    file: number;
    part?: number;
    width?: number;
  };
  lines: {
    rung: number;
    source?: "fitted" | "second";
    stretch?: number;
    width?: number;
    height?: number;
    brush?: Brush | null;
    from?: number | null;
    to?: number | null;
    values?: Record<string, number> | null;
    effect?: string | null;
  };
  dots: {
    rung: number;
    source?: "fitted" | "second";
    stretch?: number;
    width?: number;
    height?: number;
    brush?: Brush | null;
    axis: "time" | "indentation" | "speed" | "phase";
  };
  command: {
    command: string;
    given?: Record<string, unknown>;
  };
}
