// SPDX-License-Identifier: Apache-2.0
// Puts the parts of the page together: bar at the top, panel at the side, view, timeline below.
import type { App } from '../app';
import { CurrentFrame } from '../timeline/current_frame';
import { FramePanel } from '../timeline/frame_panel';
import { Timeline } from '../timeline/timeline';
import { LengthList } from '../measure/length_list';
import { LengthMarks } from '../measure/length_marks';
import { Measure } from '../measure/measure';
import { FrameView } from '../live/frame_view';
import { RunBar } from '../live/run_bar';
import type { LiveSession } from '../live/session';
import { RecordingView } from '../recording/recording_view';
import { tokenQuery } from '../scene/sources';
import { el } from './dom';
import { Legend } from './legend';
import { isEmpty } from './missing';
import { bindShortcuts } from './shortcuts';
import { sidePanel, updateDetails } from './side_panel';
import { showTitle, toolbar } from './toolbar';
import { helpDialog } from './help';
import type { Actions, LiveActions } from './actions';
import { savePicture } from './picture';
import { Video } from './video';

export function showMessage(root: HTMLElement, text: string): void {
  root.replaceChildren(el('p', { className: 'message', role: 'status' }, text));
}

export function buildLayout(root: HTMLElement, app: App, stage: HTMLElement, live: LiveSession | null): void {
  const side = el('aside', { id: 'side', aria: { label: 'Layers and colors' } }, ...sidePanel(app));
  const legend = new Legend(app);
  const timeline = new Timeline(app);
  const current = new CurrentFrame(app);
  const frame = new FramePanel(app, current);
  const liveParts = live && livePartsOf(app, live);
  const recording = app.recordings.size && !live ? new RecordingView(app, app.recordings, tokenQuery(location.search)) : null;
  // The frame view says more of the current frame than the panel.
  if (live || recording) frame.element.open = false;
  const measure = new Measure(app);
  const marks = new LengthMarks(app, measure);
  const lengths = new LengthList(app, measure);
  const right = el('div', { className: 'right' }, frame.element, lengths.element);
  stage.append(marks.labels, legend.element, right, measure.hint, ...notices(app));
  const video = new Video(app, timeline.player);
  const help = helpDialog(live !== null);
  const actions = { ...buildActions(app, root, { help, timeline, current, measure, video }), live: liveParts?.actions ?? null };
  const bar = toolbar(app, actions);
  root.replaceChildren(bar, side, stage, ...(liveParts ? [liveParts.view.element, liveParts.bar.element] : []), ...(recording ? [recording.element] : []), timeline.element, help, video.dialog);
  bindShortcuts(app, actions);
  app.view.onDrawn = () => {
    legend.update();
    marks.update();
  };
  const press = (tool: string, on: boolean) => bar.querySelector(`[data-tool="${tool}"]`)!.setAttribute('aria-pressed', `${on}`);
  measure.onChange(() => press('measure', measure.active));
  video.onSwitch(() => press('video', video.isOn));
  keepUpToDate(app, side, bar);
}

function livePartsOf(app: App, session: LiveSession) {
  const bar = new RunBar(session);
  const view = new FrameView(app, session);
  const actions: LiveActions = {
    press: (name) => void bar.controls.press(name), toggleFrameView: () => view.toggle(), follow: () => session.follow(),
  };
  return { bar, view, actions };
}

function keepUpToDate(app: App, side: HTMLElement, bar: HTMLElement): void {
  window.addEventListener('hashchange', () => app.readHash());
  document.title = `${titleOf(app)} · rastro view`;
  app.onChange((changed) => {
    // The theme also changes with the unit of lengths, see Measure.setKnown.
    if (changed.has('active') || changed.has('theme')) side.replaceChildren(...sidePanel(app));
    else if (changed.has('layers')) showSwitches(app, side);
    if (changed.has('scene')) showScene(app, side, bar);
  });
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => app.refresh());
}

export function titleOf(app: App): string {
  return app.runs.map((r) => r.scene.title || r.name).join(' + ') || 'no map';
}

function notices(app: App): HTMLElement[] {
  const errors = app.errors.map((e) => el('p', { className: 'notice error', role: 'alert' }, `${e.name} cannot be shown: ${e.message}.`));
  const empty = app.runs.filter((r) => isEmpty(r.scene) && !r.live).map((r) => el('p', { className: 'notice', role: 'status' }, `${r.scene.title || r.name} is empty: it has no trajectory, no keyframes and no points.`));
  return errors.length + empty.length ? [el('div', { className: 'notices' }, ...errors, ...empty)] : [];
}

/** Another map of a run: what did not change stays, so that a slider or a list in use is not lost. */
function showScene(app: App, side: HTMLElement, bar: HTMLElement): void {
  document.title = `${titleOf(app)} · rastro view`;
  showTitle(app, bar);
  if (!updateDetails(app, side)) side.replaceChildren(...sidePanel(app));
}

/** Layers can be switched by keys as well: the boxes follow. */
function showSwitches(app: App, side: HTMLElement): void {
  for (const box of side.querySelectorAll<HTMLElement>('[data-layer]')) {
    const key = box.dataset.layer!;
    box.querySelector('input')!.checked = key === 'reference' ? app.state.layers[key] ?? true : app.layerShown(key);
  }
}

interface Parts {
  help: HTMLDialogElement;
  timeline: Timeline;
  current: CurrentFrame;
  measure: Measure;
  video: Video;
}

function buildActions(app: App, root: HTMLElement, { help, timeline, current, measure, video }: Parts): Omit<Actions, 'live'> {
  return {
    fit: () => app.fit(),
    fromAbove: () => {
      app.view.fitFromAbove();
      app.rememberCamera();
    },
    toggleSide: () => root.classList.toggle('side-toggled'),
    toggleTheme: () => app.set({ theme: app.dark ? 'light' : 'dark' }),
    measure: () => measure.toggle(),
    measureKind: () => measure.nextKind(),
    escape: () => measure.escape(),
    savePicture: () => savePicture(app),
    video: () => video.ask(),
    help: () => (help.open ? help.close() : help.showModal()),
    play: () => timeline.player.toggle(),
    step: (frames) => timeline.step(frames),
    toEvent: (direction) => timeline.toEvent(direction),
    lookFromFrame: () => current.look(),
    follow: () => current.setFollow(!current.follow),
    toggleLayer: (key) => app.setLayer(key, !app.layerShown(key)),
  };
}
