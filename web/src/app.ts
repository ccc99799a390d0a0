// SPDX-License-Identifier: Apache-2.0
// The page's one place of truth: runs, state, and who is told when the state changes.
import * as THREE from 'three';
import type { Loaded } from './scene/sources';
import { emptyScene, type Frames, type Vec3 } from './scene/scene';
import { fromHash, toHash, withinRuns, type State } from './state';
import { boundsOf, outlineOf } from './view3d/bounds';
import { rangesOf } from './view3d/ranges';
import { buildRun, disposeRun, type Run } from './view3d/run';
import { View3d } from './view3d/view';
import type { ScaleFactor } from './measure/length';
import { initialState } from './initial_state';
import type { LayerObject, Style } from './view3d/style';

/** What listeners are told of: parts of the state, more frames of a run, another map of a run, a run that began anew. */
export type Change = keyof State | 'frames' | 'scene' | 'forgotten';

export class App {
  readonly runs: Run[];
  readonly errors: { name: string; message: string }[];
  up: Vec3;
  planar: boolean;
  readonly view: View3d;
  initial: State;
  /** The run that goes on, and its number on the server. */
  readonly live: { run: number; scene: number } | null;
  /** Recordings: the number on the server of each, by run. */
  readonly recordings: Map<number, number>;
  state: State;
  /** Where the program behind the page can be asked to measure in a run's map; null where it cannot. */
  readonly measureUrls: (string | null)[];
  /** Meters for one unit of a run's map, where the person entered a known length. */
  readonly scaleFactors = new Map<number, ScaleFactor>();
  private ranges: Style['ranges'];
  private readonly listeners: ((changed: Set<Change>) => void)[] = [];
  private hashTimer = 0;

  constructor(loaded: Loaded[], canvas: HTMLCanvasElement) {
    const good = loaded.map(forLive).filter((l) => l.scene !== null);
    this.errors = loaded.filter((l) => l.error !== null).map((l) => ({ name: l.name, message: l.error! }));
    this.runs = good.map((l, i) => buildRun(l.name, l.scene!, i));
    this.measureUrls = good.map((l) => l.measureUrl ?? null);
    const live = good.findIndex((l) => l.live);
    this.live = live < 0 ? null : { run: live, scene: good[live].index ?? live };
    this.recordings = new Map(good.flatMap((l, i): [number, number][] => (l.recording ? [[i, l.index ?? i]] : [])));
    const scenes = this.runs.map((r) => r.scene);
    this.up = scenes[0]?.up ?? [0, 0, 1];
    this.planar = scenes.length > 0 && scenes.every((s) => s.planar);
    const bounds = boundsOf(scenes);
    this.ranges = rangesOf(scenes, this.up);
    this.view = new View3d(canvas, this.up, bounds, outlineOf(scenes, bounds));
    for (const run of this.runs) this.view.add(run);
    this.initial = initialState(scenes, bounds.getSize(new THREE.Vector3()).length());
    this.state = this.fromAddress();
    this.applyAll();
    this.view.controls.addEventListener('end', () => this.rememberCamera());
  }

  get active(): Run | null {
    return this.runs[this.state.active] ?? null;
  }

  get frames(): Frames | null {
    return this.active?.scene.frames ?? null;
  }

  get style(): Style {
    const { pointColor, trajectoryColor, map, pointSize, maxSigma, cameraSize, ellipsoidScale } = this.state;
    return {
      pointColor, trajectoryColor, map, pointSize, maxSigma, cameraSize, ellipsoidScale,
      dark: this.dark, up: this.up, ranges: this.ranges,
    };
  }

  get dark(): boolean {
    if (this.state.theme !== 'auto') return this.state.theme === 'dark';
    return matchMedia('(prefers-color-scheme: dark)').matches;
  }

  onChange(listener: (changed: Set<Change>) => void): void {
    this.listeners.push(listener);
  }

  set(patch: Partial<State>): void {
    Object.assign(this.state, patch);
    const changed = new Set(Object.keys(patch) as (keyof State)[]);
    const drawn: (keyof State)[] = ['frame', 'active', 'camera'];
    if ([...changed].some((key) => !drawn.includes(key))) this.applyAll();
    this.view.requestDraw();
    for (const listener of this.listeners) listener(changed);
    this.writeHashSoon();
  }

  /** More frames came; `frame` is the current one. The address does not follow: it would change without end. */
  framesGrew(frame: number): void {
    this.state.frame = frame;
    this.view.requestDraw();
    for (const listener of this.listeners) listener(new Set<Change>(['frames', 'frame']));
  }

