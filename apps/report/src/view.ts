// What is being looked at, and those who want to know when it changes.
export type NamedCamera = 'fit' | 'top' | 'front' | 'side';

export interface View {
  /** Frame on the report's time axis; between two frames while playing. */
  at: number;
  playing: boolean;
  field: string;
  /** Names of the hidden variants. */
  hidden: ReadonlySet<string>;
  /** The one that fills the stage, or null. */
  isolated: string | null;
  page: number;
  clip: boolean;
  lines: boolean;
  ghost: boolean;
  /** Heights are shown this many times as large. */
  exaggeration: number;
  camera: NamedCamera | 'free';
}

export type Key = keyof View;
type Listener = (changed: ReadonlySet<Key>) => void;

export class ViewStore {
  private readonly listeners: Listener[] = [];

  constructor(private view: View) {}

  get now(): Readonly<View> {
    return this.view;
  }

  set(change: Partial<View>): void {
    const changed = new Set<Key>();
    for (const key of Object.keys(change) as Key[]) {
      if (this.view[key] !== change[key]) changed.add(key);
    }
    if (changed.size === 0) return;
    this.view = { ...this.view, ...change };
    for (const listener of this.listeners) listener(changed);
  }

  /** Calls `listener` whenever one of `keys` has changed. */
  on(keys: Key[], listener: () => void): void {
    this.listeners.push((changed) => {
      if (keys.some((key) => changed.has(key))) listener();
    });
  }
}
