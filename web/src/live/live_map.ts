// SPDX-License-Identifier: Apache-2.0
// The run in the 3D view: its frames as they come, and its map each time a new one was fetched.
import * as THREE from 'three';
import type { App } from '../app';
import { parseScene } from '../scene/parse';
import { emptyScene, type Scene } from '../scene/scene';
import { boundsOf } from '../view3d/bounds';
import { GrowingTrajectory } from '../view3d/growing_trajectory';
import { drawable } from '../view3d/materials';
import { buildRun, runColor } from '../view3d/run';
import { nearestFrame } from '../timeline/track';
import { TrajectoryLayer } from '../view3d/trajectory_layer';
import { mergedEvents } from './merged_rows';
import { isMapless } from '../ui/missing';
import type { LiveRecord } from './record';

/** Ranges of colors and the ground grid follow the growing run this often. */
const slowMs = 1000;
/** Where nobody moved the view, it keeps the newest pose inside this part of the picture. */
const inside = 0.9;

export class LiveMap {
  /** The map as the server sent it last, without what came since. */
  private served: Scene;
  private readonly trajectories: GrowingTrajectory[];
  private lastSlow = 0;
  private slowTimer = 0;
  private lastFit = 0;
  private mapSeen: boolean;
  private knownEvents = -1;

  constructor(private readonly app: App, private readonly index: number, private readonly record: LiveRecord) {
    const { scene } = app.runs[index];
    this.served = { ...scene };
    this.mapSeen = !isMapless(scene);
    this.trajectories = (['final', 'online'] as const).map((kind) => new GrowingTrajectory(kind, record, runColor(index)));
    // A drag must end with the view where it was left: from its first moment it is the person's.
    app.view.controls.addEventListener('start', () => app.rememberCamera());
    this.show(scene);
  }

  get hasMap(): boolean {
    return this.mapSeen;
  }

  /** Takes the bytes of a new map. Throws SceneError where they cannot be read; the map before stays. */
  replace(bytes: Uint8Array): void {
    this.show(parseScene(bytes));
  }

  /** Names of the run for as long as there is no map that has its own. */
  name(title: string, method: string): void {
    const { scene } = this.app.runs[this.index];
    if (this.mapSeen) return;
    Object.assign(scene, { title: title || scene.title, method });
    this.app.contentGrew();
  }

  /** After frames were added to the record. `follow`: the newest one becomes the current one. */
  grow(follow: boolean): void {
    const { app, record } = this;
    const { scene } = app.runs[this.index];
    const first = scene.frames === null && record.frames !== null;
    scene.frames = record.frames;
    scene.stateNames = record.stateNames;
    if (record.events.length !== this.knownEvents) this.joinEvents(scene);
    for (const trajectory of this.trajectories) trajectory.grow();
    const count = scene.frames?.count ?? 0;
    if (count === 0) return;
    if (first) app.beginAnew();
    this.keepInSight(count - 1);
    this.growSoon();
    app.framesGrew(follow ? count - 1 : Math.min(app.state.frame, count - 1));
  }

  /** Forgets the frames of a run that is over. */
  clear(): void {
    const { scene } = this.app.runs[this.index];
    Object.assign(scene, { frames: null, events: [] });
    this.served.events = [];
    for (const trajectory of this.trajectories) trajectory.grow();
    this.knownEvents = -1;
    this.app.framesGrew(0);
    this.app.forgetMeasured(this.index);
  }

  /** Shows the run as before its first map: the next one is another. */
  remove(): void {
    const { title, method, up, planar } = this.served;
    this.record.clear();
    this.show({ ...emptyScene(title), method, up, planar });
    this.mapSeen = false;
  }

  private show(served: Scene): void {
    const { app, record, index } = this;
    const stamp = app.runs[index].scene.frames?.stamps[app.state.frame];
    this.served = served;
    if (served.frames) record.merge(served.frames, served.stateNames);
    const scene: Scene = { ...served, frames: record.frames, stateNames: record.stateNames };
    this.joinEvents(scene);
    const truth = served.frames?.truth ? [new TrajectoryLayer('truth', served.frames, served.stateNames, runColor(index))] : [];
    for (const trajectory of this.trajectories) trajectory.grow();
    if (stamp !== undefined && scene.frames) app.state.frame = nearestFrame(scene.frames.stamps, stamp);
    app.replaceRun(buildRun(app.runs[index].name, scene, index, [...this.trajectories, ...truth]), this.trajectories);
    const first = !this.mapSeen && !isMapless(scene);
    if (!first) return;
    this.mapSeen = true;
    app.beginAnew();
    if (app.state.camera === null) app.fit();
  }

  private joinEvents(scene: Scene): void {
    this.knownEvents = this.record.events.length;
    scene.events = mergedEvents(this.record.events, this.served.events);
  }

  /** The last frames count too where none follow, as while the run is paused. */
  private growSoon(): void {
    const rest = this.lastSlow + slowMs - performance.now();
    if (rest <= 0) return this.growSlowly();
    if (this.slowTimer === 0) this.slowTimer = window.setTimeout(() => this.growSlowly(), rest);
  }

  private growSlowly(): void {
    clearTimeout(this.slowTimer);
    this.slowTimer = 0;
    if (!this.record.frames) return;
    const { app } = this;
    const before = app.view.bounds.getSize(new THREE.Vector3()).length();
    const box = boundsOf(app.runs.map((r) => ({ ...r.scene, layers: [] }))).union(app.view.bounds);
    if (box.getSize(new THREE.Vector3()).length() > 1.1 * before) app.measureContent();
    else app.growRanges();
    app.contentGrew();
    this.lastSlow = performance.now();
  }

  /** Only while the view shows "the whole content", that is as long as nobody moved it. */
  private keepInSight(row: number): void {
    const { app } = this;
    const { positions } = app.runs[this.index].scene.frames!;
    if (app.state.camera !== null || !drawable(positions, 3 * row) || performance.now() - this.lastFit < slowMs) return;
    const { camera, bounds } = app.view;
    const p = new THREE.Vector3().fromArray(positions, 3 * row);
    bounds.expandByPoint(p);
    camera.updateMatrixWorld();
    p.project(camera);
    if (Math.abs(p.x) < inside && Math.abs(p.y) < inside && p.z < 1) return;
    this.lastFit = performance.now();
    app.measureContent();
    app.fit();
  }
}
