// What Walk, Graph, Breed, Lineage and Ship alone exchange with the program, beside `types.d.ts`. No browser loads this file.

interface WalkClip {
  kind: 'loop' | 'transition'
  sheep?: string
  from?: string
  to?: string
  /** How long it is shown, repeats included. */
  frames: number
  start_frame: number
  fragments: string | null
  preview: string | null
}
interface WalkOften { id: string; share: Part; wanted: Part }
interface WalkSoon { id: string; clip: number; after_s: number }
interface WalkAnswer { clips: WalkClip[]; too_often: WalkOften[]; too_soon: WalkSoon[] }

interface JoinEnd {
  kind: 'loop' | 'transition'
  sheep?: string
  from?: string
  to?: string
  frames: number
  fragments: string | null
}
/** `severity`: above 1 it jumps; null: nobody judged it. */
interface Join { from: JoinEnd; to: JoinEnd; severity: number | null; db: number | null; bad?: boolean; why?: string }

/** The header of `/media/packets`. `pts` and `dts` are frame numbers of the clip. */
interface PacketsHead {
  codec: string
  description: string
  rate: [number, number]
  frames: number
  packets: { pts: number; dts: number; key: boolean; bytes: number }[]
}

interface Cell {
  id: string
  parents: string[]
  op: string
  /** By the ending of its files; empty until it is made. */
  species: string
  strip: string | null
  state: 'queued' | 'running' | 'there' | 'failed'
  error?: string | null
}
interface Brood { id: string; parents: string[]; cells: Cell[]; at_ms: number }

/** A transition that the flock lacks. */
interface NewLink { from: string; to: string; frames: number; can_be_rendered: boolean }
interface Pruning {
  /** The sheep that go. */
  drop: string[]
  was: Figures
  figures: Figures
  /** The first sheep of every other part that is as large as the one that is kept. */
  ties: string[]
  /** The other parts, the largest first, and what would bring each in. */
  parts: { sheep: string[]; links: NewLink[] }[]
  fewest: number
  frames: number
}

interface LineageNode {
  id: string
  species: string | null
  alive: boolean
  reason: string | null
  /** For, less those against. */
  votes: number
  rating: number | null
  strip: string | null
  in_flock: boolean
}
interface LineageEdge { parent: string; child: string; op: string }

interface ShipAnswer {
  faults: Fault[]
  joins: { judged: number; jumps: number; worst: number | null } | null
  credits: { licence: string | null; sheep: number; authors: string[] }[]
  bytes: number
  files: number
  packed: boolean
  /** Null if nothing is packed, or if nobody has compared the flock as it is now. */
  difference: { of?: string; added: string[]; removed: string[]; changed: string[] } | null
  ready: boolean
  why_not: string[]
  keys?: string[]
  targets?: string[]
}
