// SPDX-License-Identifier: Apache-2.0
// Colors that mean something can be told apart by people with and without all kinds of cones.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { featureStyle } from '../src/live/feature_style';
import { runColors, stateColor } from '../src/view3d/colors';
import { closest, difference, type Vision } from './color_vision';

const least = 11; // CIEDE2000

test('the difference of two colors is CIEDE2000, and who has no green cones does not tell red from green', () => {
  // Sharma, Wu and Dalal 2005, pairs 1, 4 and 9 of their table.
  assert.ok(Math.abs(difference([50, 2.6772, -79.7751], [50, 0, -82.7485]) - 2.0425) < 1e-4);
  assert.ok(Math.abs(difference([50, -1.3802, -84.2814], [50, 0, -82.7485]) - 1) < 1e-4);
  assert.ok(Math.abs(difference([50, 2.49, -0.001], [50, -2.49, 0.0011]) - 7.2195) < 1e-4);
  const pair = { red: '#c83c14', green: '#6e7814' };
  assert.ok(closest(pair, 'normal').difference > 30 && closest(pair, 'deuteranopia').difference < 12);
});

const styled = (names: string[]) => Object.fromEntries(names.map((name, i) => [name, featureStyle(name, i).color]));
const sets: Record<string, Record<string, string>> = {
  states: Object.fromEntries(['tracking', 'weak', 'lost', 'relocalized', 'initializing'].map((name) => [name, stateColor(name)])),
  boards: Object.fromEntries(['taken', 'moving', 'nothing_new', 'one_camera', 'no_board'].map((name) => [name, stateColor(name)])),
  runs: Object.fromEntries(runColors.map((color, i) => [`run ${i + 1}`, color])),
  features: styled(['unmatched', 'matched', 'outlier', 'inlier', 'new', 're_identified']),
  corners: styled(['corner', 'taken']),
  words: styled(['known_word', 'new_word', 'repeated_word', 'previous_word', 'shared_word']),
};
const visions: Vision[] = ['normal', 'deuteranopia', 'protanopia', 'tritanopia'];

for (const [kind, colors] of Object.entries(sets)) {
  test(`${kind} can be told apart with any kind of color vision`, (t) => {
    for (const vision of visions) {
      const { pair, difference } = closest(colors, vision);
      t.diagnostic(`${kind}, ${vision}: ${pair} are nearest, ${difference.toFixed(1)}`);
      assert.ok(difference >= least, `${vision}: ${pair} differ by ${difference.toFixed(1)}`);
    }
  });
}
