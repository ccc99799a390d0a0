// SPDX-License-Identifier: Apache-2.0
// The file that --mcap writes while a run goes on, read by MCAP's own reader: its counts are those of the run. Needs the
// program: only where RASTRO_PROGRAM names it.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { before, test } from 'node:test';
import { McapIndexedReader, McapStreamReader } from '@mcap/core';
import { rastro, scratchFolder, skip } from './program_testing';

const folder = scratchFolder('mcap');

before(() => {
  if (skip) return;
  rastro(folder, 'simulate', 'hall', '--out', 'hall', '--frames', '50', '--no-ground-truth', '--quiet');
  rastro(folder, 'simulate', 'study', '--out', 'study', '--frames', '60', '--every', '2', '--quiet');
  rastro(folder, 'simulate', 'corridor', '--out', 'corridor', '--frames', '150', '--quiet');
});

/** Messages by topic, from front to back, as far as the file goes. */
function streamed(bytes: Uint8Array): Map<string, number> {
  const reader = new McapStreamReader({ validateCrcs: true });
  const topics = new Map<number, string>();
  const counts = new Map<string, number>();
  reader.append(bytes);
  for (let record = reader.nextRecord(); record; record = reader.nextRecord()) {
    if (record.type === 'Channel') topics.set(record.id, record.topic);
    if (record.type !== 'Message') continue;
    const topic = topics.get(record.channelId)!;
    counts.set(topic, (counts.get(topic) ?? 0) + 1);
  }
  return counts;
}

async function indexed(bytes: Uint8Array): Promise<number> {
  const readable = { size: async () => BigInt(bytes.length), read: async (offset: bigint, size: bigint) => bytes.subarray(Number(offset), Number(offset + size)) };
  const reader = await McapIndexedReader.Initialize({ readable });
  let count = 0;
  for await (const message of reader.readMessages()) count += message.type === 'Message' ? 1 : 0;
  return count;
}

const linesOf = (file: string) => readFileSync(`${folder}/${file}`, 'utf8').split('\n').filter((line) => line !== '' && !line.startsWith('#'));

interface RunEvent {
  frame: number;
  event: string;
}

const cases: Record<string, { command: string; world: string }> = {
  orb: { command: 'slam', world: 'hall' }, lsd: { command: 'slam', world: 'hall' }, rgbd: { command: 'slam', world: 'study' }, rtabmap: { command: 'slam', world: 'study' },
  hector: { command: 'slam', world: 'corridor' }, ekf: { command: 'slam', world: 'corridor' }, features: { command: 'odometry', world: 'hall' },
  fusion: { command: 'slam', world: 'study' }, hybrid: { command: 'odometry', world: 'hall' }, classic: { command: 'odometry', world: 'hall' }, profiles: { command: 'odometry', world: 'hall' },
};

for (const [method, { command, world }] of Object.entries(cases)) {
  test(`--mcap of ${method}: the reader counts what the run did`, { skip }, async () => {
    rastro(folder, command, world, '--method', method, '--out', method, '--mcap', `${method}.mcap`, '--quiet');
    const bytes = readFileSync(`${folder}/${method}.mcap`);
    const counts = streamed(bytes);
    const events = linesOf(`${method}/events.jsonl`).map((line) => JSON.parse(line) as RunEvent);
    assert.equal(counts.get('/pose'), linesOf(`${method}/trajectory_online.txt`).length);
    assert.equal(counts.get('/tf'), counts.get('/pose'));
    const keyframes = events.filter((e) => e.event === 'keyframe').length;
    assert.equal(counts.get('/camera/image') ?? 0, command === 'slam' && world !== 'corridor' ? keyframes : 0);
    // What a method completes after the last frame is no event of a frame.
    const last = Math.max(...events.map((e) => e.frame));
    const late = events.filter((e) => e.frame === last).length;
    const log = counts.get('/log') ?? 0;
    assert.ok(log <= events.length && log >= events.length - late, `${log} of ${events.length}`);
    assert.equal(counts.get('/trajectory'), 1);
    assert.equal(await indexed(bytes), [...counts.values()].reduce((sum, n) => sum + n));
    const cut = streamed(bytes.subarray(0, Math.floor(0.7 * bytes.length)));
    assert.ok((cut.get('/pose') ?? 0) <= counts.get('/pose')! && [...cut.values()].length > 0, 'a file that was cut off is read up to there');
  });
}
