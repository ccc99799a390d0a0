// SPDX-License-Identifier: Apache-2.0
// A server as `rastro view` is one: the page and its scenes on loopback, with a token.
import { readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import type { AddressInfo } from 'node:net';

// The page must work under the rules that the program's own server sends.
export const contentPolicy = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; media-src blob:; "
  + "worker-src blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

export interface Served {
  url: string;
  close: () => void;
}

/** `frame`: of a recording, the block of a frame, or null where it cannot be read. */
export interface ServedScene {
  name: string;
  bytes: Uint8Array;
  frame?: (index: number) => Uint8Array | null;
  /** Of a scene with a tiled layer. */
  tile?: (row: number) => Uint8Array | null;
}

export async function serve(scenes: ServedScene[], token: string): Promise<Served> {
  const server = createServer((request, response) => {
    const url = new URL(request.url!, 'http://localhost');
    const scene = /^\/api\/scene\/(\d+)$/.exec(url.pathname);
    if (url.pathname === '/') return response.setHeader('content-security-policy', contentPolicy).setHeader('content-type', 'text/html').end(readFileSync('dist/viewer.html'));
    if (url.searchParams.get('token') !== token) return response.writeHead(401).end();
    if (url.pathname === '/api/scenes') {
      return response.setHeader('content-type', 'application/json').end(JSON.stringify(scenes.map((s, index) => ({ index, name: s.name, bytes: s.bytes.length, ...(s.frame ? { frames: true } : {}) }))));
    }
    const frame = /^\/api\/frame\/(\d+)\/(\d+)$/.exec(url.pathname);
    if (frame) {
      const block = scenes[Number(frame[1])]?.frame?.(Number(frame[2]));
      return block ? response.end(block) : response.writeHead(404).end('this frame cannot be read');
    }
    const tile = /^\/api\/tile\/(\d+)\/0\/(\d+)$/.exec(url.pathname);
    if (tile) {
      const block = scenes[Number(tile[1])]?.tile?.(Number(tile[2]));
      return block ? response.end(block) : response.writeHead(404).end();
    }
    if (scene && scenes[Number(scene[1])]) return response.end(scenes[Number(scene[1])].bytes);
    return response.writeHead(404).end();
  });
  await new Promise<void>((done) => server.listen(0, '127.0.0.1', done));
  const { port } = server.address() as AddressInfo;
  return { url: `http://127.0.0.1:${port}/`, close: () => (server.closeAllConnections(), server.close()) };
}
