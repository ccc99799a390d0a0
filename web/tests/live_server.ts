// SPDX-License-Identifier: Apache-2.0
// A server as `rastro slam --view` is one: page, map and the messages of a run, written on node's own modules.
import { createHash } from 'node:crypto';
import { readFileSync } from 'node:fs';
import { createServer, type IncomingMessage } from 'node:http';
import type { AddressInfo, Socket } from 'node:net';
import type { Duplex } from 'node:stream';
import { contentPolicy } from './serve';

const guid = '258EAFA5-E914-47DA-95CA-C5AB0DC85B11';

/** One frame of the WebSocket protocol from server to client. */
function packed(opcode: number, payload: Uint8Array): Buffer {
  const n = payload.length;
  const head = n < 126 ? Buffer.from([0x80 | opcode, n]) : n < 65536 ? Buffer.from([0x80 | opcode, 126, n >> 8, n & 255]) : Buffer.alloc(10);
  if (n >= 65536) {
    head[0] = 0x80 | opcode;
    head[1] = 127;
    head.writeBigUInt64BE(BigInt(n), 2);
  }
  return Buffer.concat([head, payload]);
}

/** Texts of the client; its frames are short and masked. */
class Reader {
  private rest = Buffer.alloc(0);

  constructor(private readonly take: (opcode: number, text: string) => void) {}

  add(data: Buffer): void {
    this.rest = Buffer.concat([this.rest, data]);
    while (this.rest.length >= 6 && this.rest.length >= 6 + (this.rest[1] & 127)) {
      const [opcode, n] = [this.rest[0] & 15, this.rest[1] & 127];
      const payload = Buffer.from(this.rest.subarray(6, 6 + n).map((b, i) => b ^ this.rest[2 + (i & 3)]));
      this.rest = this.rest.subarray(6 + n);
      this.take(opcode, payload.toString());
    }
  }
}

export class LiveServer {
  url = '';
  /** Commands as they came. */
  readonly commands: string[] = [];
  scene: Uint8Array | null = null;
  /** How long the server takes for a map. */
  sceneDelayMs = 0;
  fetching = 0;
  mostFetching = 0;
  fetches = 0;
  /** Told to each client at first. */
  greeting: object[] = [];
  onCommand: (command: string) => void = () => {};
  private port = 0;
  private readonly clients = new Set<Duplex>();
  private readonly sockets = new Set<Socket>();
  private server = this.build();

  constructor(readonly token: string) {}

  async open(): Promise<void> {
    await new Promise<void>((done) => this.server.listen(this.port, '127.0.0.1', done));
    this.port = (this.server.address() as AddressInfo).port;
    this.url = `http://127.0.0.1:${this.port}/?token=${this.token}`;
  }

  /** As if the program had ended. */
  async close(): Promise<void> {
    for (const socket of this.sockets) socket.destroy();
    await new Promise((done) => this.server.close(done));
    this.server = this.build();
  }

  send(message: object): void {
    this.sendText(JSON.stringify(message));
  }

  sendText(text: string): void {
    for (const client of this.clients) client.write(packed(1, Buffer.from(text)));
  }

  sendBytes(bytes: Uint8Array): void {
    for (const client of this.clients) client.write(packed(2, bytes));
  }

  get clientCount(): number {
    return this.clients.size;
  }

  private build() {
    const server = createServer((request, response) => {
      const url = new URL(request.url!, 'http://localhost');
      if (url.pathname === '/') return response.setHeader('content-security-policy', contentPolicy).setHeader('content-type', 'text/html').end(readFileSync('dist/viewer.html'));
      if (url.searchParams.get('token') !== this.token) return response.writeHead(401).end();
      if (url.pathname === '/api/scenes') return response.end(JSON.stringify([{ index: 0, name: 'run', bytes: this.scene?.length ?? 0, live: true }]));
      if (url.pathname === '/api/scene/0') return this.serveScene(response);
      return response.writeHead(404).end();
    });
    server.on('connection', (socket) => {
      this.sockets.add(socket);
      socket.on('close', () => this.sockets.delete(socket));
    });
    server.on('upgrade', (request, socket) => this.upgrade(request, socket));
    return server;
  }

  private serveScene(response: import('node:http').ServerResponse): void {
    this.fetches++;
    this.mostFetching = Math.max(this.mostFetching, ++this.fetching);
    setTimeout(() => {
      this.fetching--;
      if (this.scene) response.end(this.scene);
      else response.writeHead(404).end();
    }, this.sceneDelayMs);
  }

  private upgrade(request: IncomingMessage, socket: Duplex): void {
    const url = new URL(request.url!, 'http://localhost');
    if (url.pathname !== '/live' || url.searchParams.get('token') !== this.token) return void socket.destroy();
    const accept = createHash('sha1').update(request.headers['sec-websocket-key'] + guid).digest('base64');
    socket.write(`HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: ${accept}\r\n\r\n`);
    const reader = new Reader((opcode, text) => {
      if (opcode === 8) return void socket.end();
      this.commands.push(text);
      this.onCommand((JSON.parse(text) as { command: string }).command);
    });
    socket.on('data', (data: Buffer) => reader.add(data));
    socket.on('error', () => {});
    socket.on('close', () => this.clients.delete(socket));
    this.clients.add(socket);
    for (const message of this.greeting) socket.write(packed(1, Buffer.from(JSON.stringify(message))));
  }
}
