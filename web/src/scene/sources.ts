// SPDX-License-Identifier: Apache-2.0
// Where scenes come from: embedded in the page, or served by `rastro view`.
import { parseScene } from './parse';
import { emptyScene, SceneError, type Scene } from './scene';

export interface Loaded {
  name: string;
  /** Exactly one of the two is set. */
  scene: Scene | null;
  error: string | null;
  /** A run goes on: the scene is what its map is so far. */
  live?: boolean;
  /** A recording, whose frames the server gives one by one. */
  recording?: boolean;
  /** Number of the scene on the server. */
  index?: number;
  /** Where the server measures in the map of the scene. */
  measureUrl?: string;
}

export function decodeBase64(text: string): Uint8Array {
  const native = (Uint8Array as unknown as { fromBase64?: (text: string) => Uint8Array }).fromBase64;
  try {
    if (native) return native.call(Uint8Array, text);
    const binary = atob(text.replace(/\s+/g, ''));
    const bytes = new Uint8Array(binary.length);
    for (let i = 0; i < binary.length; i++) bytes[i] = binary.charCodeAt(i);
    return bytes;
  } catch {
    throw new SceneError('the scene in the page is not readable base64');
  }
}

function load(name: string, bytes: () => Uint8Array): Loaded {
  try {
    return { name, scene: parseScene(bytes()), error: null };
  } catch (error) {
    if (!(error instanceof SceneError)) throw error;
    return { name, scene: null, error: error.message };
  }
}

export function embeddedScenes(page: Document): Loaded[] {
  const scripts = [...page.querySelectorAll<HTMLScriptElement>('script.rastro-scene')];
  return scripts.map((script, i) => {
    const loaded = load(script.dataset.name || `scene ${i + 1}`, () => decodeBase64(script.textContent ?? ''));
    script.remove(); // the text is as large as the scene; let it go
    return loaded;
  });
}

/** Scenes of the server this page came from; `query` carries the token. */
export async function servedScenes(query: string): Promise<Loaded[]> {
  const list: unknown = await (await get(`/api/scenes${query}`)).json();
  if (!Array.isArray(list)) throw new SceneError('the server sent no list of scenes');
  return Promise.all(list.map((entry, i) => servedScene(entry, i, query)));
}

async function servedScene(entry: unknown, i: number, query: string): Promise<Loaded> {
  const loaded = await fetchedScene(entry, i, query);
  if ((entry as { measures?: unknown } | null)?.measures === true) loaded.measureUrl = `/api/measure/${loaded.index ?? i}${query}`;
  return loaded;
}

async function fetchedScene(entry: unknown, i: number, query: string): Promise<Loaded> {
  const { index, name, live, frames } = (entry ?? {}) as { index?: unknown; name?: unknown; live?: unknown; frames?: unknown };
  const label = typeof name === 'string' && name !== '' ? name : `scene ${i + 1}`;
  const number = Number.isInteger(index) ? (index as number) : i;
  try {
    const response = await get(`/api/scene/${number}${query}`, live === true);
    if (response.status === 404) return { name: label, scene: emptyScene(label), error: null, live: true, index: number };
    const buffer = await response.arrayBuffer();
    const loaded = load(label, () => new Uint8Array(buffer));
    for (const layer of loaded.scene?.layers ?? []) if (layer.kind === 'points' && layer.tiles) layer.tiles.url = tileUrl(number, layer.tiles.layer, query);
    return { ...loaded, live: live === true, recording: frames === true, index: number };
  } catch (error) {
    if (!(error instanceof SceneError)) throw error;
    return { name: label, scene: null, error: error.message };
  }
}

function tileUrl(scene: number, layer: number, query: string): (row: number) => string {
  return (row) => `/api/tile/${scene}/${layer}/${row}${query}`;
}

/** `early`: a run has no map yet at its begin, which is no fault. */
async function get(path: string, early = false): Promise<Response> {
  let response: Response;
  try {
    response = await fetch(path);
  } catch {
    throw new SceneError('the server of rastro view does not answer; is it still running?');
  }
  if (response.status === 401 || response.status === 403) {
    throw new SceneError('the server refused the token; open the address that rastro view printed');
  }
  if (!response.ok && !(early && response.status === 404)) throw new SceneError(`the server answered ${response.status} for ${path.split('?')[0]}`);
  return response;
}

/** Only the token is passed on, nothing else of the address. */
export function tokenQuery(search: string): string {
  const token = new URLSearchParams(search).get('token');
  return token === null ? '' : `?token=${encodeURIComponent(token)}`;
}
