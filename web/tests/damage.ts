// SPDX-License-Identifier: Apache-2.0
/** One random damage: a changed byte, a cut, a changed number or word of the header. */
export function damaged(bytes: Uint8Array, rnd: () => number): Uint8Array {
  const copy = bytes.slice();
  const header = new DataView(copy.buffer).getUint32(0, true);
  const kind = Math.floor(rnd() * 5);
  if (kind === 0) return copy.subarray(0, Math.floor(rnd() * copy.length));
  if (kind === 1) copy[Math.floor(rnd() * 12)] = 256 * rnd();
  if (kind === 2) for (let i = 0; i < 20; i++) copy[4 + header + Math.floor(rnd() * (copy.length - 4 - header))] = 256 * rnd();
  if (kind >= 3) {
    const text = new TextDecoder().decode(copy.subarray(4, 4 + header));
    const words = ['-1', '1e999', '99999999999', 'null', '"x"', '[]', '{}', '0.5', 'true', '""', '4294967295'];
    const values = [...text.matchAll(/:(-?[\d.]+|"[^"]*"|\[\]|\{\}|true|false)/g)];
    const hit = values[Math.floor(rnd() * values.length)];
    const word = words[Math.floor(rnd() * words.length)];
    const changed = new TextEncoder().encode(`${text.slice(0, hit.index + 1)}${word}${text.slice(hit.index + hit[0].length)}`);
    const length = Math.ceil((changed.length + 4) / 8) * 8 - 4;
    const result = new Uint8Array(4 + length + copy.length - 4 - header).fill(32, 4, 4 + length);
    new DataView(result.buffer).setUint32(0, length, true);
    result.set(changed, 4);
    result.set(copy.subarray(4 + header), 4 + length);
    return result;
  }
  return copy;
}

/** One random damage of a text message: a cut, changed characters, a changed value. */
export function damagedText(text: string, rnd: () => number): string {
  const kind = Math.floor(rnd() * 4);
  const at = Math.floor(rnd() * text.length);
  if (kind === 0) return text.slice(0, at);
  if (kind === 1) return text.slice(0, at) + String.fromCharCode(Math.floor(rnd() * 300)) + text.slice(at + 1);
  const words = ['-1', '1e999', '1e300', '99999999999', 'null', '"x"', '[]', '{}', '0.5', 'true', '""', '[null]', '"\\u0000"', '{"a":{}}'];
  const values = [...text.matchAll(/[:,[](-?[\d.]+|"[^"]*"|true|false|null)(?=[,}\]])/g)];
  const hit = values[Math.floor(rnd() * values.length)];
  return `${text.slice(0, hit.index + 1)}${words[Math.floor(rnd() * words.length)]}${text.slice(hit.index + hit[0].length)}`;
}
