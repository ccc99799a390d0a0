// SPDX-License-Identifier: Apache-2.0
// Entry of the page: finds the scenes, builds the view and the panels, offers the hook for tests.
import { App } from './app';
import { embeddedScenes, servedScenes, tokenQuery, type Loaded } from './scene/sources';
import { LiveSession } from './live/session';
import { SceneError, type Vec3 } from './scene/scene';
import { el } from './ui/dom';
import { buildLayout, showMessage } from './ui/layout';

interface Hook {
  ready: boolean;
  project: (point: Vec3) => [number, number] | null;
  stats: App['view']['stats'] | null;
  app: App | null;
  live: LiveSession | null;
}

const hook: Hook = { ready: false, project: () => null, stats: null, app: null, live: null };
Object.assign(window, { rastro: hook });

async function findScenes(): Promise<Loaded[]> {
  const embedded = embeddedScenes(document);
  if (embedded.length > 0 || location.protocol === 'file:') return embedded;
  return servedScenes(tokenQuery(location.search));
}

function open(loaded: Loaded[]): void {
  const root = document.getElementById('app')!;
  const canvas = el('canvas', { tabIndex: 0, role: 'img', aria: { label: '3D view of the map. Drag to turn, right drag to move, wheel to zoom.' } });
  const stage = el('main', { className: 'view' }, canvas);
  root.replaceChildren(stage);
  let app: App;
  try {
    app = new App(loaded, canvas);
  } catch (error) {
    // three.js throws where the browser offers no WebGL; nothing else here is expected to.
    console.error(error);
    return showMessage(root, 'This browser cannot draw in 3D: WebGL 2 is missing or switched off.');
  }
  const live = liveSession(app);
  buildLayout(root, app, stage, live);
  app.begin();
  live?.start();
  hook.live = live;
  hook.app = app;
  hook.stats = app.view.stats;
  hook.project = (point) => app.view.project(point);
  hook.ready = true;
}

/** A server has at most one run that goes on. */
function liveSession(app: App): LiveSession | null {
  return app.live ? new LiveSession(app, app.live, tokenQuery(location.search)) : null;
}

async function start(): Promise<void> {
  const root = document.getElementById('app')!;
  showMessage(root, 'Loading the map …');
  try {
    const loaded = await findScenes();
    if (loaded.length === 0) return showMessage(root, 'There is no map in this page. Make one with: rastro export --to html');
    open(loaded);
  } catch (error) {
    if (!(error instanceof SceneError)) console.error(error);
    showMessage(root, error instanceof SceneError ? error.message : 'The map could not be loaded: the server sent no readable answer.');
  }
}

void start();
