// SPDX-License-Identifier: Apache-2.0
// The panel at the side: runs, layers, colors, sizes.
import type { App } from '../app';
import { modesOf } from '../view3d/trajectory_layer';
import { PointsLayer } from '../view3d/points_layer';
import type { PointColor, TrajectoryColor } from '../view3d/style';
import { checkbox, el, section, select, slider, type Choice } from './dom';
import { missingParts } from './missing';
import { lengthText } from './units';

export function sidePanel(app: App): HTMLElement[] {
  const parts = [runsSection(app), layersSection(app), trajectorySection(app), pointsSection(app), sizesSection(app)];
  return parts.filter((p): p is HTMLElement => p !== null);
}

/** Writes the new counts of layers into the panel; false where the panel needs other parts than it has. */
export function updateDetails(app: App, side: HTMLElement): boolean {
  const fresh = el('div', {}, ...sidePanel(app));
  const shape = (root: HTMLElement) => [...root.querySelectorAll<HTMLElement>('[data-layer], section, option, .missing')]
    .map((e) => `${e.dataset.layer ?? ''}${e.tagName === 'OPTION' ? `${e.textContent}${(e as HTMLOptionElement).disabled}` : e.tagName === 'P' ? e.textContent : e.getAttribute('aria-label')}`).join();
  if (shape(fresh) !== shape(side)) return false;
  const details = side.querySelectorAll('[data-layer] .detail');
  fresh.querySelectorAll('[data-layer] .detail').forEach((detail, i) => (details[i].textContent = detail.textContent));
  return true;
}

function runsSection(app: App): HTMLElement | null {
  if (app.runs.length < 2) return null;
  const rows = app.runs.map((run) => {
    const box = checkbox(run.name, run.scene.method, !app.state.hiddenRuns.includes(run.index), (on) => app.setRun(run.index, on));
    box.querySelector('input')!.after(el('span', { className: 'swatch', style: `background:${run.color}` }));
    return box;
  });
  const choices = app.runs.map((run) => ({ value: `${run.index}`, label: run.name }));
  const timeline = select('Timeline of', choices, `${app.state.active}`, (value) => app.set({ active: Number(value), frame: 0 }));
  return section('Runs', ...rows, timeline);
}

function layersSection(app: App): HTMLElement {
  const rows = new Map<string, { label: string; details: string[] }>();
  for (const layer of app.runs.flatMap((r) => r.layers)) {
    const row = rows.get(layer.key) ?? { label: layer.label, details: [] };
    row.details.push(layer.detail);
    rows.set(layer.key, row);
  }
  const boxes = [...rows].map(([key, row]) => layerBox(app, key, row.label, row.details.length > 1 ? `${row.details.length} runs` : row.details[0]));
  const reference = layerBox(app, 'reference', 'Reference grid', `cell ${lengthText(app, app.view.reference.cell, null)}`);
  const missing = missingParts(app.runs.map((r) => r.scene), app.live !== null).map((text) => el('p', { className: 'missing' }, text));
  return section('Layers', ...boxes, reference, ...missing);
}

function layerBox(app: App, key: string, label: string, detail: string): HTMLElement {
  const shown = key === 'reference' ? app.state.layers[key] ?? true : app.layerShown(key);
  const box = checkbox(label, detail, shown, (on) => app.setLayer(key, on));
  box.dataset.layer = key;
  return box;
}

const trajectoryLabels: Record<TrajectoryColor, string> = {
  state: 'State of tracking',
  error: 'Error',
  sigma: 'Position sigma',
  time: 'Time',
  run: 'One color a run',
};

function trajectorySection(app: App): HTMLElement | null {
  const frames = app.runs.map((r) => r.scene.frames).filter((f) => f !== null);
  if (frames.length === 0) return null;
  const known = new Set(frames.flatMap((f) => [...modesOf(f)]));
  const choices = choicesOf(trajectoryLabels, known);
  return section('Trajectory', select('Color', choices, app.state.trajectoryColor, (trajectoryColor) => app.set({ trajectoryColor })));
}

