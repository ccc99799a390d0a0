// SPDX-License-Identifier: Apache-2.0
/** What buttons and keys can do. */
export interface Actions {
  fit(): void;
  fromAbove(): void;
  toggleSide(): void;
  toggleTheme(): void;
  measure(): void;
  /** Points, edges or faces. */
  measureKind(): void;
  /** Leaves what was begun. */
  escape(): void;
  savePicture(): void;
  /** Asks for a video, or ends one. */
  video(): void;
  help(): void;
  play(): void;
  /** Frames ahead, or back where negative. */
  step(frames: number): void;
  toEvent(direction: -1 | 1): void;
  lookFromFrame(): void;
  /** Whether the view moves along with the current frame. */
  follow(): void;
  toggleLayer(key: string): void;
  /** Of a run that goes on; null where the page shows a finished one. */
  live: LiveActions | null;
}

export interface LiveActions {
  /** Presses a button of the run: pause, step, mapping, save, reset, end. */
  press(name: string): void;
  toggleFrameView(): void;
  /** Back to the newest frame. */
  follow(): void;
}
