// SPDX-License-Identifier: Apache-2.0
// The 3D view. It draws only when something changed. Points come in slices: the first slice with everything else,
// the rest in the pictures after it without clearing, so that the view stays quick with millions of points.
import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import type { Vec3 } from '../scene/scene';
import { Budget, isSoftware } from './budget';
import { classes, PointsLayer } from './points_layer';
import { Reference } from './reference';
import type { Run } from './run';
import { pointsMask, type Style } from './style';
import { viewOf } from './tile_choice';
import { TiledPoints } from './tiled_points';
import { fitDistance, horizontal, nearFar, offCenter } from './viewpoint';

/** The view has to rest this long before points that are missing are added: they would hold up the next movement. */
const pauseMs = 80;
/** Points of a tile that lie nearer than this on the screen are fine enough. */
const enoughPx = 1.5;

export interface Stats {
  /** Points drawn so far since the view last moved. */
  pointsDrawn: number;
  pointsVisible: number;
  frameMs: number;
  /** Tiles of points that the view needs and that are on their way. */
  tilesWaiting: number;
  /** Pictures drawn so far; at rest none is added. */
  pictures: number;
  firstPictureMs: number | null;
  completePictureMs: number | null;
}

export class View3d {
  readonly camera = new THREE.PerspectiveCamera(40, 1, 0.01, 1000);
  readonly content = new THREE.Scene();
  /** Marks of the page itself (current frame, measured lengths); drawn last, over each slice. */
  readonly marks = new THREE.Scene();
  readonly controls: OrbitControls;
  reference: Reference;
  readonly stats: Stats = { pointsDrawn: 0, pointsVisible: 0, frameMs: 0, tilesWaiting: 0, pictures: 0, firstPictureMs: null, completePictureMs: null };
  /** Called after each picture, for what is laid over the view. */
  onDrawn: () => void = () => {};
  private readonly renderer: THREE.WebGLRenderer;
  private readonly budget: Budget;
  private points: PointsLayer[] = [];
  /** Classes of points in the picture, of all `classes`. */
  private drawnClasses = classes;
  private requested = false;
  private changed = true;
  private lastTime = 0;
  private lastChange = -Infinity;
  private drawnInRow = 0;