const pointLabels: Record<PointColor, string> = {
  image: 'Image color',
  height: 'Height',
  age: 'Age',
  uncertainty: 'Uncertainty',
  run: 'One color a run',
};

function pointsSection(app: App): HTMLElement | null {
  const layers = app.runs.flatMap((r) => r.layers);
  const points = layers.filter((l) => l instanceof PointsLayer);
  const surfaces = app.runs.some((r) => r.scene.layers.some((l) => l.kind === 'mesh' || l.kind === 'cubes'));
  if (points.length === 0 && !surfaces) return null;
  const known = new Set<PointColor>(['height', 'run', ...points.flatMap((p) => [...p.modes])]);
  if (app.runs.some((r) => r.scene.layers.some((l) => 'colors' in l && l.colors !== null))) known.add('image');
  const color = select('Color', choicesOf(pointLabels, known), app.state.pointColor, (pointColor) => app.set({ pointColor }));
  const map = select('Color map', [{ value: 'viridis', label: 'Viridis' }, { value: 'cividis', label: 'Cividis' }], app.state.map, (m) => app.set({ map: m as 'viridis' | 'cividis' }));
  const size = slider({
    label: 'Point size', min: 1, max: 10, step: 0.5, value: app.state.pointSize,
    format: (v) => `${v} px`, oninput: (pointSize) => app.set({ pointSize }),
  });
  return section('Points and surfaces', color, map, ...(points.length ? [size, ...sigmaFilter(app)] : []));
}

function choicesOf<T extends string>(labels: Record<T, string>, known: Set<T>): Choice<T>[] {
  return (Object.keys(labels) as T[]).map((value) => ({
    value, label: known.has(value) ? labels[value] : `${labels[value]} (not in this map)`, disabled: !known.has(value),
  }));
}

/** The slider runs over powers of ten: sigmas of one map often differ a thousandfold. */
function sigmaFilter(app: App): HTMLElement[] {
  const range = app.style.ranges.uncertainty;
  if (!range) return [];
  const high = Math.log10(Math.max(range[1], 1e-9) * 3);
  const low = Math.min(high - 1, Math.log10(Math.max(range[0], range[1] * 1e-4, 1e-9)));
  const all = high + 0.01;
  const format = (v: number) => (v >= high ? 'all' : `≤ ${lengthText(app, 10 ** v, null)}`);
  const value = Number.isFinite(app.state.maxSigma) ? Math.log10(app.state.maxSigma) : all;
  return [slider({
    label: 'Largest sigma', min: low, max: all, step: 0.01, value, format,
    oninput: (v) => app.set({ maxSigma: v >= high ? Infinity : 10 ** v }),
  })];
}

function sizesSection(app: App): HTMLElement | null {
  const parts: HTMLElement[] = [];
  if (app.runs.some((r) => r.scene.keyframes || r.scene.frames)) {
    const begin = Math.max(app.initial.cameraSize, 1e-9);
    parts.push(slider({
      label: 'Camera size', min: -1.5, max: 1.5, step: 0.05, value: Math.log2(Math.max(app.state.cameraSize, 1e-9) / begin) / 2,
      format: (v) => lengthText(app, begin * 4 ** v, null), oninput: (v) => app.set({ cameraSize: begin * 4 ** v }),
    }));
  }
  if (app.runs.some((r) => r.scene.layers.some((l) => l.kind === 'ellipsoids'))) {
    parts.push(slider({
      label: 'Ellipsoids', min: 0, max: 2, step: 0.02, value: Math.log10(app.state.ellipsoidScale),
      format: (v) => `${Math.round(10 ** v)} sigma`, oninput: (v) => app.set({ ellipsoidScale: Math.round(10 ** v) }),
    }));
  }
  return parts.length ? section('Sizes', ...parts) : null;
}
