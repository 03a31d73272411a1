// The shapes that the page and the program exchange, for `tsc`. No browser loads this file.

/** A part of all visits, or of the time on the wall: 0 to 1. */
type Part = number
type Mark = 'kept' | 'rejected' | 'none'
type ClipState = 'none' | 'missing' | 'queued' | 'rendering' | 'there' | 'damaged'

interface Sheep {
  id: string
  species: string | null
  in_flock: boolean
  source?: 'pool' | 'archive'
  /** As the artist typed it, in the manifest's own unit. */
  want: number
  wanted: Part
  share: Part
  /** share / wanted; null if it is not known. */
  ratio: number | null
  repeat: number
  frames: number
  ins: number
  outs: number
  shown: boolean
  state: ClipState
  percent: number | null
  /** Keys for `/media/strip/`, `/media/fragments/` and `/media/poster/`. */
  strip: string | null
  fragments?: string | null
  genome: boolean
  /** Why its genome cannot be drawn, and what it is drawn without. */
  refused?: string
  without?: string
  licence: string | null
  authors: string[]
  parents: string[]
  mark: Mark
  rating: number
  votes: { for: number; against: number } | null
  activity: number | null
  colour: string | null
  bytes: number | null
  made_ms: number | null
  x: number
  y: number
  pinned: boolean
}

interface Transition {
  from: string
  to: string
  weight: number
  visits: Part
  frames: number
  state: ClipState
  percent: number | null
  genetic: boolean
  /** Decibels off at its ends; `worst` above 1 jumps. */
  join: { from: { db: number } | null; to: { db: number } | null; worst: number } | null
  bad: boolean
  fragments: string | null
}

interface Figures {
  sheep: number
  transitions: number
  shown: number
  worst_ratio: number | null
  entropy_bits: number
  step_minutes: number
}

interface Fault {
  kind: string
  message: string
  sheep?: string
  from?: string
  to?: string
  clip?: string
}

interface Job {
  id: string | number
  kind: string
  /** What the job makes; that of a strip ends in the strip's key. */
  key?: string | null
  what: string
  /** What it is about: of a job of the kind `render` the clip. */
  about?: { sheep: string } | { from: string; to: string } | null
  paused: boolean
  can_pause: boolean
  state: 'queued' | 'running' | 'done' | 'failed' | 'cancelled' | 'waiting'
  done: number
  of: number
  per_second: number | null
  left_s: number | null
  cost_s: number | null
  log: string[]
  error: string | null
}

interface State {
  /** The program's name of this document; empty if something was changed here that it does not know of. */
  tag: string
  revision: string
  name: string
  fps: [number, number]
  size: [number, number]
  by: 'visits' | 'time'
  now_ms: number
  figures: Figures
  faults: Fault[]
  sheep: Sheep[]
  candidates: Sheep[]
  transitions: Transition[]
  undo: string | null
  redo: string | null
  jobs: Job[]
  paused: boolean
  pool: { name: string } | null
  capabilities: { gpu: boolean }
}

/** The places in the list before from and up to which all is as it was, or one that is new. */
type Parts<T> = ([from: number, to: number] | T)[]

/** A whole document, or with `since` what is new in it; figures are in the order of the lists. */
interface Told extends Omit<State, 'sheep' | 'candidates' | 'transitions'> {
  since?: string
  sheep: Parts<Sheep>
  candidates: Parts<Sheep>
  transitions: Parts<Transition>
  shares?: Part[]
  wants?: Part[]
  visits?: Part[]
}

type Edit =
  | { do: 'want'; sheep: string; value: number }
  | { do: 'weight'; from: string; to: string; value: number }
  | { do: 'repeat'; sheep: string; value: number }
  | { do: 'link'; from: string; to: string; frames?: number }
  | { do: 'unlink'; from: string; to: string }
  | { do: 'drop'; sheep: string }
  | { do: 'prune'; drop: string[] }
  | { do: 'rename'; sheep: string; to: string }
  | { do: 'add'; candidates: string[] }
  | { do: 'weights'; values: { from: string; to: string; value: number }[] }

interface WhatIf {
  figures: Figures
  sheep: { id: string; share: Part; wanted: Part; ratio: number | null }[]
  transitions: { from: string; to: string; visits: Part }[]
  frames: number
  cost_s: number | null
  no_longer_shown: string[]
}

/** One line of the list of keys. */
interface Key {
  /** As `keys.js` spells them: `k`, `Shift+K`, `Mod+z`, `ArrowLeft`, `Space`, `g w`. */
  keys: string[]
  /** What they do, in a few words. */
  does: string
  /** A word for the bottom line; without one the key is only in the list that `?` opens. */
  hint?: string
  /** Whether it can be done now. */
  when?: () => boolean
  run: (event: KeyboardEvent) => void
}

interface View {
  /** The view is shown, or its address changed while it is. */
  enter: (params: URLSearchParams) => void
  leave: () => void
  keys: Key[]
}

interface Question {
  title: string
  text?: string
  /** Shown one a line. */
  items?: string[]
  /** The word on the button that does it. */
  yes: string
  /** A choice besides; `ticked` says what was chosen. */
  tick?: string
  ticked?: boolean
}

/** What a view may ask of the frame around it. */
interface Shell {
  /** Opens a view: an entry in the browser's history. */
  go: (view: string, params?: Record<string, string>) => void
  /** Writes the params of the view in the address without an entry in the history. */
  note: (params: Record<string, string>) => void
  /** One sentence on the bottom line, which screen readers hear. `bad`: it was refused or failed. */
  say: (text: string, bad?: boolean) => void
  /** Asks before something that is not undone by itself. */
  ask: (question: Question) => Promise<boolean>
  /** A layer over the page, closed by Escape; the keys of it come before those of the view. */
  over: (content: HTMLElement, options: { label: string; keys?: Key[]; closed?: () => void }) => () => void
  /** Whether pictures may move. */
  moving: () => boolean
  /** Moving pictures: `strips.show(canvas, sheep)`, `strips.forget(canvas)`. */
  strips: import('./strip.js').Strips
}

type MakeView = (root: HTMLElement, store: import('./store.js').Store, api: import('./api.js').Api, shell: Shell) => View