  /** Another map of a run takes the place of the one before; switches, colors and the view stay. `kept`: layers in both. */
  replaceRun(run: Run, kept: LayerObject[]): void {
    const before = this.runs[run.index];
    this.view.remove(before);
    disposeRun(before, kept);
    for (const layer of kept) run.group.add(layer.object);
    this.runs[run.index] = run;
    this.view.add(run);
    this.measureContent();
    this.contentGrew();
  }

  /** Counts, names and what can be chosen may have changed. */
  contentGrew(): void {
    for (const listener of this.listeners) listener(new Set<Change>(['scene']));
  }

  /** A run began anew: nothing that was measured in its map before holds. */
  forgetMeasured(run: number): void {
    this.scaleFactors.delete(run);
    for (const listener of this.listeners) listener(new Set<Change>(['forgotten']));
    this.refresh();
  }

  /** Where the content lies and which values it has, after it changed. */
  measureContent(): void {
    const scenes = this.runs.map((r) => r.scene);
    this.up = scenes[0].up;
    this.planar = scenes.every((s) => s.planar);
    const bounds = boundsOf(scenes);
    this.ranges = rangesOf(scenes, this.up);
    this.view.setContent(bounds, outlineOf(scenes, bounds), this.up);
    this.applyAll();
  }

  /** Ranges of colors that grow with the frames alone. */
  growRanges(): void {
    const { time, sigma } = rangesOf(this.runs.map((r) => ({ ...r.scene, layers: [] })), this.up);
    this.ranges = { ...this.ranges, time, sigma };
    this.applyAll();
  }

  /** What was not chosen by hand begins anew, as the first map suits it. */
  beginAnew(): void {
    const next = initialState(this.runs.map((r) => r.scene), this.view.bounds.getSize(new THREE.Vector3()).length());
    const patch = Object.entries(next).filter(([key]) => {
      const name = key as keyof State;
      return !['frame', 'active', 'layers', 'camera', 'hiddenRuns'].includes(name) && this.state[name] === this.initial[name];
    });
    this.initial = next;
    this.set(Object.fromEntries(patch) as Partial<State>);
    this.contentGrew();
  }

  /** Redraws with the same state, such as after the system changed between dark and light. */
  refresh(): void {
    this.set({ theme: this.state.theme });
  }

  layerShown(key: string): boolean {
    return this.state.layers[key] ?? this.runs.some((r) => r.layers.some((l) => l.key === key && l.shownAtFirst));
  }

  setLayer(key: string, on: boolean): void {
    this.set({ layers: { ...this.state.layers, [key]: on } });
  }

  setRun(index: number, on: boolean): void {
    const others = this.state.hiddenRuns.filter((i) => i !== index);
    this.set({ hiddenRuns: on ? others : [...others, index] });
  }

  fit(): void {
    this.set({ camera: null });
    if (this.planar) this.view.fitFromAbove();
    else this.view.fit();
  }

  rememberCamera(): void {
    const { camera, controls } = this.view;
    this.set({ camera: [...camera.position.toArray(), ...controls.target.toArray()] });
  }

  private applyAll(): void {
    document.documentElement.dataset.theme = this.dark ? 'dark' : 'light';
    const style = this.style;
    for (const run of this.runs) {
      run.group.visible = !this.state.hiddenRuns.includes(run.index);
      for (const layer of run.layers) {
        layer.object.visible = this.layerShown(layer.key);
        layer.applyStyle(style);
      }
    }
    this.view.reference.object.visible = this.state.layers.reference ?? true;
    this.view.applyStyle(style);
  }

  /** Looks at the content, once the page has its layout and the view its size. */
  begin(): void {
    this.view.resize();
    const place = this.state.camera;
    if (!place) return this.fit();
    this.view.camera.position.set(place[0], place[1], place[2]);
    this.view.controls.target.set(place[3], place[4], place[5]);
    this.view.controls.update();
  }

  private writeHashSoon(): void {
    clearTimeout(this.hashTimer);
    this.hashTimer = window.setTimeout(() => this.writeHash(), 300);
  }

  /** A link was opened in the same tab. */
  readHash(): void {
    this.set(this.fromAddress());
    this.begin();
  }

  /** A link may be of a page with other runs. */
  private fromAddress(): State {
    return withinRuns(fromHash(location.hash, this.initial), this.runs.map((r) => r.scene.frames?.count ?? 0));
  }

  writeHash(): void {
    const hash = toHash(this.state, this.initial);
    history.replaceState(null, '', hash === '' ? location.pathname + location.search : `#${hash}`);
  }
}

/** A run whose map cannot be read now may send a better one. */
function forLive(loaded: Loaded): Loaded {
  return loaded.live && !loaded.scene ? { ...loaded, scene: emptyScene(loaded.name) } : loaded;
}
