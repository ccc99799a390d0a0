// SPDX-License-Identifier: Apache-2.0
// Asks the program behind the page to measure between two edges or faces as `rastro measure` does: in the images of the map.
import type { Vec3 } from '../scene/scene';
import type { Feature, Span } from './feature';

export interface Answer {
  span: Span;
  note: string;
  /** Why it could not be measured; null where it could. */
  problem: string | null;
}

/** Null where the program cannot be asked this, or does not answer: the page's own measurement stays. */
export async function askServer(url: string, a: Feature, b: Feature): Promise<Answer | null> {
  if (a.kind === 'point' || a.kind !== b.kind) return null;
  const query = new URLSearchParams({ kind: a.kind === 'edge' ? 'edges' : 'planes', ...endOf('a', a), ...endOf('b', b) });
  try {
    const response = await fetch(`${url}${url.includes('?') ? '&' : '?'}${query}`);
    return response.ok ? answerOf(await response.json()) : null;
  } catch {
    return null;
  }
}

function endOf(name: string, feature: Feature): Record<string, string> {
  const text = (v: Vec3) => v.map((x) => x.toFixed(5)).join(',');
  const end = { [name]: text(feature.point), [`${name}_direction`]: text(feature.direction!) };
  return feature.face ? { ...end, [`${name}_face`]: text(feature.face) } : end;
}

function answerOf(json: unknown): Answer | null {
  const { length, sigma, a, b, note, problem } = (json ?? {}) as Record<string, unknown>;
  const span: Span = { a: [0, 0, 0], b: [0, 0, 0], length: 0, sigma: null };
  if (typeof problem === 'string') return { span, note: '', problem: problem.slice(0, 300) };
  const point = (v: unknown): v is Vec3 => Array.isArray(v) && v.length === 3 && v.every((x) => Number.isFinite(x));
  if (!Number.isFinite(length) || !Number.isFinite(sigma) || !point(a) || !point(b)) return null;
  return { span: { a, b, length: length as number, sigma: sigma as number }, note: typeof note === 'string' ? note.slice(0, 300) : '', problem: null };
}