  constructor(readonly canvas: HTMLCanvasElement, private up: Vec3, public bounds: THREE.Box3, private outline: THREE.Vector3[]) {
    const software = isSoftware();
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !software, preserveDrawingBuffer: true });
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    this.renderer.autoClear = false;
    this.budget = new Budget(software);
    this.camera.up.set(...up);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener('change', () => this.requestDraw());
    this.controls.screenSpacePanning = true;
    this.controls.zoomToCursor = true;
    this.reference = new Reference(bounds, outline, up);
    this.content.add(this.reference.object);
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement!);
    canvas.addEventListener('webglcontextrestored', () => location.reload());
    this.resize();
  }

  add(run: Run): void {
    this.content.add(run.group);
    for (const layer of run.layers) {
      if (layer instanceof PointsLayer) this.points.push(layer);
      if (layer instanceof TiledPoints) layer.onArrival = () => this.schedule();
    }
  }

  remove(run: Run): void {
    this.content.remove(run.group);
    this.points = this.points.filter((layer) => !run.layers.includes(layer));
  }

  /** Where the content lies by now. The view stays where it is. */
  setContent(bounds: THREE.Box3, outline: THREE.Vector3[], up: Vec3): void {
    this.content.remove(this.reference.object);
    this.reference.dispose();
    if (up.join() !== this.up.join()) this.turnUp(up);
    Object.assign(this, { bounds, outline, reference: new Reference(bounds, outline, up) });
    this.content.add(this.reference.object);
    this.requestDraw();
  }

  /** three.js reads the camera's "up" only once; these two are its own words for it. */
  private turnUp(up: Vec3): void {
    this.up = up;
    this.camera.up.set(...up);
    const turn = new THREE.Quaternion().setFromUnitVectors(this.camera.up, new THREE.Vector3(0, 1, 0));
    Object.assign(this.controls, { _quat: turn, _quatInverse: turn.clone().invert() });
    this.controls.update();
  }

  applyStyle(style: Style): void {
    this.renderer.setClearColor(style.dark ? '#14181d' : '#ffffff');
    this.reference.applyStyle(style);
    this.requestDraw();
  }

  requestDraw(): void {
    this.changed = true;
    this.schedule();
  }

  /** Whole content, seen from a little above. */
  fit(): void {
    const up = new THREE.Vector3(...this.up);
    const [right, ahead] = horizontal(up);
    this.look(up.multiplyScalar(0.55).addScaledVector(ahead, -1).addScaledVector(right, -0.45));
  }

  fitFromAbove(): void {
    const up = new THREE.Vector3(...this.up);
    // The small share keeps "ahead" at the top of the picture.
    this.look(up.addScaledVector(horizontal(up)[1], -1e-4));
  }

  private look(direction: THREE.Vector3): void {
    const center = this.bounds.getCenter(new THREE.Vector3());
    const distance = fitDistance(this.outline, center, direction.normalize(), this.camera, this.up);
    this.controls.target.copy(center);
    this.camera.position.copy(center).addScaledVector(direction, distance);
    this.controls.update();
    for (let i = 0; i < 4; i++) this.center();
    this.controls.update();
    this.requestDraw();
  }

  /** Perspective makes the near side larger than the far one: moves the box to the middle and to the picture's size. */
  private center(): void {
    const { camera, controls } = this;
    const { x, y, size } = offCenter(this.outline, camera);
    const distance = camera.position.distanceTo(controls.target);
    const half = distance * Math.tan(THREE.MathUtils.degToRad(camera.fov / 2));
    const move = new THREE.Vector3(x * half * camera.aspect, y * half, 0).applyQuaternion(camera.quaternion);
    controls.target.add(move);
    camera.position.add(move);
    const back = camera.position.clone().sub(controls.target).multiplyScalar(Math.min(2, Math.max(0.5, size / 0.86)));
    camera.position.copy(controls.target).add(back);
  }

  /** The view that a camera at this pose has. */
  lookFrom(position: THREE.Vector3, ahead: THREE.Vector3): void {
    this.camera.position.copy(position);
    this.controls.target.copy(position).add(ahead);
    this.controls.update();
    this.requestDraw();
  }

  /** Pixel of the page (x right, y down) where a point of the world is drawn; null behind the camera. */
  project(point: Vec3): [number, number] | null {
    this.camera.updateMatrixWorld();
    const p = new THREE.Vector3(...point).applyMatrix4(this.camera.matrixWorldInverse);
    if (p.z >= 0) return null;
    p.applyMatrix4(this.camera.projectionMatrix);
    const box = this.canvas.getBoundingClientRect();
    return [box.left + ((p.x + 1) / 2) * box.width, box.top + ((1 - p.y) / 2) * box.height];
  }

  /** World to clip coordinates, and the size of the view in pixels. */
  projection(): { matrix: THREE.Matrix4; width: number; height: number } {
    this.camera.updateMatrixWorld();
    const matrix = this.camera.projectionMatrix.clone().multiply(this.camera.matrixWorldInverse);
    return { matrix, width: this.canvas.clientWidth, height: this.canvas.clientHeight };
  }

  /** Draws all that is missing at once, for a picture to save. */
  drawAll(): void {
    this.drawSlice(0, classes, true);
  }

  pixelRatio(): number {
    return this.renderer.getPixelRatio();
  }

  resize(): void {
    const parent = this.canvas.parentElement!;
    const [width, height] = [Math.max(1, parent.clientWidth), Math.max(1, parent.clientHeight)];
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.requestDraw();
  }

  private schedule(): void {
    if (this.requested) return;
    this.requested = true;
    requestAnimationFrame((time) => this.step(time));
  }

  private step(time: number): void {
    this.requested = false;
    const interval = time - this.lastTime;
    this.lastTime = time;
    const total = this.visiblePoints();
    const slice = total === 0 ? classes : Math.floor((this.budget.points / total) * classes);
    // Only pictures in a row tell how long one takes.
    if (this.drawnInRow >= 2) this.budget.learn((this.stats.frameMs = interval));
    if (this.changed) {
      this.changed = false;
      this.lastChange = time;
      this.drawSlice(0, Math.min(classes, slice), true);
      this.drawnInRow++;
    } else if (this.drawnClasses < classes && time - this.lastChange >= pauseMs) {
      this.drawSlice(this.drawnClasses, Math.min(classes, this.drawnClasses + Math.max(1, slice)), false);
      this.drawnInRow++;
    } else {
      this.drawnInRow = 0;
      if (this.drawnClasses === classes) return this.drawArrivals();
    }
    this.schedule();
  }

  /** Tiles that came after the picture was whole, over it; those that come later ask again. */
  private drawArrivals(): void {
    const tiled = this.tiledPoints();
    for (const layer of this.points) layer.setSlice(classes, classes, false);
    if (tiled.map((layer) => layer.showFresh()).includes(true)) this.render(false);
    this.visiblePoints();
    this.note(1);
  }

  private tiledPoints(): TiledPoints[] {
    return this.shownPoints().filter((layer) => layer instanceof TiledPoints);
  }

  private shownPoints(): PointsLayer[] {
    return this.points.filter((p) => p.object.visible && p.object.parent?.visible);
  }

  private visiblePoints(): number {
    this.stats.pointsVisible = this.shownPoints().reduce((sum, p) => sum + p.shownCount, 0);
    return this.stats.pointsVisible;
  }

  private drawSlice(from: number, to: number, first: boolean): void {
    if (first) this.begin();
    for (const layer of this.points) layer.setSlice(from, to, first);
    this.render(first);
    this.drawnClasses = to;
    this.note(to / classes);
  }

  /** A picture from where the eye is now. */
  private begin(): void {
    const { near, far } = nearFar(this.bounds, this.camera.position, this.controls.target);
    Object.assign(this.camera, { near, far });
    this.camera.updateProjectionMatrix();
    const ratio = this.pixelRatio();
    const view = viewOf(this.camera, this.canvas.clientHeight * ratio, enoughPx * ratio, this.budget.whole);
    for (const layer of this.tiledPoints()) layer.look(view);
    this.renderer.clear();
  }

  private render(whole: boolean): void {
    if (!whole) this.camera.layers.set(pointsMask);
    this.renderer.render(this.content, this.camera);
    this.camera.layers.enableAll();
    this.renderer.render(this.marks, this.camera);
    this.stats.pictures++;
    this.onDrawn();
  }

  private note(share: number): void {
    this.stats.pointsDrawn = share > 0 ? Math.round(share * this.stats.pointsVisible) : this.shownPoints().reduce((sum, p) => sum + p.previewCount, 0);
    this.stats.tilesWaiting = this.tiledPoints().reduce((sum, layer) => sum + layer.waiting, 0);
    const complete = share === 1 && this.stats.tilesWaiting === 0;
    if (this.stats.firstPictureMs !== null && !(complete && this.stats.completePictureMs === null)) return;
    // Reading a pixel waits for the graphics card: the times are those of real pictures.
    const gl = this.renderer.getContext();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    this.stats.firstPictureMs ??= performance.now();
    if (complete) this.stats.completePictureMs ??= performance.now();
  }
}
